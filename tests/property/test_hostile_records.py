"""Whatever well-formed record the radio brings, no robot crashes, and the next real plan gets through."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from builders import make_agent, make_agent_inputs, make_plan, make_presence
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mission_computer.config import MissionConfig
from mission_computer.mission import Mission
from swarm_msgs_py.body_codec import encode_body
from swarm_msgs_py.errors import FrameError
from swarm_msgs_py.frames import encode_frame
from swarm_msgs_py.messages.bodies import Body, CostRow, Objective, Plan, Report, RowBundle, RowRequest, Task
from swarm_msgs_py.messages.control import STOP
from swarm_msgs_py.messages.radio import SIGMA_UNKNOWN, Hello, Packet, Presence, RouteRows
from swarm_msgs_py.messages.report import Mode
from swarm_msgs_py.messages.sensing import PositionFix, RangeScan
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.partition import Method
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.roster import Roster
from swarm_msgs_py.step_io import MissionInputs
from swarm_msgs_py.types import EVERYONE, MISSION, NodeId

PERIOD = 0.5
SQUARE = np.array([[-4.0, -4.0], [4.0, -4.0], [4.0, 4.0], [-4.0, 4.0]])

# Values that mean something to the receiver, and values at the ends of the format.
epochs = st.sampled_from([0, 1, 2, 3, 2**20, 2**31, 2**32 - 1])
ids = st.sampled_from([0, 1, 2, 7, int(MISSION), int(EVERYONE)])
types = st.sampled_from([0, 1, 2, 255])
versions = st.sampled_from([0, 1, 2, 1000, 65535])
coordinates = st.one_of(st.floats(-8.0, 8.0, width=32), st.sampled_from([-1e6, 1e6, 0.0]))


def points(most: int) -> st.SearchStrategy[np.ndarray]:
    return st.integers(0, most).flatmap(lambda n: arrays(np.float64, (n, 2), elements=coordinates))


costs = st.integers(0, 3).flatmap(lambda n: arrays(np.int64, n, elements=versions))
weights = st.sampled_from([1, 256, 65535])
rows = st.builds(CostRow, epochs, ids, types, versions, costs, weights, st.sampled_from(Objective))
plans = st.integers(0, 3).flatmap(
    lambda n: st.builds(
        Plan,
        epochs,
        points(4),
        st.lists(points(4), max_size=2).map(tuple),
        arrays(np.float64, (n, 2), elements=coordinates),
        arrays(np.int64, n, elements=types),
    )
)
kinds = st.lists(st.sampled_from(THESIS_TYPES), min_size=1, max_size=5)
contours = st.one_of(points(5), st.sampled_from([SQUARE, SQUARE[::-1], SQUARE[[0, 2, 1, 3]], SQUARE * 0.01]))
orders = st.builds(
    lambda epoch, contour, obstacles, bodies, task, kinds, method: Plan(
        *(epoch, contour, obstacles, np.empty((0, 2)), np.empty(0, dtype=np.int64), min(bodies, len(obstacles)), task),
        *(Roster.of(kinds), method if task is Task.PARTITION else None),
    ),
    epochs,
    contours,
    st.lists(points(4), max_size=2).map(tuple),
    st.integers(0, 2),
    st.sampled_from([task for task in Task if task is not Task.GOALS]),
    kinds,
    st.sampled_from(Method),
)
records = st.one_of(
    plans,
    orders,
    rows,
    st.lists(rows, max_size=3).map(lambda some: RowBundle(tuple(some))),
    st.builds(RowRequest, epochs, st.lists(st.tuples(ids, versions), max_size=3).map(tuple)),
    st.builds(
        Report, ids, types, epochs, st.integers(-3, 3), st.tuples(coordinates, coordinates), types, st.floats(0.0, 1e4)
    ),
)
presences = st.builds(
    Presence,
    arrays(np.float64, 2, elements=coordinates),
    arrays(np.float64, 2, elements=coordinates),
    st.sampled_from([0.0, 1.0, SIGMA_UNKNOWN]).map(lambda sigma: sigma**2 * np.eye(2)),
    st.sampled_from([0.0, 0.5, 1.0]),
    st.integers(0, 2**32),
    types,
    st.booleans(),
    types,
    epochs,
    versions,
)


class Stranger:
    """A radio nearby that says anything."""

    def __init__(self) -> None:
        self._sequence = 0

    def frames(self, presence: Presence, bodies: Sequence[Body]) -> tuple[bytes, ...]:
        self._sequence += 1
        own = RouteRows(np.array([7]), np.array([0]), np.array([2 * self._sequence]))
        frames = [encode_frame(Hello(NodeId(7), self._sequence, presence, own))]
        for number, body in enumerate(bodies):
            names = self._sequence, EVERYONE, NodeId(7), EVERYONE, self._sequence * 16 + number, 5
            frames.append(encode_frame(Packet(NodeId(7), *names, encode_body(body))))
        return tuple(frames)


utterances = st.lists(st.tuples(presences, st.lists(records, max_size=3)), min_size=1, max_size=5)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(said=utterances)
def test_a_robot_survives_any_record_and_takes_the_next_plan(said: list[tuple[Presence, list[Body]]]) -> None:
    agent, stranger = make_agent(1), Stranger()
    calm = make_presence()
    inboxes = [stranger.frames(calm, [make_plan(SQUARE[:2])]), *(stranger.frames(*words) for words in said), (), ()]
    epoch = 0
    for tick, inbox in enumerate(inboxes):
        outputs = agent.step(make_agent_inputs(tick, inbox=inbox))
        assert np.isfinite([outputs.command.forward, outputs.command.left, outputs.command.yaw_rate]).all()
        assert outputs.report.epoch >= epoch
        epoch = outputs.report.epoch

    real = make_plan(SQUARE, epoch=epoch + 1)
    assert agent.step(make_agent_inputs(len(inboxes), inbox=stranger.frames(calm, [real]))).report.epoch == epoch + 1


@settings(max_examples=100, deadline=None, derandomize=True)
@given(order=orders, x=st.floats(-12.0, 12.0))
def test_a_robot_survives_any_shape_that_it_is_to_partition_or_to_be_driven_into(order: Plan, x: float) -> None:
    agent, stranger = make_agent(1), Stranger()
    fix = PositionFix(np.array([x, 1.0]), 0.02)
    for tick in range(4):
        said = [replace(order, epoch=2)] if tick == 0 else []
        inputs = make_agent_inputs(tick, fix=fix, inbox=stranger.frames(make_presence(tick=tick), said))
        outputs = agent.step(inputs)
        command = outputs.command
        assert np.isfinite([command.forward, command.left, command.yaw_rate]).all()
        assert np.hypot(command.forward, command.left) <= 0.5 + 1e-9

    real = make_plan(SQUARE, epoch=3)
    assert agent.step(make_agent_inputs(4, fix=fix, inbox=stranger.frames(make_presence(), [real]))).report.epoch == 3


@settings(max_examples=40, deadline=None, derandomize=True)
@given(said=utterances)
def test_a_mission_computer_survives_any_record_and_its_next_plan_is_one_that_robots_take(
    said: list[tuple[Presence, list[Body]]],
) -> None:
    roster = Roster.of([THESIS_TYPES[0]] * 3)
    mission, stranger = Mission(MissionConfig(), NetworkConfig(), roster, (), SQUARE, PERIOD), Stranger()
    newest = 0
    for tick, words in enumerate(said):
        outputs = mission.step(MissionInputs(tick, tick * PERIOD, stranger.frames(*words), None))
        assert newest <= outputs.report.epoch <= newest + 2**20 + 1
        newest = outputs.report.epoch

    ordered = mission.step(MissionInputs(len(said), len(said) * PERIOD, (), SQUARE + 1.0))

    assert ordered.plan is not None
    assert newest < ordered.plan.epoch <= newest + 2**20 + 1


@settings(max_examples=60, deadline=None, derandomize=True)
@given(numbers=st.lists(st.floats(width=32), min_size=4, max_size=4))
def test_what_is_no_place_never_leaves_or_enters_a_radio(numbers: list[float]) -> None:
    presence = make_presence(position=np.array(numbers[:2]), velocity=np.array(numbers[2:]))
    is_place = bool((np.abs(numbers) <= 1e6).all())

    try:
        Stranger().frames(presence, [])
    except FrameError:
        assert not is_place
    else:
        assert is_place


def test_a_robot_survives_rows_that_speak_for_it_with_ever_higher_versions() -> None:
    agent, stranger = make_agent(1), Stranger()
    agent.step(make_agent_inputs(0, inbox=stranger.frames(make_presence(), [make_plan(SQUARE[:2])])))
    for tick, first in enumerate(range(1000, 65536, 10_000), start=1):
        forged = [CostRow(1, NodeId(1), 1, version, np.array([5, 5])) for version in range(first, first + 9001, 1000)]
        forged += [CostRow(1, NodeId(1), 1, 65535, np.array([5, 5]))] * (first > 60_000)
        calm = make_presence(tick=tick)
        inbox = stranger.frames(calm, [row for row in forged if row.version <= 65535])
        rows_held = agent.step(make_agent_inputs(tick, inbox=inbox)).report.rows

    assert rows_held == 1


def test_a_robot_survives_rows_of_more_robots_than_it_could_list() -> None:
    agent, stranger = make_agent(1), Stranger()
    nothing = np.empty(0, dtype=np.int64)
    for tick in range(12):
        crowd = RowBundle(tuple(CostRow(1, NodeId(tick * 5000 + n), 1, 1, nothing) for n in range(4500)))
        said: list[Body] = [make_plan(SQUARE[:2])] if tick == 0 else [crowd] if tick < 5 else []
        other_rows = make_presence(tick=tick, epoch=1, digest=7)
        rows_held = agent.step(make_agent_inputs(tick, inbox=stranger.frames(other_rows, said))).report.rows

    assert rows_held > 5000


def test_a_robot_survives_beacons_at_the_edge_of_the_world() -> None:
    agent = make_agent(1)
    edge = np.array([1e6, 1e6])
    beacons = edge - [[0.0, 0.0], [0.0, 5.0], [5.0, 0.0]]
    for tick in range(20):
        inbox = []
        for number, place in enumerate(beacons):
            node = NodeId(number + 2)
            own = RouteRows(np.array([node]), np.array([0]), np.array([2 * tick + 2]))
            inbox.append(encode_frame(Hello(node, tick, make_presence(*place, tick=tick), own)))
        ranges = RangeScan(np.arange(2, 5), np.linalg.norm(beacons - (edge + 4.0), axis=1))
        outputs = agent.step(make_agent_inputs(tick, fix=None, ranges=ranges, inbox=tuple(inbox)))

    assert outputs.report.mode is Mode.WAITING
    assert outputs.command == STOP
