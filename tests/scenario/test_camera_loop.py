"""Wheels, camera and vision in one loop: robots that only know what images tell drive to their goals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from table_top import MARKERS, STARTS, localizer

from swarm_msgs_py.markers import FloorMarks
from swarm_msgs_py.robots import RobotType
from swarm_sim.camera.overhead_camera import OverheadCamera
from swarm_sim.config import (
    Backend,
    CameraConfig,
    Drive,
    DriveConfig,
    Ground,
    OmniConfig,
    PhysicsConfig,
    SimConfig,
    TerrainConfig,
)
from swarm_sim.scene import RobotSpec, Scene
from swarm_sim.world.registry import make_world

PERIOD_S = 0.1
SPEED_MPS, GAIN, TURN_GAIN = 0.05, 1.0, 1.0
YAW = 0.7
GOALS = STARTS * 0.75 + np.array([0.05, -0.05])
SLIP = OmniConfig(slip_sigma=0.1, slip_time_s=2.0)  # five times as much, four times as long as it should be


@dataclass(frozen=True)
class Outcome:
    """What came of a run."""

    errors_m: np.ndarray
    turned_rad: np.ndarray
    speeds_in_outage: np.ndarray


def drive(ticks: int, off_for_s: float = 0.0, sees: bool = True) -> Outcome:
    """Drive to the goals by the fixes of the tick before; without a fix, stand. Blind robots trust their wheels."""
    robots = tuple(
        RobotSpec(
            marker.robot,
            RobotType(type=1, mass_kg=1.0, mu1=0.5, mu2=0.1, coverage_radius_m=marker.radius),
            (float(start[0]), float(start[1])),
            YAW,
            False,
        )
        for marker, start in zip(MARKERS, STARTS, strict=True)
    )
    config = SimConfig(
        period_s=PERIOD_S,
        physics=PhysicsConfig(backend=Backend.MASSDAMPER),
        terrain=TerrainConfig(ground=Ground.PLANE),
        drive=DriveConfig(kind=Drive.OMNI_WHEELS, omni=SLIP),
        camera=CameraConfig(is_on=True, off_from_s=2.0, off_for_s=off_for_s),
    )
    world = make_world(config, Scene(robots, (), (-1.0, -1.0, 1.0, 1.0), (0.0, 0.0)), seed=1)
    camera, eyes = OverheadCamera(config.camera, MARKERS, FloorMarks(), seed=1), localizer()
    known = {int(robot.id): (np.array(robot.position), robot.yaw) for robot in robots}
    speeds = []
    for tick in range(ticks):
        setpoints = np.zeros((5, 3))
        for row, (place, yaw) in known.items():
            ahead = GAIN * (GOALS[row] - place)
            ahead *= min(1.0, SPEED_MPS / max(float(np.hypot(*ahead)), 1e-9))
            cos, sin = np.cos(yaw), np.sin(yaw)
            setpoints[row] = cos * ahead[0] + sin * ahead[1], cos * ahead[1] - sin * ahead[0], TURN_GAIN * (YAW - yaw)
        time = tick * PERIOD_S
        if sees:
            image = camera.take(tick, time, world.state.positions, world.state.yaws)
            report = eyes.locate(image, camera.info) if image is not None else None
            known = {int(fix.robot): (fix.position, fix.yaw) for fix in report.fixes} if report is not None else {}
        else:
            known = {row: (place + PERIOD_S * _turned(setpoints[row], yaw), yaw) for row, (place, yaw) in known.items()}
        motion = world.advance(setpoints)
        if 2.3 <= time < 2.0 + off_for_s:
            speeds.append(np.hypot(*motion.end.velocities.T).max())
    world.close()
    camera.close()
    off = np.hypot(*(motion.end.positions - GOALS).T)
    return Outcome(off, np.abs(motion.end.yaws - YAW), np.array(speeds))


def _turned(setpoint: np.ndarray, yaw: float) -> np.ndarray:
    cos, sin = np.cos(yaw), np.sin(yaw)
    return np.array([cos * setpoint[0] - sin * setpoint[1], sin * setpoint[0] + cos * setpoint[1]])


def test_images_alone_bring_robots_to_their_goals_and_hold_their_headings() -> None:
    seeing, blind = drive(95), drive(95, sees=False)

    assert seeing.errors_m.max() < 0.004
    assert seeing.turned_rad.max() < np.deg2rad(2.0)
    assert blind.errors_m.max() > 2.0 * seeing.errors_m.max()  # slip is not something that wheels could notice


def test_robots_stand_while_the_camera_is_off_and_go_on_when_it_is_back() -> None:
    outcome = drive(115, off_for_s=2.0)

    assert len(outcome.speeds_in_outage) > 10
    assert outcome.speeds_in_outage.max() < 1e-6
    assert outcome.errors_m.max() < 0.004
