"""The numbers of a run with several shapes: how each was formed, and how well moving ones were followed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from bringup.scenario import SuccessSpec
from swarm_msgs_py.messages.bodies import Plan
from swarm_msgs_py.plan_course import Course
from swarm_msgs_py.plan_motion import contour_at
from swarm_msgs_py.types import BoolArray, FloatArray, IntArray
from swarm_sim.metrics.displacement import displacement_bound, path_lengths
from swarm_sim.metrics.morphing import MorphMetrics, morph_metrics
from swarm_sim.metrics.settling import settling
from swarm_sim.metrics.trace import Trace

MOMENT = 1e-9  # [s]; times are sums of fractions of a tick
TELLING = 0.5  # share of the time of a motion from which on it shows how far the swarm lags


@dataclass(frozen=True, slots=True)
class MotionResults:
    """How the swarm followed its motions, the worst of them each time.

    Attributes
    ----------
    latency_s : float or None
        Lag behind the shape (spec 14.6) [s]; None if all motions were cut short before half of their time.
    outside, outside_max : float
        Mean and largest share of the robots outside the shape while it moves.
    uncovered : float
        Mean share of the shape's area that is far from every robot while it moves.
    recovery_s : float or None
        From the end of a motion until the swarm fits the shape [s]; None if after some motion it never did, or if none
        came to its end.
    """

    latency_s: float | None
    outside: float
    outside_max: float
    uncovered: float
    recovery_s: float | None


@dataclass(frozen=True, slots=True)
class StageResults:
    """How one shape of several was formed.

    Attributes
    ----------
    settling_s : float or None
        From its order until all were at rest in it, up to the next order [s]; None if they never were.
    displacement_m : float
        How far all robots together drove until then, or to the end where they were not [m].
    bound_m : float or None
        How far they had to drive at least from where they stood when it was ordered [m]; None without goals, or if
        robots died.
    excess_m : float or None
        By how much the paths to the goals that the robots chose are longer, all together [m]: 0 if no exchange between
        robots of a type would have been shorter.
    arrival_s : float or None
        From its order until all were at their goals for good [s]; None if they never were, or there are none.
    """

    settling_s: float | None
    displacement_m: float
    bound_m: float | None = None
    excess_m: float | None = None
    arrival_s: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Ways:
    """What it costs robots to get to goals.

    Attributes
    ----------
    types : (n,) int array
        Of the robots.
    costs : callable
        Returns the shortest paths (n, g) from start points (n, 2) to the goals of a plan [m].
    """

    types: IntArray
    costs: Callable[[FloatArray, Plan], FloatArray]


def motion_results(trace: Trace, course: Course, period_s: float, live: BoolArray) -> MotionResults | None:
    """Evaluate all motions of a run; None if there are none.

    One that another plan or the end of the run cuts short counts up to there, but for its recovery. Its lag counts if
    half of its time was over: before that, the shape may have moved too little to tell one lag from another.

    Parameters
    ----------
    trace : Trace
    course : Course
        The plans of the run.
    period_s : float
        Duration of a tick [s].
    live : (n,) bool array
        The robots that count.
    """
    found = list(_motions(trace, course, period_s, live)) if live.any() else []
    if not found:
        return None
    ended = [metrics.recovery_s for metrics, share in found if share >= 1.0]
    recoveries = [recovery for recovery in ended if recovery is not None]
    motions = [metrics for metrics, _ in found]
    return MotionResults(
        latency_s=max((metrics.latency_s for metrics, share in found if share >= TELLING), default=None),
        outside=max(metrics.outside_mean for metrics in motions),
        outside_max=max(metrics.outside_max for metrics in motions),
        uncovered=max(metrics.uncovered_mean for metrics in motions),
        recovery_s=max(recoveries) if recoveries and len(recoveries) == len(ended) else None,
    )


def _motions(trace: Trace, course: Course, period_s: float, live: BoolArray) -> Iterator[tuple[MorphMetrics, float]]:
    """Yield what each motion was like, and what share of its time it went on, 1 for one that came to its end."""

    def contour_of(time: float) -> FloatArray:
        tick = time / period_s
        return contour_at(course.at(tick), tick)

    plans, times = course.plans, trace.sample_times
    for number, (_, plan) in enumerate(plans):
        if plan.motion is None:
            continue
        begins_s, ends_s = plan.motion.begins * period_s, plan.motion.ends * period_s
        until = plans[number + 1][0] * period_s if number + 1 < len(plans) else np.inf
        last = int(np.searchsorted(times, until + MOMENT, side="right"))
        first = max(int(np.searchsorted(times, begins_s + MOMENT, side="right")) - 1, 0)  # at its beginning, or before
        if last - first < 2 or times[last - 1] <= begins_s + MOMENT:
            continue
        rows, cut_s = slice(first, last), float(times[last - 1])
        evaluated = morph_metrics(
            times[rows],
            trace.positions[rows][:, live],
            contour_of,
            max(begins_s, float(times[first])),
            min(ends_s, cut_s),
        )
        yield evaluated, 1.0 if ends_s <= cut_s + MOMENT else (cut_s - begins_s) / (ends_s - begins_s)


def stage_results(  # noqa: PLR0913, PLR0917 - the record, and what it is measured by
    trace: Trace,
    course: Course,
    ordered: list[int],
    period_s: float,
    success: SuccessSpec,
    ways: Ways | None = None,
) -> tuple[StageResults, ...]:
    """Evaluate each shape of a run, in their order.

    Parameters
    ----------
    trace : Trace
    course : Course
        The plans of the run.
    ordered : list of int
        Tick in which each shape was ordered.
    period_s : float
        Duration of a tick [s].
    success : SuccessSpec
        What counts as at rest, and as at the goal.
    ways : Ways or None
        None: what the goals cost is not asked.
    """
    stages = []
    for window in pairwise([*ordered, len(trace.tick_times)]):
        rest = _stage(trace, course, window, period_s, success)
        if window[0] < window[1]:
            plan = course.at(window[1] - 1)
            if ways is not None:
                rest = _with_choice(rest, trace, plan, window, ways)
            rest = replace(rest, arrival_s=_arrival(trace, plan, window, period_s, success.goal_tolerance_m))
        stages.append(rest)
    return tuple(stages)


def _with_choice(rest: StageResults, trace: Trace, plan: Plan, ticks: tuple[int, int], ways: Ways) -> StageResults:
    """Return the results with what the goals cost that the robots chose, and the cheapest choice."""
    if not plan.task.has_goals or plan.motion is not None or not trace.alive[ticks[1] - 1].all():
        return rest
    costs = ways.costs(trace.tick_positions[ticks[0]], plan)
    bound = displacement_bound(costs, ways.types, plan.goal_types)
    if bound is None:
        return rest
    chosen = trace.goals[ticks[1] - 1]
    if ((chosen < 0) | (chosen >= len(plan.goals))).any():
        return replace(rest, bound_m=bound.total)
    taken = float(costs[np.arange(len(chosen)), chosen].sum())
    excess = taken - bound.total if np.isfinite(taken) else None  # robots may still mean the goals of the shape before
    return replace(rest, bound_m=bound.total, excess_m=excess)


def _arrival(trace: Trace, plan: Plan, ticks: tuple[int, int], period_s: float, tolerance_m: float) -> float | None:
    """Return how long after the order of a shape all were at their goals, to stay there [s]."""
    if not plan.task.has_goals or plan.motion is not None:
        return None
    chosen = trace.goals[ticks[0] : ticks[1]]
    is_known = (chosen >= 0) & (chosen < len(plan.goals))
    places = plan.goals[np.where(is_known, chosen, 0)]
    off = np.linalg.norm(trace.tick_positions[ticks[0] : ticks[1]] - places, axis=2)
    is_there = (is_known & (off <= tolerance_m) | ~trace.alive[ticks[0] : ticks[1]]).all(axis=1)
    away = np.flatnonzero(~is_there)
    first = int(away[-1]) + 1 if len(away) else 0
    return first * period_s if first < len(is_there) else None


def _stage(trace: Trace, course: Course, ticks: tuple[int, int], period_s: float, success: SuccessSpec) -> StageResults:
    if ticks[0] == ticks[1]:
        return StageResults(None, 0.0)  # passed over
    begin_s, end_s = ticks[0] * period_s, ticks[1] * period_s
    rows = np.flatnonzero((trace.sample_times >= begin_s - MOMENT) & (trace.sample_times <= end_s + MOMENT))
    times, live = trace.sample_times[rows], trace.alive[ticks[1] - 1]
    positions, settled = trace.positions[rows], None
    if live.any():
        rest = settling(
            times,
            positions[:, live],
            trace.velocities[rows][:, live],
            course.at(ticks[1] - 1).contour,
            speed_max=success.speed_max_m_s,
            hold=success.hold_s,
        )
        settled = rest.time
    driven = positions if settled is None else positions[times <= settled + MOMENT]
    return StageResults(
        None if settled is None else float(settled - times[0]),
        float(path_lengths(driven, trace.sample_rate).sum()),
    )
