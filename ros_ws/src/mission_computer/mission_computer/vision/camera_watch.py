"""The mission computer's part of the camera: images in; fixes for the mesh, lines for the operator, pictures out."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np

from mission_computer.vision.annotation import annotate
from mission_computer.vision.camera_localizer import CameraLocalizer
from mission_computer.vision.config import VisionConfig
from swarm_msgs_py.markers import CoverMarker, FloorMarks
from swarm_msgs_py.messages.bodies import CameraFixes, Plan
from swarm_msgs_py.messages.camera import CameraImage, CameraInfo, ImageArray
from swarm_msgs_py.messages.camera_report import CameraReport, CameraStatus
from swarm_msgs_py.types import robot_name

Finding = tuple[str, str]
"""What a line is about, and what it says."""

MOMENT = 1e-9  # [s]; times are products of ticks and their duration


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
        self._pending: dict[str, tuple[str, float]] = {}  # what is found of a subject, and since when [s]
        self._told: dict[str, str] = {}  # what was said of it, if that is in force
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
        found, lines = dict(self._findings(time, report)), []
        if report is None or report.status is not CameraStatus.OK:
            found = self._told | found  # what cannot be seen is not over
        self._pending = {subject: pending for subject, pending in self._pending.items() if subject in found}
        for subject, what in found.items():
            if self._pending.setdefault(subject, (what, time))[0] != what:
                self._pending[subject] = what, time
            has_lasted = time - self._pending[subject][1] >= self._config.notice_after_s - MOMENT
            if has_lasted and self._told.get(subject) != what:
                self._told[subject] = what
                lines.append(f"{subject}: {what}")
        for subject in [subject for subject in self._told if subject not in found]:
            del self._told[subject]
            lines.append(f"{subject}: well again")
        return "; ".join(lines)

    def picture(self, plan: Plan | None = None) -> ImageArray | None:
        """Return the last image with what was read out of it, and what a plan asks for; None if there was none yet."""
        if self._last is None:
            return None
        image, report = self._last
        return annotate(image.pixels, report, self._localizer.calibration, self._markers, plan)

    def _is_blind(self, time: float) -> bool:
        return self._seen_at is not None and time - self._seen_at >= self._config.notice_after_s - MOMENT

    def _findings(self, time: float, report: CameraReport | None) -> Iterator[Finding]:
        """Yield what is not as it should be."""
        if report is None or report.status is not CameraStatus.OK:
            if self._is_blind(time):
                yield "camera", report.note if report is not None else "no images; robots stand still"
            return
        if report.note:
            yield "camera", report.note
        if report.dead_share >= self._config.dead_share_max:
            yield "camera", f"{round(100.0 * report.dead_share, -1):.0f} % of the image are black"
        for rejection in report.rejections:
            yield f"{robot_name(rejection.robot)} ({rejection.color.value})", rejection.reason.value
        for color in sorted({stray.color.value for stray in report.strays}):
            yield color, "something of this color is no robot"
        for one, other in combinations(report.fixes, 2):
            gap = math.hypot(*np.subtract(one.position, other.position)) - (
                self._radii[one.robot] + self._radii[other.robot]
            )
            if gap <= self._config.touch_m:
                yield f"{robot_name(one.robot)} and {robot_name(other.robot)}", "they touch"


def fixes_of(report: CameraReport | None, tick: int) -> CameraFixes | None:
    """Return what the robots are told of the image of a tick; None if it shows none of them."""
    if report is None or not report.fixes:
        return None
    return CameraFixes(tick, report.fixes)
