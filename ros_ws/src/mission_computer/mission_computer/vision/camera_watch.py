"""The mission computer's part of the camera: images in; fixes for the mesh, lines for the operator, pictures out."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np

from mission_computer.vision.annotation import annotate
from mission_computer.vision.camera_localizer import CAMERA_MOVED, CameraLocalizer
from mission_computer.vision.config import VisionConfig
from mission_computer.vision.notices import MOMENT, Finding, Notices
from swarm_msgs_py.markers import CoverMarker, FloorMarks, MarkerColor
from swarm_msgs_py.messages.bodies import CameraFixes, Plan
from swarm_msgs_py.messages.camera import CameraImage, CameraInfo, ImageArray
from swarm_msgs_py.messages.camera_report import CameraReport, CameraStatus, Refusal
from swarm_msgs_py.types import robot_name

CAMERA = "camera"
"""Subject of what concerns whole images."""
SHARE_STEP, SHARE_LAG = 0.1, 0.02
"""Shares of black pixels are told in steps of this; a step holds for so much longer than it is the nearest."""
PLACES_MAX = 3
"""So many places of distractors are told."""


class CameraWatch:
    """Reads every image, and says in words what the operator ought to know, when it has been so for a moment.

    Parameters
    ----------
    config : VisionConfig
    markers : sequence of CoverMarker
        The robots; each color once.
    """

    def __init__(self, config: VisionConfig, markers: Sequence[CoverMarker]) -> None:
        self._config, self._markers = config, tuple(markers)
        self._localizer = CameraLocalizer(config, markers, FloorMarks())
        self._radii = {marker.robot: marker.radius for marker in self._markers}
        self._of_camera = Notices(config.notice_after_s, config.notice_over_s)
        self._of_robots = Notices(config.notice_after_s, config.notice_over_s)
        self._clock = 0.0  # time in which images could be read [s]
        self._read_at = 0.0  # time of the last image of that [s]
        self._black_share = 0.0  # what is, or would be, told of it
        self._last: tuple[CameraImage, CameraReport] | None = None
        self._seen_at: float | None = None  # time of the last image that could be read [s]

    def look(self, time: float, image: CameraImage | None, info: CameraInfo | None) -> CameraReport | None:
        """Return what the image of this tick tells; None if there is none.

        Parameters
        ----------
        time : float
            Now [s].
        image : CameraImage or None
        info : CameraInfo or None
            Of the camera that took it.
        """
        self._seen_at = time if self._seen_at is None else self._seen_at
        if image is None or info is None:
            return None
        report = self._localizer.locate(image, info)
        self._last = image, report
        if report.status is CameraStatus.OK:
            self._seen_at = time
        return report

    def notice(self, time: float, report: CameraReport | None) -> str:
        """Return what is new for the operator at `time` [s], after `look`, in a line; "" if nothing is."""
        if report is None and not self._is_blind(time):
            return ""  # between two images
        lines = self._of_camera.take(time, dict(self._camera_findings(time, report)))
        if report is not None and report.note == CAMERA_MOVED:
            lines.append(f"{CAMERA}: {CAMERA_MOVED}")  # it happens, and is neither so for a while nor over
        if report is not None and report.status is CameraStatus.OK:
            # What cannot be seen is neither so nor over: the clock of what images show stands still meanwhile.
            self._clock += min(time - self._read_at, self._config.notice_after_s)
            self._read_at = time
            lines += self._of_robots.take(self._clock, dict(self._robot_findings(report)))
        return "; ".join(lines)

    def picture(self, plan: Plan | None = None) -> ImageArray | None:
        """Return the last image with what was read out of it, and what a plan asks for; None if there was none yet."""
        if self._last is None:
            return None
        image, report = self._last
        return annotate(image.pixels, report, self._localizer.calibration, self._markers, plan)

    def _is_blind(self, time: float) -> bool:
        return self._seen_at is not None and time - self._seen_at >= self._config.notice_after_s - MOMENT

    def _camera_findings(self, time: float, report: CameraReport | None) -> Iterator[tuple[str, Finding]]:
        """Yield what is not as it should be with images as a whole, if anything is."""
        if report is None or report.status is not CameraStatus.OK:
            if self._is_blind(time):
                words = report.note if report is not None else "no images; robots stand still"
                yield CAMERA, Finding(words, words)
        elif report.note and report.note != CAMERA_MOVED:
            yield CAMERA, Finding(report.note, report.note)
        elif report.dead_share >= self._config.dead_share_max:
            if abs(report.dead_share - self._black_share) > SHARE_STEP / 2.0 + SHARE_LAG:
                self._black_share = SHARE_STEP * round(report.dead_share / SHARE_STEP)
            words = f"{100.0 * self._black_share:.0f} % of the image are black"
            yield CAMERA, Finding(words, words)

    def _robot_findings(self, report: CameraReport) -> Iterator[tuple[str, Finding]]:
        """Yield what is not as it should be with what an image shows."""
        places: dict[MarkerColor, list[str]] = {}
        for stray in report.strays:
            places.setdefault(stray.color, []).append(f"({stray.position[0]:.2f}, {stray.position[1]:.2f})")
        for rejection in report.rejections:
            blobs = len(places.get(rejection.color, ()))
            words = rejection.reason.value
            if rejection.reason is Refusal.NOT_SEEN and blobs:
                words += f" ({blobs} blob{'s' * (blobs > 1)} of its color)"
            yield f"{robot_name(rejection.robot)} ({rejection.color.value})", Finding(rejection.reason.value, words)
        for color in sorted(places, key=lambda color: color.value):
            shown = ", ".join(places[color][:PLACES_MAX]) + ", ..." * (len(places[color]) > PLACES_MAX)
            yield color.value, Finding("stray", f"something of this color is no robot, at {shown} m")
        for one, other in combinations(report.fixes, 2):
            gap = math.hypot(*np.subtract(one.position, other.position)) - (
                self._radii[one.robot] + self._radii[other.robot]
            )
            if gap <= self._config.touch_m:
                yield f"{robot_name(one.robot)} and {robot_name(other.robot)}", Finding("touch", "they touch")


def fixes_of(report: CameraReport | None, tick: int) -> CameraFixes | None:
    """Return what the robots are told of the image of a tick; None if it shows none of them."""
    if report is None or not report.fixes:
        return None
    return CameraFixes(tick, report.fixes)
