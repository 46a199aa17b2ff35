"""The contours of a scenario: read from wherever they come, sized and placed."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from bringup.layout import robot_types
from bringup.scenario import Scenario
from bringup.shape_specs import ShapeSpec
from mission_computer.shape import Placement, is_drawing, placed_shape
from swarm_msgs_py.geometry.contour import signed_area
from swarm_msgs_py.partition import needed_scale
from swarm_msgs_py.roster import Roster
from swarm_msgs_py.types import FloatArray

ROOM_M2 = 6.0
"""Area per robot of shapes that are made as large as robots need; in the thesis, 50 are on 270 to 320 m^2."""

COMFORT = 1.1
"""By how much a shape is made larger than the smallest size that robots fit in."""


def reader(scenario: Scenario) -> Callable[[ShapeSpec], FloatArray]:
    """Return what reads the shapes of a scenario."""
    return lambda spec: contour_from(spec, scenario)


def contour_from(spec: ShapeSpec, scenario: Scenario) -> FloatArray:
    """Return the contour that a scenario's shape describes, (k, 2) counter-clockwise [m].

    Raises
    ------
    ShapeError
        One line that names the source, what is wrong and what to do.
    """
    placement = Placement(
        fit=spec.fit_m,
        area=spec.area_m2,
        scale=spec.scale,
        rotation=math.radians(spec.rotation_deg),
        center=spec.center_m,
        translation=spec.translation_m,
    )
    if is_drawing(spec.source) and spec.points is None:
        placement = replace(placement, center=spec.center_m or (0.0, 0.0))
        if spec.fit_m is None and spec.area_m2 is None:
            placement = replace(placement, area=_roomy_area(spec, scenario))
    return placed_shape(spec.source, placement, spec.font)


def _roomy_area(spec: ShapeSpec, scenario: Scenario) -> float:
    """Return how large a shape without a unit of length has to be for all robots of a scenario [m^2]."""
    roster = Roster.of(robot_types(scenario))
    area = ROOM_M2 * roster.size
    contour = placed_shape(spec.source, Placement(area=area), spec.font)
    factor = needed_scale(contour, roster, scenario.mission.partition)
    if factor is not None and factor > 1.0:
        area = signed_area(contour) * (COMFORT * factor) ** 2
    return area
