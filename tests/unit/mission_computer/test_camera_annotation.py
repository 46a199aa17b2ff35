from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.testing import assert_array_equal
from table_top import AWAY, MARKERS, RED, STARTS, YAWS, camera, localizer, moved, picture

from mission_computer.vision.annotation import FOUND, annotate
from swarm_msgs_py.markers import MarkerColor
from swarm_msgs_py.messages.bodies import Plan
from swarm_msgs_py.messages.camera_report import CameraStatus
from swarm_sim.camera.raster import Spot

EYES = localizer(reach_m=100.0)


def test_robots_are_outlined_and_the_image_itself_is_left_alone() -> None:
    image = picture()
    before = image.pixels.copy()
    report = EYES.locate(image, camera().info)

    drawn = annotate(image.pixels, report, EYES.calibration, MARKERS)

    assert_array_equal(image.pixels, before)
    for marker, place in zip(MARKERS, STARTS, strict=True):
        rim = np.array([[place[0], place[1] + marker.radius, marker.height]])
        column, row = camera().optics.project(rim)[0].round().astype(int)
        near = drawn[row - 1 : row + 2, column - 1 : column + 2]
        assert (near.min(axis=2) > 0.9 * min(FOUND)).any()


def test_what_is_refused_and_what_is_stray_shows() -> None:
    image = picture(moved(RED, AWAY), YAWS, Spot(MarkerColor.PINK, (0.0, -0.5), 0.02), number=1)
    report = EYES.locate(image, camera().info)

    drawn = annotate(image.pixels, report, EYES.calibration, MARKERS)

    changed = (drawn != image.pixels).any(axis=2)
    column, row = camera().optics.project(np.array([[0.0, -0.5, 0.0]]))[0].round().astype(int)
    assert changed[row - 12 : row + 12, column - 12 : column + 12].any()  # around the stray
    assert changed[17:33, :200].any()  # a second line of text: why red has no fix


def test_without_a_calibration_only_text_is_drawn() -> None:
    image = picture()
    report = replace(EYES.locate(image, camera().info), status=CameraStatus.UNCALIBRATED, note="no marks")

    drawn = annotate(image.pixels, report, None, MARKERS)

    changed = (drawn != image.pixels).any(axis=2)
    assert changed[:34].any()
    assert not changed[34:].any()


def test_shape_and_goals_of_a_plan_are_drawn_at_the_height_of_the_covers() -> None:
    image = picture(number=2)
    report = EYES.locate(image, camera().info)
    plan = Plan(1, 0.4 * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]), (), np.array([(0.2, 0.1)]), np.array([1]))

    drawn = annotate(image.pixels, report, EYES.calibration, MARKERS, plan)

    plain = annotate(image.pixels, report, EYES.calibration, MARKERS)
    changed = (drawn != plain).any(axis=2)
    for x, y in ((0.0, 0.4), (-0.4, 0.2), (0.215, 0.1)):
        column, row = camera().optics.project(np.array([[x, y, MARKERS[0].height]]))[0].round().astype(int)
        assert changed[row - 1 : row + 2, column - 1 : column + 2].any()
    assert 0 < changed.sum() < 3000
