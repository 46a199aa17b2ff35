"""The contours of a scenario: read from wherever they come, sized and placed."""

from __future__ import annotations

import math
from collections.abc import Callable

from bringup.layout import robot_types
from bringup.scenario import Scenario
from bringup.shape_specs import ShapeSpec
from mission_computer.shape import Placement, placed_shape, with_room
from swarm_msgs_py.roster import Roster
from swarm_msgs_py.types import FloatArray


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
    if spec.points is None:
        placement = with_room(
            spec.source, placement, Roster.of(robot_types(scenario)), scenario.mission.partition, spec.font
        )
    return placed_shape(spec.source, placement, spec.font, spec.unit)
