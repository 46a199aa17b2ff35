"""Checks of a camera before anything starts: what it cannot show, the mission computer could never read."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from bringup.layout import markers
from bringup.scenario import Scenario
from mission_computer.vision.calibration import (
    MARK_AREA_LEAST_PX,
    MARK_AREA_PX,
    MARK_ASPECT,
    MARK_MARGIN_LEAST_PX,
    MARK_MARGIN_PX,
)
from mission_computer.vision.resolution import LEAST_RADIUS_PX, scale_of, smallest_radius_px
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.markers import CoverMarker, FloorMarks
from swarm_msgs_py.types import FloatArray
from swarm_sim.camera.optics import Optics
from swarm_sim.camera.overhead_camera import mounted_optics
from swarm_sim.camera.sight import lens_limit, rim_pixels

ROUNDING = 1e-6
MOUNTED = "or change sim.camera.mount_sigma_m, aim_sigma_m, roll_sigma_rad or the seed"


def check_camera(scenario: Scenario) -> None:
    """Refuse a camera that cannot know the robots, or images between ticks; and robots that need one where none is.

    How the camera is mounted is drawn for the seed of the run, and checked as drawn.

    Raises
    ------
    ConfigError
        Naming the settings.
    """
    camera = scenario.sim.camera
    if not camera.is_on:
        if scenario.agent.lps.from_camera:
            raise ConfigError("agent.lps.from_camera needs sim.camera.is_on; switch the one on, or the other off")
        return
    plain = [group.type for group in scenario.robots.types if group.count and not group.colors]
    if plain:
        raise ConfigError(f"robots of type {plain[0]} have no colors to be known by; give robots.types[].colors")
    _check_rate(scenario)
    vision = scenario.mission.vision
    if vision.dead_code >= vision.spread_min_codes:
        raise ConfigError(
            f"mission.vision.dead_code ({vision.dead_code}) must be less than mission.vision.spread_min_codes "
            f"({vision.spread_min_codes}), else colors count as dark; lower it"
        )
    optics, marks = mounted_optics(camera, scenario.seed), FloorMarks()
    limit = lens_limit(optics)
    if limit is None:
        raise ConfigError(
            f"sim.camera.radial_distortion ({camera.radial_distortion:g}) folds the corners of an image that shows "
            f"{camera.view_m:g} m from {camera.elevation_m:g} m; bring it nearer to 0, lower view_m, or raise "
            "elevation_m"
        )
    _check_discs(optics, markers(scenario))
    for center in marks.centers:
        _check_mark(optics, limit, center, marks.radius)
        _check_spots(scenario, center, marks.radius)


def _check_rate(scenario: Scenario) -> None:
    """Refuse images between ticks, and such as come too rarely for who needs them."""
    rate_hz, period_s = scenario.sim.camera.rate_hz, scenario.sim.period_s
    what = f"sim.camera.rate_hz ({rate_hz:g} Hz)"
    ticks = 1.0 / (rate_hz * period_s)
    if ticks < 1.0 - ROUNDING:
        raise ConfigError(f"{what} is more than one image in a tick of {period_s:g} s; lower it, or lower sim.period_s")
    if abs(ticks - round(ticks)) > ROUNDING * ticks:
        near = (1.0 / (whole * period_s) for whole in (math.floor(ticks), math.ceil(ticks)))
        raise ConfigError(
            f"{what} gives no image in every whole number of ticks of {period_s:g} s; "
            f"use {' or '.join(f'{rate:.6g}' for rate in near)} Hz"
        )
    lps, vision = scenario.agent.lps, scenario.mission.vision
    waits = [("mission.vision.notice_after_s", vision.notice_after_s)] if vision.notice_after_s > 0.0 else []
    waits += [("agent.lps.blind_after_s", lps.blind_after_s)] if lps.from_camera else []
    for name, wait_s in waits:
        if 1.0 / rate_hz >= wait_s - ROUNDING:
            raise ConfigError(
                f"{what} leaves {1.0 / rate_hz:.3g} s between images, and {name} ({wait_s:g} s) takes that for a "
                "failure; raise the rate or that time"
            )


def _check_discs(optics: Optics, covers: Sequence[CoverMarker]) -> None:
    """Refuse covers that the camera is not above, or that are too small in its images."""
    height = max(cover.height for cover in covers)
    if float(optics.position[2]) <= height:
        raise ConfigError(
            f"the camera is mounted {optics.position[2]:.2f} m above the floor, below the robots' covers at "
            f"{height:g} m; raise sim.camera.elevation_m, or lower mount_sigma_m"
        )
    radius_px = smallest_radius_px(covers, optics.info, float(optics.position[2]))
    if radius_px < LEAST_RADIUS_PX:
        raise ConfigError(
            f"the smallest disc has a radius of {radius_px:.1f} pixels in images of {optics.info.width}x"
            f"{optics.info.height}, less than the {LEAST_RADIUS_PX:g} that can be read; raise sim.camera.width_px and "
            "height_px, or lower view_m"
        )


def _check_mark(optics: Optics, limit: float, center: FloatArray, radius: float) -> None:
    """Refuse a mark of the floor that is not wholly in the image, or that the mission computer takes for none."""
    info = optics.info
    place, scale = f"the floor mark at ({center[0]:g}, {center[1]:g}) m", scale_of(info.height)
    margin = max(round(scale * MARK_MARGIN_PX), MARK_MARGIN_LEAST_PX)
    rim = rim_pixels(optics, limit, center, radius, 0.0)
    high = np.array([info.width, info.height]) - 1.0 - margin
    if rim is None or (rim < margin).any() or (rim > high).any():
        raise ConfigError(
            f"{place} is out of view, or nearer than {margin} pixels to the border of images of "
            f"{info.width}x{info.height}; without it the camera cannot be calibrated: raise sim.camera.view_m, "
            f"{MOUNTED}"
        )
    sides = np.ptp(rim, axis=0)
    if sides.max() > MARK_ASPECT * sides.min():
        raise ConfigError(f"the camera looks at {place} from too far aside to know it; lower sim.camera.mount_sigma_m")
    area = float(sides.prod()) * math.pi / 4.0
    least, most = max(MARK_AREA_PX[0] * scale**2, MARK_AREA_LEAST_PX), MARK_AREA_PX[1] * scale**2
    if not least <= area <= most:
        raise ConfigError(
            f"{place} has {area:.0f} pixels, of {least:.0f} to {most:.0f} that a mark has in images of {info.height} "
            "rows; change sim.camera.view_m"
        )


def _check_spots(scenario: Scenario, center: FloatArray, radius: float) -> None:
    """Refuse spots that hide a mark of the floor."""
    for number, spot in enumerate(scenario.sim.camera.spots):
        if math.dist(center, spot.center_m) < spot.radius_m + radius:
            raise ConfigError(
                f"sim.camera.spots[{number}] hides the floor mark at ({center[0]:g}, {center[1]:g}) m, without which "
                "the camera cannot be calibrated; make it smaller, or move it"
            )
