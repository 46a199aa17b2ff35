"""Swarms of point robots under forces: they end inside, at rest, clear of each other and of walls."""

from __future__ import annotations

import numpy as np
import pytest
from force_swarm import Outcome, field_obstacles, field_radii, form, scattered

from mission_computer.shape import load_shape
from swarm_agent.forces.config import ForceConfig, ForceLawName
from swarm_agent.forces.registry import law_for
from swarm_agent.planning.config import PlanningConfig
from swarm_msgs_py.geometry.mesh_quality import mesh_quality

CONFIG = ForceConfig()
LITERAL, SHARING = ForceLawName.LITERAL, ForceLawName.SHARING


def small(name: ForceLawName, shape: str, count: int = 12, config: ForceConfig = CONFIG, **options: float) -> Outcome:
    """Form a quarter-size shape with few robots, from nearby."""
    contour = load_shape(shape, scale=0.5)
    radii = field_radii()[:count]
    law = law_for(name, config, contour, (), PlanningConfig())
    return form(law, config, contour, scattered(radii, (), 2, 15.0), radii, deadline=90.0, **options)


@pytest.mark.parametrize("name", [LITERAL, SHARING])
@pytest.mark.parametrize("shape", ["formation_3", "iso_1_circle"])
def test_a_small_swarm_settles_inside_a_convex_shape(name: ForceLawName, shape: str) -> None:
    outcome = small(name, shape)

    assert outcome.inside == 1.0
    assert outcome.settled_after is not None
    assert outcome.min_gap > 0.0


@pytest.mark.parametrize("shape", ["formation_1", "formation_2", "formation_4"])
def test_a_small_swarm_settles_inside_a_bent_shape(shape: str) -> None:
    outcome = small(SHARING, shape)

    assert outcome.inside == 1.0
    assert outcome.settled_after is not None
    assert outcome.min_gap > 0.0


@pytest.mark.parametrize("period", [0.1, 1.0])
def test_the_control_period_does_not_matter(period: float) -> None:
    outcome = small(SHARING, "formation_3", config=CONFIG.at_period(period), period=period)

    assert outcome.settled_after is not None


def test_fifty_robots_fill_a_shape_whose_boundary_center_is_outside() -> None:
    contour, radii, obstacles = load_shape("formation_2"), field_radii(), field_obstacles()
    law = law_for(SHARING, CONFIG, contour, obstacles, PlanningConfig())

    outcome = form(law, CONFIG, contour, scattered(radii, obstacles, 1), radii, obstacles, deadline=200.0)

    assert outcome.inside == 1.0
    assert outcome.settled_after is not None
    assert outcome.settled_after < 150.0
    assert min(outcome.min_gap, outcome.min_clearance) > 0.0
    mesh = mesh_quality(outcome.positions, radii, contour)
    # The literal law leaves 0.66, 0.06 and 0.4.
    assert mesh.topological_interior is not None
    assert mesh.topological_interior < 0.65
    assert mesh.geometrical is not None
    assert mesh.geometrical < 0.05
    assert mesh.area_variation is not None
    assert mesh.area_variation < 0.2


def test_fifty_robots_under_the_literal_law_settle_in_a_convex_shape() -> None:
    contour, radii, obstacles = load_shape("formation_3"), field_radii(), field_obstacles()
    law = law_for(LITERAL, CONFIG, contour, obstacles, PlanningConfig())

    outcome = form(law, CONFIG, contour, scattered(radii, obstacles, 1), radii, obstacles, deadline=220.0)

    assert outcome.inside == 1.0
    assert outcome.settled_after is not None
    assert min(outcome.min_gap, outcome.min_clearance) > 0.0


def test_equal_starts_end_in_equal_places() -> None:
    first, second = small(SHARING, "formation_1", 6), small(SHARING, "formation_1", 6)

    assert np.array_equal(first.positions, second.positions)
