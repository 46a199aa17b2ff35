"""Boats as ROS nodes: the same assembly as in one process, byte for byte."""

from __future__ import annotations

import numpy as np
import pytest

from bringup.assembly.scenario import AssemblyScenario
from bringup.families import BEHAVIORS
from bringup.family import Family
from bringup.inprocess import InProcessEngine
from bringup.ros_engine import RosEngine
from bringup.scenario_file import load_any, parse_assignment
from swarm_msgs_py.assembly.boat_io import AssemblyInputs
from swarm_msgs_py.assembly.faces import Face
from swarm_msgs_py.ros.assembly_dialect import ASSEMBLY
from swarm_msgs_py.types import NodeId

pytestmark = pytest.mark.usefixtures("domain_id")


@pytest.mark.usefixtures("nothing_left")
@pytest.mark.parametrize(("navigation", "tick_count"), [("timed", 30), ("decentralized", 90)])
def test_both_engines_move_boats_alike(navigation: str, tick_count: int) -> None:
    settings = ("sim.bodies=planar", f"navigation={navigation}")
    assignments = tuple(parse_assignment(text, AssemblyScenario) for text in settings)
    scenario, origin = load_any("assembly-square", assignments)
    behavior = BEHAVIORS[Family.ASSEMBLY]
    resolved = behavior.resolve(scenario, origin)
    tracks = []
    for engine in (InProcessEngine(behavior.actors(resolved)), RosEngine(behavior.actors(resolved))):
        with engine:
            ticks = engine.ticks()
            tracks.append(np.array([next(ticks).truth.ends for _ in range(tick_count)]))

    assert tracks[0].tobytes() == tracks[1].tobytes()
    assert np.ptp(tracks[0], axis=0).max() > 0.5


def test_what_a_boat_senses_survives_the_message_exactly() -> None:
    inputs = AssemblyInputs(
        tick=7,
        time=1.75,
        pose=np.array([0.1, -2.0 / 3.0, 3.1]),
        reference=np.array([0.25, -0.5, np.pi]),
        contacts=frozenset({Face.UP, Face.RIGHT}),
        inbox=(),
        seen=np.array([[0.5, -1.0 / 3.0], [0.75, 0.0]]),
    )
    (sense,) = ASSEMBLY.senses

    tick, reading = sense.decode(sense.encode(b"", NodeId(3), inputs), 0.25)
    joined = ASSEMBLY.join(tick, 1.75, {sense.part: reading}, ())

    assert (joined.tick, joined.contacts) == (7, inputs.contacts)
    assert np.array_equal(joined.pose, inputs.pose)
    assert np.array_equal(joined.seen, inputs.seen)
    assert np.array_equal(joined.reference, inputs.reference)
