"""A small swarm with ideal radio whose shape changes on the way, and what came of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import shapely

from bringup.compose import ScenarioActors
from bringup.engine import TickRecord
from bringup.inprocess import InProcessEngine
from bringup.resolution import resolve
from bringup.scenario import Scenario
from bringup.scenario_file import load_scenario, method_overrides, parse_assignment
from bringup.supervisor import Supervisor, Verdict
from swarm_msgs_py.messages.bodies import Plan
from swarm_msgs_py.plan_motion import contour_at

YARD = """
name: moving
duration_s: 150.0
shape: {points: [[-4, -4], [4, -4], [4, 4], [-4, 4]]}
map:
  bounds_m: [-20.0, -20.0, 20.0, 20.0]
robots:
  types: [{type: 1, count: 3}, {type: 2, count: 3}, {type: 3, count: 3}]
  start: {half_side_m: 6.0}
  position_sensor_share: 1.0
sim:
  physics: {backend: massdamper}
  terrain: {ground: plane}
  fix: {sigma_m: 0.0}
  radio: {model: ideal}
  ranging: {period_s: 600.0}
agent:
  lps: {wall_sigma_m: null, command_sigma_mps: null, gate_chi_square: 1.0e+9}
mission: {lead_s: 2.0}
"""


@dataclass(frozen=True, eq=False)
class Ran:
    """A run to its verdict."""

    records: list[TickRecord]
    supervisor: Supervisor
    verdict: Verdict

    @property
    def plans(self) -> list[Plan]:
        """All plans, in their order."""
        return [record.plan for record in self.records if record.plan is not None]

    @property
    def alerts(self) -> list[str]:
        """All alerts, in their order."""
        return [alert for record in self.records for alert in record.alerts]

    def outside(self, record: TickRecord, contour: np.ndarray) -> float:
        """Return the share of the live robots that are outside a contour at the end of a tick."""
        places = record.truth.samples[-1][record.truth.alive]
        return 1.0 - float(shapely.contains_xy(shapely.Polygon(contour), places[:, 0], places[:, 1]).mean())

    def outside_in_motion(self) -> list[float]:
        """Return that share for each tick in which the shape moves."""
        course = self.supervisor.course
        shares = []
        for record in self.records:
            plan = course.at(record.tick + 1)
            motion = plan.motion
            if motion is not None and motion.begins <= record.tick + 1 <= motion.ends:
                shares.append(self.outside(record, contour_at(plan, record.tick + 1)))
        return shares


def moving_scenario(folder: Path, stages: str, *settings: str, method: str = "bubble-packing") -> Scenario:
    """Return the small swarm's scenario with stages, written as YAML, and settings on top."""
    path = folder / "moving.yaml"
    path.write_text(f"{YARD}stages: {stages}\n", encoding="utf-8")
    overrides = (*method_overrides(method), *map(parse_assignment, settings))
    return resolve(*load_scenario(str(path), overrides))


def ran(scenario: Scenario, watch: Callable[[TickRecord], object] = lambda _: None) -> Ran:
    """Run a scenario to its verdict; `watch` sees every tick."""
    actors = ScenarioActors(scenario)
    supervisor = Supervisor(actors.robots, scenario.success, scenario.sim.period_s, scenario.duration_s)
    records = []
    with InProcessEngine(actors) as engine:
        for record in _ticks(engine):
            records.append(record)
            watch(record)
            verdict = supervisor.watch(record)
            if verdict is not None:
                return Ran(records, supervisor, verdict)
    raise AssertionError("the engine ended by itself")


def _ticks(engine: InProcessEngine) -> Iterator[TickRecord]:
    return engine.ticks()
