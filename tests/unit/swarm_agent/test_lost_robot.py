"""A robot that loses its beacons goes home by itself, and comes back when it is localized again (spec section 6)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from builders import PERIOD, make_agent_inputs, make_plan, make_presence

from swarm_agent.agent import Agent
from swarm_agent.config import AgentConfig
from swarm_agent.localization.config import LostConfig, LostRule, LpsConfig
from swarm_msgs_py.body_codec import decode_body, encode_body
from swarm_msgs_py.frames import decode_frame, encode_frame
from swarm_msgs_py.messages.bodies import CostRow, Plan, Task
from swarm_msgs_py.messages.radio import Hello, Packet, RouteRows
from swarm_msgs_py.messages.report import AgentReport, Mode, Positioning
from swarm_msgs_py.messages.sensing import ImuSample, PositionFix, RangeScan
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.networking.mesh import MeshNetwork
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.roster import Roster
from swarm_msgs_py.step_io import AgentOutputs
from swarm_msgs_py.types import MISSION, FloatArray, NodeId

START = np.array([20.0, 0.0])
GOAL = np.array([[28.0, 6.0]])
WALL = np.array([[9.0, -5.0], [11.0, -5.0], [11.0, 5.0], [9.0, 5.0]])  # between the start and home
BEACONS = {NodeId(7): (3.0, 0.0), NodeId(8): (-3.0, 2.0), NodeId(9): (0.0, -3.0)}
NO_ROWS = RouteRows(*(np.zeros(0, dtype=np.int64),) * 3)
REACH = 6.0  # of the beacons' radios here [m]; home is the origin


class World:
    """Robot 1 with the mission computer in reach everywhere, and three beacons around the origin in reach near home."""

    def __init__(
        self, lost: LostConfig, plan: Plan | None = None, start: FloatArray = START, told_sigma: float = 0.1
    ) -> None:
        config = AgentConfig(lps=LpsConfig(lost=lost))
        told = PositionFix(start, told_sigma)
        self.agent = Agent(NodeId(1), config, THESIS_TYPES[0], PERIOD, start=told)
        self.position, self._velocity, self._acceleration = start.copy(), np.zeros(2), np.zeros(2)
        self.tick = 0
        self.rows: list[tuple[int, list[int]]] = []
        self.track: list[FloatArray] = []
        self.reports: list[AgentReport] = []
        self._radios = {node: MeshNetwork(node, NetworkConfig(), PERIOD) for node in (MISSION, *BEACONS)}
        self._heard: tuple[bytes, ...] = ()
        self._sent: tuple[bytes, ...] = ()
        if plan is not None:
            self.order(plan)

    def step(self, **changes: object) -> AgentOutputs:
        near = [node for node, place in BEACONS.items() if np.hypot(*(self.position - place)) < REACH]
        ranges = np.array([np.hypot(*(self.position - BEACONS[node])) for node in near])
        inputs = make_agent_inputs(
            self.tick,
            imu=ImuSample(self._acceleration, 0.0, 0.0),
            fix=None,
            ranges=RangeScan(np.array(near, dtype=np.int64), ranges),
            inbox=self._heard,
        )
        outputs = self.agent.step(replace(inputs, **changes))
        self._listen(near)
        self._sent = outputs.outbox
        self._record(outputs)
        velocity = np.array([outputs.command.forward, outputs.command.left])
        self._acceleration = (velocity - self._velocity) / PERIOD
        # As the filter expects it: a servo delay after the start of the period.
        delay = LpsConfig().push_delay_s
        self.position = self.position + self._velocity * delay + velocity * (PERIOD - delay)
        self._velocity = velocity
        self.tick += 1
        return outputs

    def order(self, plan: Plan) -> None:
        """Let the mission computer say a plan."""
        self._radios[MISSION].flood(encode_body(plan))

    def overhear(self, frames: tuple[bytes, ...]) -> None:
        """Add frames of somebody else to what is heard in the next tick."""
        self._heard = (*self._heard, *frames)

    def run(self, seconds: float) -> AgentReport:
        for _ in range(round(seconds / PERIOD)):
            outputs = self.step()
        return outputs.report

    def _listen(self, near: list[NodeId]) -> None:
        frames: list[bytes] = []
        for node, radio in self._radios.items():
            if node != MISSION and node not in near:
                continue
            radio.receive(self.tick, self._sent)
            x, y = BEACONS.get(node, (0.0, 0.0))
            presence = make_presence(
                x, y, 0.02, tick=self.tick, is_beacon=node != MISSION, robot_type=0 if node == MISSION else 2, epoch=1
            )
            frames += radio.transmit(self.tick, presence)
        self._heard = tuple(frames)

    def _record(self, outputs: AgentOutputs) -> None:
        self.track.append(self.position.copy())
        self.reports.append(outputs.report)
        for frame in map(decode_frame, outputs.outbox):
            if isinstance(frame, Packet) and frame.origin == 1:
                body = decode_body(frame.body)
                if isinstance(body, CostRow):
                    self.rows.append((self.tick, body.costs.tolist()))

    def first(self, positioning: Positioning) -> int:
        return next(n for n, report in enumerate(self.reports) if report.localization.positioning is positioning)


def plan_with_wall() -> Plan:
    return replace(make_plan(GOAL), obstacles=(WALL,))


@pytest.mark.parametrize("rule", LostRule)
def test_without_beacons_a_robot_is_lost_then_drives_home_around_obstacles_and_takes_part_again(rule: LostRule) -> None:
    # What its commands tell of its velocity keeps its error from growing fast: it begins at the limit.
    world = World(LostConfig(rule=rule, sigma_max_m=0.3), plan_with_wall(), told_sigma=0.29)

    report = world.run(150.0)

    states = [r.localization.positioning for r in world.reports]
    lost, homeward = world.first(Positioning.LOST), world.first(Positioning.RETURN_HOME)
    assert homeward - lost == round(6.0 / PERIOD)
    assert all(
        r.mode is Mode.RETURN_HOME for r, s in zip(world.reports, states, strict=True) if s.name == "RETURN_HOME"
    )
    assert all(r.goal == -1 for r in world.reports if r.mode is Mode.RETURN_HOME)
    back = next(n for n in range(homeward, len(states)) if states[n] is Positioning.LOCALIZED)
    where = world.track[back]
    assert np.hypot(*where) < 1.0 + REACH / 2.0
    assert world.reports[back].goal == 0
    assert world.reports[back].mode in {Mode.TRAVELING, Mode.UNASSIGNED}
    # It kept its body out of the wall on the way, so it took the way around.
    homeward_track = np.array(world.track[homeward:back])
    beside = (homeward_track[:, 0] > 9.0 - 0.15) & (homeward_track[:, 0] < 11.0 + 0.15)
    assert beside.any()
    assert (np.abs(homeward_track[beside, 1]) > 5.0).all()
    assert report.localization.accepted > 0


def test_it_keeps_its_goal_reserved_while_away_and_has_it_again_on_return() -> None:
    world = World(LostConfig(rule=LostRule.BEACONS), plan_with_wall())

    world.run(150.0)

    homeward = world.first(Positioning.RETURN_HOME)
    states = [r.localization.positioning for r in world.reports]
    back = next(n for n in range(homeward, len(states)) if states[n] is Positioning.LOCALIZED)
    before = [costs for tick, costs in world.rows if tick < homeward]
    away = [costs for tick, costs in world.rows if homeward <= tick < back]
    after = [costs for tick, costs in world.rows if tick >= back]
    assert len(before) == 1
    assert before[0][0] == pytest.approx(1000, abs=30)
    assert away == before  # said once: the goal is kept at what it cost, and there is no other
    assert all(costs[0] > 2500 for costs in after)  # if it says anything, then from home, around the wall
    assert world.reports[back].goal == 0


def test_who_has_no_goal_to_keep_withdraws_with_an_empty_row() -> None:
    two_goals = make_plan(np.array([[28.0, 6.0], [28.0, -6.0]]))
    world = World(LostConfig(rule=LostRule.BEACONS, review_period_s=0.5, misses_max=1), two_goals)

    world.run(8.0)

    assert world.reports[-1].mode is Mode.RETURN_HOME
    assert world.rows[-1][1] == []


@pytest.mark.parametrize("task", [Task.FORCES, Task.FORCES_LITERAL])
def test_a_robot_that_forces_drove_astray_returns_home_and_is_driven_again(task: Task) -> None:
    plan = replace(
        make_plan(GOAL[:0]), contour=make_plan(GOAL).contour + np.array([28.0, 0.0]), obstacles=(WALL,), task=task,
        roster=Roster.of(THESIS_TYPES[:2]),
    )  # fmt: skip
    here = replace(plan, contour=make_plan(GOAL).contour, epoch=2)
    world = World(LostConfig(rule=LostRule.BEACONS), plan)
    world.run(3.0)
    assert world.reports[-1].mode in {Mode.TRAVELING, Mode.BLOCKED}
    assert world.position[0] > START[0] + 0.5

    world.order(here)
    world.run(150.0)

    homeward = world.first(Positioning.RETURN_HOME)
    states = [report.localization.positioning for report in world.reports]
    back = next(n for n in range(homeward, len(states)) if states[n] is Positioning.LOCALIZED)
    assert all(report.mode is Mode.RETURN_HOME for report in world.reports[homeward:back])
    assert world.reports[-1].mode is Mode.PARKED
    assert np.abs(world.track[-1]).max() < 4.0


def test_a_robot_at_home_waits_there_for_beacons() -> None:
    far_home = replace(make_plan(GOAL), contour=make_plan(GOAL).contour + np.array([30.0, 0.0]))
    world = World(LostConfig(rule=LostRule.BEACONS), far_home)

    report = world.run(60.0)

    assert report.mode is Mode.RETURN_HOME
    assert np.hypot(*(world.position - [30.0, 0.0])) < 2.5  # near, not at: it hardly knows where it is
    assert np.ptp(np.array(world.track[-20:]), axis=0).max() < 0.05


def test_a_dead_robot_s_body_on_the_home_point_does_not_keep_a_robot_from_returning() -> None:
    home = np.array([30.0, 0.0])
    body = home + [0.0, 0.3] + 0.3 * np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
    plan = replace(make_plan(GOAL), contour=make_plan(GOAL).contour + home, obstacles=(body,))
    world = World(LostConfig(rule=LostRule.BEACONS), plan)

    report = world.run(60.0)

    assert report.mode is Mode.RETURN_HOME
    assert np.hypot(*(world.position - home)) < 1.0


def boxed_in(world: World, seconds: float) -> list[tuple[Mode, bool]]:
    """Run with obstacles all around; return what the robot then does, and whether its hellos ask for way."""
    angles = np.linspace(0.0, 2.0 * np.pi, 8, endpoint=False)
    ring = 0.24 * np.column_stack([np.cos(angles), np.sin(angles)])
    said = []
    for _ in range(round(seconds / PERIOD)):
        outputs = world.step(proximity=ring)
        (hello,) = [frame for frame in map(decode_frame, outputs.outbox) if isinstance(frame, Hello)]
        assert hello.presence.mode == outputs.report.mode
        said.append((outputs.report.mode, hello.presence.asks_for_way))
    return said


def test_a_blocked_robot_asks_for_way_and_stays_visible_as_one_that_returns_home() -> None:
    plan = replace(make_plan(GOAL), contour=make_plan(GOAL).contour + np.array([30.0, 0.0]))
    world = World(LostConfig(rule=LostRule.BEACONS), plan)

    traveling = boxed_in(world, 6.0)
    returning = boxed_in(world, 20.0)

    assert traveling[-1] == (Mode.BLOCKED, True)
    assert (Mode.TRAVELING, False) in traveling
    assert returning[-1] == (Mode.RETURN_HOME, True)


def test_behind_another_robot_that_returned_it_stops_at_the_spacing() -> None:
    plan = replace(
        make_plan(GOAL), contour=make_plan(GOAL).contour + np.array([30.0, 0.0])
    )  # out of the beacons' reach
    world = World(LostConfig(rule=LostRule.BEACONS), plan)
    returned = MeshNetwork(NodeId(3), NetworkConfig(), PERIOD)
    for _ in range(100):
        presence = make_presence(
            30.0, 0.0, 2.0, tick=world.tick, is_beacon=False, mode=int(Mode.RETURN_HOME), robot_type=2
        )
        world.step()
        world.overhear(returned.transmit(world.tick, presence))

    assert world.reports[-1].mode is Mode.RETURN_HOME
    assert 2.0 < np.hypot(*(world.position - [30.0, 0.0])) < 3.1


def test_without_a_plan_there_is_no_home_and_the_robot_searches_for_one() -> None:
    world = World(LostConfig(rule=LostRule.BEACONS))

    report = world.run(30.0)

    assert report.localization.positioning is Positioning.RETURN_HOME
    assert report.mode is Mode.SEARCHING


def test_the_hello_tells_what_a_neighbor_needs() -> None:
    world = World(LostConfig(), plan_with_wall(), told_sigma=0.5)
    world.run(5.0)

    outputs = world.step()

    (hello,) = [frame for frame in map(decode_frame, outputs.outbox) if isinstance(frame, Hello)]
    assert hello.presence.tick == world.tick - 1
    assert not hello.presence.is_beacon
    assert np.allclose(hello.presence.position, outputs.report.position, atol=1e-3)
    assert hello.presence.sigma == pytest.approx(float(np.sqrt(np.trace(outputs.report.covariance) / 2.0)), abs=2e-3)


def test_a_dead_position_sensor_is_no_beacon_to_the_neighbors() -> None:
    agent = Agent(NodeId(1), AgentConfig(), THESIS_TYPES[0], PERIOD)

    said = []
    for tick in range(20):
        outputs = agent.step(make_agent_inputs(tick) if tick < 5 else make_agent_inputs(tick, fix=None))
        (hello,) = [frame for frame in map(decode_frame, outputs.outbox) if isinstance(frame, Hello)]
        said.append(hello.presence.is_beacon)

    assert said == [True] * 11 + [False] * 9


def test_beacons_in_the_hellos_but_not_in_the_routes_are_counted() -> None:
    world = World(LostConfig(rule=LostRule.BEACONS), make_plan(GOAL), start=np.array([0.0, 0.5]))
    world.run(3.0)
    assert world.reports[-1].beacons == 3
    assert world.reports[-1].localization.disagreements == 0

    for number in range(5):  # a radio that is heard and advertises no route, not even to itself
        mute = Hello(NodeId(3), number, make_presence(1.0, 1.0, tick=world.tick), NO_ROWS)
        world.overhear((encode_frame(mute),))
        report = world.step().report

    assert report.beacons == 4
    assert report.localization.disagreements == 5
