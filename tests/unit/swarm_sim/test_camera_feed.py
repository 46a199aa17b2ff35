"""The images of a run: one when it is due, the same however often it is asked; and how right they were read."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from table_top import MARKERS, STARTS, YAWS

from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.markers import MarkerColor
from swarm_msgs_py.messages.camera_report import CameraReport, CameraStatus, RobotFix
from swarm_msgs_py.types import NodeId
from swarm_sim.camera.feed import CameraFeed
from swarm_sim.camera.sight import Sight
from swarm_sim.config import (
    Backend,
    CameraConfig,
    ImuConfig,
    PhysicsConfig,
    RangingConfig,
    Renderer,
    SimConfig,
    SpotConfig,
)
from swarm_sim.metrics.camera import CameraScores, heading_errors
from swarm_sim.radio.links import LinkTable
from swarm_sim.sensors.imu import Imu
from swarm_sim.sensors.ranging import Ranging
from swarm_sim.world.world import BodyState

SMALL = CameraConfig(is_on=True, width_px=160, height_px=120, off_from_s=0.4, off_for_s=0.3)
BODIES = BodyState(STARTS, np.zeros(5), YAWS, np.zeros((5, 2)), np.zeros(5))


def test_an_image_is_taken_once_when_it_is_due_and_not_while_the_camera_is_off() -> None:
    feed = CameraFeed(replace(SMALL, rate_hz=5.0), MARKERS, seed=1)
    images = [feed.image(0.1 * tick, BODIES) for tick in range(10)]

    assert [tick for tick, image in enumerate(images) if image is not None] == [0, 2, 8]
    assert feed.image(0.9, BODIES) is None
    again = feed.image(1.0, BODIES)
    assert again is not None
    assert feed.image(1.0, BODIES) is again
    feed.close()


def test_what_lies_on_the_floor_is_in_the_picture() -> None:
    spot = SpotConfig(color=MarkerColor.GREEN, center_m=(0.0, 0.0), radius_m=0.2)
    plain, spotted = (
        CameraFeed(replace(SMALL, spots=spots), MARKERS, seed=1).image(0.0, BODIES) for spots in ((), (spot,))
    )

    assert plain is not None
    assert spotted is not None
    changed = (plain.pixels != spotted.pixels).any(axis=2)
    assert 200 < changed.sum() < 600


def test_pybullet_draws_the_images_where_it_is_the_physics_unless_it_is_said() -> None:
    bullet, fast = PhysicsConfig(backend=Backend.BULLET), PhysicsConfig(backend=Backend.MASSDAMPER)

    assert SimConfig(physics=bullet).renderer is Renderer.BULLET
    assert SimConfig(physics=fast).renderer is Renderer.RASTER
    assert SimConfig(physics=bullet, camera=replace(SMALL, renderer=Renderer.RASTER)).renderer is Renderer.RASTER
    assert SimConfig(physics=fast, camera=replace(SMALL, renderer=Renderer.BULLET)).renderer is Renderer.BULLET


def test_a_camera_needs_robots_that_it_can_know() -> None:
    with pytest.raises(ConfigError, match="colors"):
        CameraFeed(SMALL, (), seed=1)


def test_robots_without_a_compass_are_told_no_heading() -> None:
    imu = Imu(ImuConfig(has_compass=False), 5, seed=1)

    assert all(sample.yaw is None for sample in imu.measure(0, BODIES, np.zeros((5, 2))))


def test_radios_that_do_not_range_give_nothing() -> None:
    links = LinkTable(~np.eye(6, dtype=bool), np.ones((6, 6)))
    ranging = Ranging(RangingConfig(is_on=False), np.arange(5), 0.1, seed=1)

    assert all(not len(scan.neighbors) for scan in ranging.measure(0, STARTS, links))


def report(*fixes: RobotFix, status: CameraStatus = CameraStatus.OK, time: float = 0.0) -> CameraReport:
    return CameraReport(time, status, fixes, (), (), 0.0)


def fix(robot: int, x: float, yaw: float = 0.0) -> RobotFix:
    return RobotFix(NodeId(robot), np.array([x, 0.0]), yaw, 0.001, 0.002, 1.0)


def test_fixes_are_compared_with_the_truth() -> None:
    seen = {0.5: (False, True), 0.9: (False, False)}
    view = lambda time, _: np.array(seen.get(time, (True, True)))  # noqa: E731 - one of several views
    scores, rows = CameraScores(view), {NodeId(0): 0, NodeId(1): 1}
    truth, yaws = np.array([[0.0, 0.0], [1.0, 0.0]]), np.array([0.0, math.pi - 0.01])

    scores.take(report(fix(0, 0.003), fix(1, 1.0, 0.01 - math.pi)), rows, truth, yaws)
    scores.take(report(fix(0, 1.0)), rows, truth, yaws)  # where the other one is
    scores.take(report(fix(1, 1.001, math.pi), time=0.5), rows, truth, yaws)  # only half of it shows something
    scores.take(report(status=CameraStatus.DARK), rows, truth, yaws)  # everybody could have been found
    scores.take(report(status=CameraStatus.DARK, time=0.9), rows, truth, yaws)
    scores.take(report(fix(0, 0.04)), rows, truth, yaws)  # nearer than the cover's rim, but not the cover

    assert (scores.images, scores.unread, scores.in_view, scores.found) == (6, 2, 9, 3)
    assert scores.false_fixes == 2
    assert scores.position_errors == pytest.approx([0.003, 0.0, 0.001])
    assert scores.heading_errors == pytest.approx([0.0, 0.02, 0.01])


def test_who_is_out_of_view_or_in_the_black_half_is_known_from_the_truth() -> None:
    sight = Sight(CameraConfig(is_on=True, black_from_s=1.0, black_for_s=1.0), MARKERS, seed=1)
    positions = STARTS.copy()
    positions[4] = (1.6, 0.0)
    far = positions.copy()
    far[3] = (30.0, 30.0)

    assert sight.in_view(0.0, positions).tolist() == [True, True, True, True, False]
    assert sight.in_view(0.0, far).tolist() == [True, True, True, False, False]
    assert sight.in_view(1.5, positions).tolist() == [False, False, True, False, False]
    assert sight.in_view(2.0, positions).tolist() == [True, True, True, True, False]


def test_headings_differ_the_short_way_around() -> None:
    errors = heading_errors(np.array([[3.1, -3.1], [0.2, np.nan]]), np.array([[-3.1, 3.1], [0.1, 0.0]]))

    assert errors[0] == pytest.approx([6.2 - math.tau, math.tau - 6.2])
    assert errors[1, 0] == pytest.approx(0.1)
    assert np.isnan(errors[1, 1])
