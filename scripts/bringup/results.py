"""The numbers of a run, as ``metrics.json`` holds them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from bringup.layout import robot_types, sensor_carriers, walls
from bringup.scenario import Scenario
from bringup.stage_results import Ways, motion_results, stage_results
from bringup.supervisor import Supervisor
from bringup.verdict import Timing, Verdict
from swarm_agent.planning.path_planner import lower_bound_planner
from swarm_msgs_py.geometry.mesh_quality import MeshQuality, mesh_quality
from swarm_msgs_py.messages.bodies import Plan
from swarm_msgs_py.messages.report import Positioning
from swarm_msgs_py.types import BoolArray, FloatArray
from swarm_sim.metrics.camera import heading_errors
from swarm_sim.metrics.displacement import displacement_bound, path_lengths
from swarm_sim.metrics.localization import LocalizationError, localization_error
from swarm_sim.metrics.settling import Settling, settling
from swarm_sim.metrics.trace import Trace, TraceRecorder

__all__ = ["WARM_UP_S", "FormationMetrics", "Outcome", "Timing", "formation_metrics", "path_costs"]

WARM_UP_S = 60.0  # spec 14.5: before it, robots are still finding out where they are; of short runs, half


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """A run that is over.

    Attributes
    ----------
    recorder : TraceRecorder
    supervisor : Supervisor
    verdict : Verdict
    timing : Timing
    """

    recorder: TraceRecorder
    supervisor: Supervisor
    verdict: Verdict
    timing: Timing


@dataclass(frozen=True, slots=True, kw_only=True)
class FormationMetrics:
    """All keys of ``metrics.json`` of a formation run; None is a number that does not apply.

    The first group is common to all families, the second belongs to formation, the third is beyond the contract.

    ``total_displacement_m`` counts every robot. ``displacement_lower_bound_m`` is what the robots that live at the end
    needed at least to reach goals of the last plan from their start points; ``displacement_ratio`` divides the
    displacement of the same robots by it. Where the plan has no goals, the places where they ended stand for them, and
    ``goals_reached`` counts robots inside the shape. After a change of the shape, bound, ratio and
    ``bottleneck_time_s`` are None, and ``settling_time_s`` is when the last shape stood.

    ``goals_agreed`` says whether robots that found their goals by themselves found those of the mission computer; None
    where the plan names the goals, or has none.

    The fourth group is of runs with several shapes, None in others: of shapes that move, the worst over all motions
    (spec 14.6), up to where they were cut short, ``morph_recovery_s`` None if the swarm never fitted the shape again;
    of stages, one number each: from its order until all were at rest in it, how far all robots drove for it, how far
    they had to at least, by how much the goals that they chose are farther than that, and from its order until all were
    at their goals for good.

    The fifth group is of runs under a camera, None in others: images taken, and the share of
    them that was refused as a whole; of the robots wholly in view, the share that was found; fixes that are nowhere
    near their robot; errors of the other fixes; and, over all robots and ticks, of the headings that robots
    believed in.
    """

    scenario: str
    family: str
    method: str
    seed: int
    engine: str
    physics: str
    robots: int
    achieved: bool
    reason: str
    ticks: int
    sim_time_s: float
    wall_time_s: float
    real_time_factor: float | None
    startup_s: float
    total_displacement_m: float
    displacement_lower_bound_m: float | None
    settling_time_s: float | None
    collisions: int
    min_clearance_m: float | None
    localization_rmse_m: float | None
    localization_max_m: float | None
    radio_frames: int
    radio_bytes: int
    radio_peak_bps: float
    radio_neighborhood_peak_bps: float
    lost_robots: int

    mesh_topological: float | None
    mesh_geometrical: float | None
    goals_reached: int

    displacement_ratio: float | None
    bottleneck_time_s: float | None
    inside_fraction: float | None
    speed_p90_m_s: float | None
    localization_p99_m: float | None
    localization_consistent: float | None
    localization_rmse_heard_m: float | None
    localization_rmse_lost_m: float | None
    radio_dropped_frames: int
    mesh_topological_interior: float | None
    mesh_geometrical_cells: float | None
    cell_area_variation: float | None
    gap_variation: float | None
    covered_fraction: float | None
    goals_agreed: bool | None

    morph_latency_s: float | None = None
    morph_outside_fraction: float | None = None
    morph_outside_max: float | None = None
    morph_uncovered_mean: float | None = None
    morph_recovery_s: float | None = None
    stage_settling_s: tuple[float | None, ...] | None = None
    stage_displacement_m: tuple[float, ...] | None = None
    stage_bound_m: tuple[float | None, ...] | None = None
    stage_excess_m: tuple[float | None, ...] | None = None
    stage_arrival_s: tuple[float | None, ...] | None = None

    camera_images: int | None = None
    camera_unread_fraction: float | None = None
    camera_detected_fraction: float | None = None
    camera_false_fixes: int | None = None
    camera_position_rmse_m: float | None = None
    camera_position_max_m: float | None = None
    camera_heading_rmse_deg: float | None = None
    camera_heading_max_deg: float | None = None
    heading_rmse_deg: float | None = None
    heading_max_deg: float | None = None


def formation_metrics(scenario: Scenario, engine: str, outcome: Outcome) -> FormationMetrics:
    """Evaluate a run of a resolved scenario, finished or not."""
    trace, totals = outcome.recorder.trace(), outcome.recorder.totals()
    verdict, timing, plan = outcome.verdict, outcome.timing, outcome.supervisor.plan
    live = _live(trace)
    rest = _settling(scenario, trace, plan, live)
    displacements = _displacements(trace, rest.time if rest else None)
    # A shape that changed on the way cost more than the last one needs; there is no fair bound for it.
    bound, longest = (None, None) if outcome.supervisor.has_changed_shape else _bound(scenario, trace, plan, live)
    quality = _quality(scenario, trace, plan, live)
    blind = _blind(scenario, trace)
    localization = _localization(trace, blind)
    heard, lost = trace.beacons >= scenario.agent.lps.lost.beacons_min, trace.positioning > Positioning.LOCALIZED
    sim_time = len(trace.tick_times) * scenario.sim.period_s
    metrics = FormationMetrics(
        scenario=scenario.name,
        family=scenario.family.value,
        method=scenario.method,
        seed=scenario.seed,
        engine=engine,
        physics=scenario.sim.physics.backend.value,
        robots=scenario.robots.count,
        achieved=verdict.achieved,
        reason=verdict.reason,
        ticks=len(trace.tick_times),
        sim_time_s=sim_time,
        wall_time_s=timing.wall_time_s,
        real_time_factor=sim_time / timing.wall_time_s if timing.wall_time_s > 0.0 else None,
        startup_s=timing.startup_s,
        total_displacement_m=float(displacements.sum()),
        displacement_lower_bound_m=bound,
        settling_time_s=rest.time if rest else None,
        collisions=totals.contacts,
        min_clearance_m=totals.min_clearance,
        localization_rmse_m=localization.rmse,
        localization_max_m=localization.maximum,
        radio_frames=totals.radio_frames,
        radio_bytes=totals.radio_bytes,
        radio_peak_bps=totals.radio_peak_bps,
        radio_neighborhood_peak_bps=totals.radio_neighborhood_peak_bps,
        lost_robots=int((~live).sum()),
        mesh_topological=quality.topological if quality else None,
        mesh_geometrical=quality.geometrical if quality else None,
        goals_reached=outcome.supervisor.at_goal,
        displacement_ratio=float(displacements[live].sum()) / bound if bound else None,
        bottleneck_time_s=longest / scenario.agent.control.speed_max_m_s if longest is not None else None,
        inside_fraction=rest.inside_fraction if rest else None,
        speed_p90_m_s=rest.speed_p90 if rest else None,
        localization_p99_m=localization.p99,
        localization_consistent=localization.consistent,
        localization_rmse_heard_m=_localization(trace, blind & heard).rmse,
        localization_rmse_lost_m=_localization(trace, blind & lost).rmse,
        radio_dropped_frames=totals.radio_dropped,
        mesh_topological_interior=quality.topological_interior if quality else None,
        mesh_geometrical_cells=quality.geometrical_cells if quality else None,
        cell_area_variation=quality.area_variation if quality else None,
        gap_variation=quality.gap_variation if quality else None,
        covered_fraction=quality.covered_fraction if quality else None,
        goals_agreed=outcome.supervisor.goal_agreement.agreed,
    )
    return _of_several_shapes(_of_camera(metrics, outcome, trace), scenario, outcome.supervisor, trace, live)


def _of_camera(metrics: FormationMetrics, outcome: Outcome, trace: Trace) -> FormationMetrics:
    """Return the metrics with those of the camera, if there was one."""
    camera = outcome.recorder.camera
    if not camera.images:
        return metrics
    places, headings = camera.position_errors, np.rad2deg(camera.heading_errors)
    believed = np.rad2deg(heading_errors(trace.headings, trace.yaws)[trace.alive])
    believed = believed[np.isfinite(believed)]
    return replace(
        metrics,
        camera_images=camera.images,
        camera_unread_fraction=camera.unread / camera.images,
        camera_detected_fraction=camera.found / camera.in_view if camera.in_view else None,
        camera_false_fixes=camera.false_fixes,
        camera_position_rmse_m=_rms(places),
        camera_position_max_m=float(places.max()) if len(places) else None,
        camera_heading_rmse_deg=_rms(headings),
        camera_heading_max_deg=float(np.abs(headings).max()) if len(headings) else None,
        heading_rmse_deg=_rms(believed),
        heading_max_deg=float(np.abs(believed).max()) if len(believed) else None,
    )


def _rms(errors: FloatArray) -> float | None:
    return float(np.sqrt((errors**2).mean())) if len(errors) else None


def _of_several_shapes(
    metrics: FormationMetrics, scenario: Scenario, supervisor: Supervisor, trace: Trace, live: np.ndarray
) -> FormationMetrics:
    """Return the metrics with those of stages and motions, where there are any."""
    period = scenario.sim.period_s
    motion = motion_results(trace, supervisor.course, period, live)
    if motion is not None:
        metrics = replace(
            metrics,
            morph_latency_s=motion.latency_s,
            morph_outside_fraction=motion.outside,
            morph_outside_max=motion.outside_max,
            morph_uncovered_mean=motion.uncovered,
            morph_recovery_s=motion.recovery_s,
        )
    if not scenario.stages:
        return metrics
    ways = Ways(np.array([kind.type for kind in robot_types(scenario)], dtype=np.int64), partial(path_costs, scenario))
    stages = stage_results(trace, supervisor.course, supervisor.stages, period, scenario.success, ways)
    return replace(
        metrics,
        stage_settling_s=tuple(stage.settling_s for stage in stages),
        stage_displacement_m=tuple(stage.displacement_m for stage in stages),
        stage_bound_m=tuple(stage.bound_m for stage in stages),
        stage_excess_m=tuple(stage.excess_m for stage in stages),
        stage_arrival_s=tuple(stage.arrival_s for stage in stages),
    )


def path_costs(scenario: Scenario, starts: FloatArray, plan: Plan) -> FloatArray:
    """Return the shortest obstacle-free path from each start to each goal, (n, g), inf where there is none [m].

    Obstacles are grown by less than the robots' radius, so that no robot can do better. Bodies of lost robots, which
    the plan has among its obstacles, were not there from the start and do not count.
    """
    obstacles = walls(scenario)
    costs = np.full((len(starts), len(plan.goals)), np.inf)
    for robot, kind in enumerate(robot_types(scenario)):
        planner = lower_bound_planner(obstacles, kind.coverage_radius_m)
        mine = plan.goal_types == kind.type
        costs[robot, mine] = planner.costs(starts[robot], plan.goals[mine])
    return costs


def _live(trace: Trace) -> np.ndarray:
    """Return who was alive in the last tick, (n,) bool; everybody before the first."""
    return trace.alive[-1] if len(trace.alive) else np.ones(len(trace.robots), dtype=bool)


def _settling(scenario: Scenario, trace: Trace, plan: Plan | None, live: np.ndarray) -> Settling | None:
    if plan is None or not live.any() or not len(trace.sample_times):
        return None
    return settling(
        trace.sample_times,
        trace.positions[:, live],
        trace.velocities[:, live],
        plan.contour,
        speed_max=scenario.success.speed_max_m_s,
        hold=scenario.success.hold_s,
    )


def _displacements(trace: Trace, settled: float | None) -> FloatArray:
    """Return how far each robot drove until settling, or to the end where nothing settled, (n,) [m]."""
    end = len(trace.sample_times) if settled is None else int(np.searchsorted(trace.sample_times, settled)) + 1
    return path_lengths(trace.positions[:end], trace.sample_rate)


def _bound(scenario: Scenario, trace: Trace, plan: Plan | None, live: np.ndarray) -> tuple[float | None, float | None]:
    """Return the displacement bound of the robots that live, and the longest path in it [m]."""
    if plan is None or not len(trace.positions) or not live.any():
        return None, None
    types = np.array([kind.type for kind in robot_types(scenario)], dtype=np.int64)
    if not plan.task.has_goals:
        plan = replace(plan, goals=trace.positions[-1, live], goal_types=types[live])
    costs = path_costs(scenario, trace.positions[0], plan)
    bound = displacement_bound(costs[live], types[live], plan.goal_types)
    return (bound.total, bound.longest) if bound else (None, None)


def _quality(scenario: Scenario, trace: Trace, plan: Plan | None, live: np.ndarray) -> MeshQuality | None:
    if plan is None or not live.any() or not len(trace.positions):
        return None
    radii = np.array([kind.coverage_radius_m for kind in robot_types(scenario)])
    return mesh_quality(trace.positions[-1, live], radii[live], plan.contour)


def _blind(scenario: Scenario, trace: Trace) -> BoolArray:
    """Return, (t, n), the live robots without position sensor after the warm-up; all live ones if all carry one."""
    carriers = sensor_carriers(scenario)
    blind = np.array([robot not in carriers for robot in range(scenario.robots.count)])
    if not blind.any():
        return trace.alive
    warm_up = min(WARM_UP_S, 0.5 * float(trace.tick_times[-1])) if len(trace.tick_times) else WARM_UP_S
    counted: BoolArray = trace.alive & blind & (trace.tick_times >= warm_up)[:, None]
    return counted


def _localization(trace: Trace, counts: BoolArray) -> LocalizationError:
    return localization_error(trace.estimates, trace.covariances, trace.tick_positions, counts)
