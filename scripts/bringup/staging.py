"""The shapes of a scenario's stages: what each makes of the one before it, written out and tried."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from bringup.scenario import Scenario
from bringup.shape_specs import ShapeSpec, StageSpec
from mission_computer.move import Move
from mission_computer.plan_making import PlanMaker
from mission_computer.stages import Stage
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.geometry.bridges import split
from swarm_msgs_py.geometry.contour import area_centroid
from swarm_msgs_py.messages.bodies import Plan
from swarm_msgs_py.types import FloatArray

MOMENT = 1e-9  # [s]; sums of times need not be exact


class Staging:
    """Makes the contour of one stage after the other.

    Parameters
    ----------
    first : (k, 2) array
        The first shape [m].
    read : callable
        Returns the contour that a `ShapeSpec` describes.
    """

    def __init__(self, first: FloatArray, read: Callable[[ShapeSpec], FloatArray]) -> None:
        self._contour = first
        self._read = read
        self._whole: FloatArray | None = None  # what the halves of the last split make together

    def next(self, spec: StageSpec) -> FloatArray:
        """Return the contour of the next stage, (k, 2) counter-clockwise [m].

        Raises
        ------
        ConfigError
            If there is nothing to join.
        ShapeError
            If the shape cannot be used, or not be split so.
        """
        self._contour = self._made(spec)
        return self._contour

    def _made(self, spec: StageSpec) -> FloatArray:
        if spec.shape is not None:
            self._whole = None
            return self._read(spec.shape)
        if spec.split is not None:
            self._whole = self._contour
            return split(self._contour, math.radians(spec.split.direction_deg), spec.split.gap_m)
        if spec.join:
            if self._whole is None:
                raise ConfigError("nothing to join: no stage before it has split the shape; add one, or remove join")
            whole, self._whole = self._whole, None
            return whole
        center = area_centroid(self._contour)
        if self._whole is not None:
            self._whole = _transformed(self._whole, center, spec)
        return _transformed(self._contour, center, spec)


def _transformed(contour: FloatArray, center: FloatArray, spec: StageSpec) -> FloatArray:
    angle = math.radians(spec.rotate_deg)
    turn = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
    scale = 1.0 if spec.scale is None else spec.scale
    moved: FloatArray = center + scale * (contour - center) @ turn + np.array(spec.translate_m or (0.0, 0.0))
    return moved


def written_shape(spec: ShapeSpec | None, contour: FloatArray, name: str | None) -> ShapeSpec:
    """Return a shape that has its contour written out, so that it depends on no file or library."""
    points = tuple((float(x), float(y)) for x, y in contour)
    return ShapeSpec(name=name, points=points, heading_deg=None if spec is None else spec.heading_deg)


def written_stage(spec: StageSpec, contour: FloatArray) -> StageSpec:
    """Return a stage that has its contour written out, so that it depends on no other stage, file or library."""
    return StageSpec(
        shape=written_shape(spec.shape, contour, "shape" if spec.shape is None else spec.shape.name),
        rotate_deg=spec.rotate_deg if spec.over_s else 0.0,
        over_s=spec.over_s,
        at_s=spec.at_s,
        hold_s=spec.hold_s,
    )


def stage_of(spec: StageSpec, contour: FloatArray) -> Stage:
    """Return a stage as the mission computer is told of it."""
    heading = None if spec.shape is None else heading_of(spec.shape)
    return Stage(contour, spec.over_s, math.radians(spec.rotate_deg), spec.at_s, spec.rest_s, heading)


def heading_of(spec: ShapeSpec) -> float | None:
    """Return the direction that robots are to face in a shape [rad], None if that is left to them."""
    return None if spec.heading_deg is None else math.radians(spec.heading_deg)


def check_time(scenario: Scenario, number: int) -> None:
    """Refuse a stage that cannot be formed before the end, or is to be ordered before the one before it.

    Raises
    ------
    ConfigError
    """
    at_s = scenario.stages[number].at_s
    before = [stage.at_s for stage in scenario.stages[:number] if stage.at_s is not None]
    if at_s is not None and before and at_s < max(before):
        raise ConfigError(f"at_s: {at_s:g} s is before a stage before it ({max(before):g} s); put them in order")
    soonest = _earliest_end_s(scenario, number) + scenario.success.hold_s
    if soonest > scenario.duration_s + MOMENT:
        raise ConfigError(
            f"it cannot have been formed for success.hold_s before {soonest:g} s, and the time limit is"
            f" {scenario.duration_s:g} s; order it sooner, shorten over_s, or raise duration_s"
        )


def _earliest_end_s(scenario: Scenario, number: int) -> float:
    """Return when the shape of a stage is there at the earliest, however fast the robots are [s]."""
    end_s = 0.0
    for stage in scenario.stages[: number + 1]:
        ordered_s = end_s + stage.rest_s if stage.at_s is None else max(end_s, stage.at_s)
        end_s = ordered_s + (scenario.mission.lead_s + stage.over_s if stage.over_s else 0.0)
    return end_s


def stage_plan(scenario: Scenario, maker: PlanMaker, stage: Stage, present: Plan) -> Plan:
    """Return the plan that the mission computer will make for a stage, if it goes well until then.

    Raises
    ------
    ShapeError
        If the shape cannot be used, or cannot get there from the one before it.
    FrameError
        If the plan is too large for the radio.
    """
    if not stage.over_s:
        return maker.for_shape(present.epoch + 1, stage.contour, ())
    period, begins = scenario.sim.period_s, 0 if present.motion is None else present.motion.ends
    move = Move(stage.contour, begins, max(1, round(stage.over_s / period)), period, stage.rotation_rad)
    return maker.for_move(present.epoch + 1, move, present, ())
