"""What was read out of an image, drawn into it: for people, and for the video of a run."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from mission_computer.vision.calibration import Calibration
from swarm_msgs_py.markers import CoverMarker
from swarm_msgs_py.messages.bodies import Plan
from swarm_msgs_py.messages.camera import ImageArray
from swarm_msgs_py.messages.camera_report import CameraReport, CameraStatus, RobotFix
from swarm_msgs_py.types import FloatArray, NodeId, robot_name

FOUND, STRAY, WARNING, PLAN = (255, 255, 255), (255, 140, 0), (255, 60, 60), (0, 110, 60)
"""Colors of what is drawn: red, green, blue."""
FONT, FONT_SCALE = cv2.FONT_HERSHEY_SIMPLEX, 0.45
LINE_PX = 16
CIRCLE_CORNERS = 40
STRAY_M, GOAL_M = 0.03, 0.015
SUBPIXEL_BITS = 4
"""OpenCV draws to fractions of a pixel when coordinates are shifted by this many bits."""


def annotate(
    pixels: ImageArray,
    report: CameraReport,
    calibration: Calibration | None,
    markers: Sequence[CoverMarker],
    plan: Plan | None = None,
) -> ImageArray:
    """Return a copy of an image with outlines and headings of the robots found, strays, and what was refused.

    Where there is a plan, its shape and goals are drawn as they are in the end, as high as the covers: so a robot that
    is at its goal is seen there.

    Parameters
    ----------
    pixels : (h, w, 3) uint8 array
        Red, green, blue.
    report : CameraReport
        Of this image.
    calibration : Calibration or None
        Without it only text is drawn.
    markers : sequence of CoverMarker
    plan : Plan or None
    """
    canvas = np.ascontiguousarray(pixels.copy())
    marker_of: dict[NodeId, CoverMarker] = {marker.robot: marker for marker in markers}
    if calibration is not None:
        if plan is not None:
            _draw_plan(canvas, plan, calibration, max((marker.height for marker in markers), default=0.0))
        height_of = {marker.color: marker.height for marker in markers}
        for fix in report.fixes:
            _draw_fix(canvas, fix, marker_of[fix.robot], calibration)
        for stray in report.strays:
            corner = np.array([*stray.position, height_of[stray.color]])
            _outline(canvas, _circle(corner, STRAY_M), calibration, STRAY)
    lines = [f"t = {report.time:.1f} s  {len(report.fixes)} of {len(markers)} robots"]
    if report.status is not CameraStatus.OK:
        lines.append(report.note or report.status.value)
    lines += [f"{robot_name(r.robot)} ({r.color.value}): {r.reason.value}" for r in report.rejections]
    for number, line in enumerate(lines):
        place = (6, LINE_PX * (number + 1))
        cv2.putText(canvas, line, place, FONT, FONT_SCALE, FOUND if number == 0 else WARNING, 1, cv2.LINE_AA)
    return canvas


def _draw_plan(canvas: ImageArray, plan: Plan, calibration: Calibration, height: float) -> None:
    _outline(canvas, _raised(plan.contour, height), calibration, PLAN)
    for goal in _raised(plan.goals, height):
        _outline(canvas, _circle(goal, GOAL_M), calibration, PLAN)


def _raised(points: FloatArray, height: float) -> FloatArray:
    """Return points (n, 2) of the map as (n, 3) points of the world at a height [m]."""
    return np.column_stack([points, np.full(len(points), height)])


def _draw_fix(canvas: ImageArray, fix: RobotFix, marker: CoverMarker, calibration: Calibration) -> None:
    middle = np.array([*fix.position, marker.height])
    _outline(canvas, _circle(middle, marker.radius), calibration, FOUND)
    ahead = middle + 1.4 * marker.radius * np.array([np.cos(fix.yaw), np.sin(fix.yaw), 0.0])
    start, end = (tuple(int(v) for v in point) for point in np.rint(calibration.project(np.stack([middle, ahead]))))
    cv2.arrowedLine(canvas, start, end, FOUND, 1, cv2.LINE_AA, tipLength=0.25)
    cv2.putText(canvas, robot_name(fix.robot), (end[0] + 4, end[1]), FONT, FONT_SCALE, FOUND, 1, cv2.LINE_AA)


def _circle(middle: FloatArray, radius: float) -> FloatArray:
    """Return the corners (n, 3) of a level circle [m]."""
    angles = 2.0 * np.pi * np.arange(CIRCLE_CORNERS) / CIRCLE_CORNERS
    ring: FloatArray = middle + radius * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(CIRCLE_CORNERS)])
    return ring


def _outline(canvas: ImageArray, corners: FloatArray, calibration: Calibration, color: tuple[int, int, int]) -> None:
    """Draw a closed line through world points (n, 3), in place."""
    pixels = np.rint(calibration.project(corners) * 2**SUBPIXEL_BITS).astype(np.int32)
    cv2.polylines(canvas, [pixels], True, color, 1, cv2.LINE_AA, SUBPIXEL_BITS)
