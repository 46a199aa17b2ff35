"""The formation family behind the seam of `bringup.family`: how its scenarios are run and accounted for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, replace

import numpy as np

from bringup.compose import ScenarioActors
from bringup.engine import FormationRecord
from bringup.family import Metrics
from bringup.formation_scenes import FormationScenes
from bringup.history import History
from bringup.installation import check_physics
from bringup.labels import distance_text
from bringup.layout import markers
from bringup.origin import Origin
from bringup.resolution import resolve
from bringup.results import FormationMetrics, Outcome, formation_metrics
from bringup.scenario import Scenario
from bringup.scenario_file import dump_scenario
from bringup.supervisor import Supervisor
from bringup.trajectories import trajectory_arrays
from bringup.verdict import Timing, Verdict
from reports.run_record import RunRecord
from swarm_msgs_py.types import NodeId
from swarm_sim.camera.sight import Sight
from swarm_sim.metrics.camera import View, everybody
from swarm_sim.metrics.trace import TraceRecorder


class FormationAccount:
    """Implements `bringup.family.Account`: a recorder of motion, a supervisor, and a history for viewers.

    Parameters
    ----------
    scenario : Scenario
        Resolved.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._scenario = scenario
        robots = tuple(NodeId(robot) for robot in range(scenario.robots.count))
        self.recorder = TraceRecorder(robots, scenario.sim.period_s, camera_view(scenario))
        complete_s = max(scenario.arrivals.values(), default=0) * scenario.sim.period_s
        self.supervisor = Supervisor(
            robots,
            scenario.success,
            scenario.sim.period_s,
            scenario.duration_s,
            complete_s=complete_s,
            is_under_camera=scenario.agent.lps.from_camera,
        )
        self.history = History()

    def take(self, record: FormationRecord) -> Verdict | None:
        """Take in one tick; return the verdict when there is one."""
        self.recorder.record(record.truth, record.reports, record.camera)
        verdict = self.supervisor.watch(record)
        self.history.record(replace(record, alerts=(*record.alerts, *self.alerts)), self.supervisor.course)
        return verdict

    @property
    def ticks(self) -> int:
        """How many ticks were taken."""
        return len(self.recorder)

    @property
    def alerts(self) -> tuple[str, ...]:
        """Who found other goals than the plan's, in the last tick."""
        return self.supervisor.goal_agreement.alerts

    @property
    def status(self) -> str:
        """How many robots are where they are to be."""
        plan = self.supervisor.plan
        place = "at their goals" if plan is None or plan.task.has_goals else "inside the shape"
        return f"{self.supervisor.at_goal:3d} of {self._scenario.robots.count} robots {place}"

    def interrupted(self, time: float) -> Verdict:
        """Return the verdict of a run that the operator ended at `time` [s]."""
        return self.supervisor.interrupted(time)

    def unfinished(self, time: float) -> Verdict:
        """Return the verdict that is on disk while the run goes on, at `time` [s]."""
        return self.supervisor.unfinished(time)

    def metrics(self, engine: str, verdict: Verdict, timing: Timing) -> Metrics:
        """Evaluate the run, finished or not."""
        outcome = Outcome(self.recorder, self.supervisor, verdict, timing)
        found = formation_metrics(self._scenario, engine, outcome)
        return Metrics(asdict(found), tuple(_rows(found)))

    def arrays(self) -> Mapping[str, np.ndarray]:
        """Return what ``trajectories.npz`` holds; see `bringup.trajectories.trajectory_arrays`."""
        return trajectory_arrays(self._scenario, self.recorder, self.supervisor.plan, self.history)

    def figure(self, metrics: Metrics) -> bytes:
        """Return the picture of the run as PNG."""
        # Drawing takes a second to import; a run that was interrupted has no time for it.
        from reports.figures import encoded, make_figure  # noqa: PLC0415

        record = RunRecord(metrics.values, dump_scenario(self._scenario), self.arrays())
        return encoded(make_figure(record, "overview"), "png")


def camera_view(scenario: Scenario) -> View:
    """Return what tells whom the images of a run show."""
    camera = scenario.sim.camera
    return Sight(camera, markers(scenario), scenario.seed).in_view if camera.is_on else everybody


class FormationBehavior:
    """Implements `bringup.family.Behavior`."""

    def check_installation(self, scenario: Scenario) -> None:
        """Refuse a physics back end whose library is not installed."""
        check_physics(scenario)

    def resolve(self, scenario: Scenario, origin: Origin) -> Scenario:
        """Return the scenario with shape and map written out; see `bringup.resolution.resolve`."""
        return resolve(scenario, origin)

    def actors(self, scenario: Scenario) -> ScenarioActors:
        """Return what makes the actors of a resolved scenario."""
        return ScenarioActors(scenario)

    def scenes(self, scenario: Scenario) -> FormationScenes:
        """Return what turns the ticks of a resolved scenario into what onlookers see."""
        return FormationScenes(scenario)

    def account(self, scenario: Scenario) -> FormationAccount:
        """Return the account of a run of a resolved scenario that is about to begin."""
        return FormationAccount(scenario)


def _rows(metrics: FormationMetrics) -> list[tuple[str, str]]:
    settled, bottleneck = _number(metrics.settling_time_s, "s"), _number(metrics.bottleneck_time_s, "s")
    displacement = _number(metrics.total_displacement_m, "m")
    if metrics.displacement_ratio is not None:
        ratio, bound = _number(metrics.displacement_ratio, "", 3), _number(metrics.displacement_lower_bound_m, "m")
        whose = "; of those that live " if metrics.lost_robots else " = "
        displacement += f"{whose}{ratio} x lower bound {bound}"
    traffic = f"{metrics.radio_bytes / 1e6:.2f} MB in {metrics.radio_frames} frames"
    rows = [
        ("settling time", f"{settled} (bottleneck {bottleneck})"),
        ("total displacement", displacement),
        ("collisions", f"{metrics.collisions} (least gap {_number(metrics.min_clearance_m, 'm', 3)})"),
        ("localization error", f"{distance_text(metrics.localization_rmse_m)} rms"),
        ("radio", f"{traffic}, peak {metrics.radio_neighborhood_peak_bps / 1e3:.0f} kbit/s in a neighborhood"),
        ("speed", f"{_number(metrics.real_time_factor, 'x real time')}, start-up {_number(metrics.startup_s, 's')}"),
    ]
    if metrics.stage_settling_s is not None:
        rows.append(("stages settled", ", ".join(_number(each, "s") for each in metrics.stage_settling_s)))
    if metrics.morph_outside_fraction is not None:
        outside, recovery = 100.0 * metrics.morph_outside_fraction, _number(metrics.morph_recovery_s, "s")
        lag = _number(metrics.morph_latency_s, "s")
        rows.append(("moving shape", f"lag {lag}, {outside:.1f} % outside, recovered after {recovery}"))
    return rows


def _number(value: float | None, unit: str, digits: int = 1) -> str:
    return "-" if value is None else f"{value:.{digits}f} {unit}".rstrip()
