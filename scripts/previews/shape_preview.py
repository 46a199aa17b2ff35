"""What becomes of a shape: its contour, whether the robots fit, and where they would stand."""

from __future__ import annotations

from dataclasses import dataclass

import shapely

from bringup.layout import robot_types, walls
from bringup.resolution import with_map
from bringup.scenario import Scenario
from bringup.shaping import contour_from
from mission_computer.shape import check_inside
from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.geometry.contour import area_centroid, signed_area
from swarm_msgs_py.geometry.mesh_quality import MeshQuality, mesh_quality
from swarm_msgs_py.partition import GoalSet, needed_scale, partition
from swarm_msgs_py.roster import Roster
from swarm_msgs_py.types import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class ShapePreview:
    """A shape, looked at.

    Attributes
    ----------
    label : str
        What to call the shape.
    contour : (k, 2) array
        Counter-clockwise [m].
    roster : Roster
        The robots that it is to hold.
    goals : GoalSet or None
        Where they would stand; None if they do not fit.
    quality : MeshQuality or None
        Of the goals as a mesh.
    problem : str
        Why they do not fit, or why the shape cannot be used in the arena; "" if all is well.
    scale_needed : float or None
        By how much the shape has to be scaled for the robots, 1 if it is large enough; None if that does not help.
    """

    label: str
    contour: FloatArray
    roster: Roster
    goals: GoalSet | None
    quality: MeshQuality | None
    problem: str
    scale_needed: float | None

    @property
    def fits(self) -> bool:
        """Whether the shape can be formed where it is, by these robots."""
        return not self.problem

    @property
    def area(self) -> float:
        """Area inside the contour [m^2]."""
        return signed_area(self.contour)

    def summary(self) -> dict[str, object]:
        """Return the numbers as plain data, units in the names."""
        low, high = self.contour.min(axis=0), self.contour.max(axis=0)
        quality = self.quality
        return {
            "shape": self.label,
            "vertices": len(self.contour),
            "area_m2": round(self.area, 3),
            "center_m": [round(float(number), 3) for number in area_centroid(self.contour)],
            "size_m": [round(float(number), 3) for number in high - low],
            "length_m": round(float(shapely.Polygon(self.contour).length), 3),
            "robots": self.roster.size,
            "fits": self.fits,
            "problem": self.problem,
            "scale_needed": self.scale_needed,
            "mesh_topological": None if quality is None else quality.topological_interior,
            "mesh_geometrical": None if quality is None else quality.geometrical,
            "covered_fraction": None if quality is None else quality.covered_fraction,
        }


def look_at(scenario: Scenario) -> ShapePreview:
    """Return the preview of a scenario's first shape.

    Raises
    ------
    ShapeError
        If there is no contour to look at.
    ConfigError
        If the map cannot be read.
    """
    contour = contour_from(scenario.shape, scenario)
    roster, config = Roster.of(robot_types(scenario)), scenario.mission.partition
    goals, quality, problem = None, None, ""
    scenario = with_map(scenario)
    assert scenario.map.bounds_m is not None  # just read
    try:
        goals = partition(contour.round(2), roster, walls(scenario), config)
        quality = mesh_quality(goals.positions, roster.radii_of(goals.types), contour)
        check_inside(contour, scenario.map.bounds_m, f"'{scenario.shape.label}'")
    except ShapeError as error:
        problem = str(error)
    return ShapePreview(
        scenario.shape.label, contour, roster, goals, quality, problem, needed_scale(contour, roster, config)
    )
