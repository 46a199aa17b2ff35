"""From images to fixes: calibrate, find colored blobs, measure discs, match covers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mission_computer.vision.calibration import Calibration, PlaneMap, calibrate, find_marks, plane_maps
from mission_computer.vision.colors import ColorClassifier
from mission_computer.vision.config import VisionConfig
from mission_computer.vision.covers import Whereabouts, find_cover
from mission_computer.vision.discs import Disc, measure
from mission_computer.vision.tracks import Tracks
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.markers import CoverMarker, FloorMarks, MarkerColor
from swarm_msgs_py.messages.camera import CameraImage, CameraInfo, ImageArray
from swarm_msgs_py.messages.camera_report import CameraReport, CameraStatus, Refusal, Rejection, RobotFix, Stray
from swarm_msgs_py.types import FloatArray

DARK_SHARE = 0.95
"""Share of dead pixels from which an image counts as dark."""
CAMERA_MOVED = "the camera has moved; it is calibrated anew"
"""Note of the one image in which that is found."""
MARKS_MOVED = 3
"""How many of the four marks must have moved before it is the camera that has."""


class CameraLocalizer:
    """Finds robots in images by the discs on their covers.

    Fixes come from one image each, without a filter: the robots' own estimators smooth. The last fix of a robot
    only tells where it cannot be by now.

    Parameters
    ----------
    config : VisionConfig
    markers : sequence of CoverMarker
        The robots; each color once.
    marks : FloorMarks
        What the floor shows.

    Raises
    ------
    ConfigError
        If two robots wear one color.
    """

    def __init__(self, config: VisionConfig, markers: Sequence[CoverMarker], marks: FloorMarks) -> None:
        self._config, self._marks = config, marks
        self._markers = tuple(sorted(markers, key=lambda marker: marker.robot))
        self._marker_of = {marker.color: marker for marker in self._markers}
        if len(self._marker_of) < len(self._markers):
            raise ConfigError("markers: two robots have the same color; give each its own")
        self._classifier = ColorClassifier(config, tuple(self._marker_of))
        self._views: list[FloatArray] = []
        self._read = 0
        self._info: CameraInfo | None = None
        self._calibration: Calibration | None = None
        self._planes: dict[float, PlaneMap] = {}
        self._tracks = Tracks(config)

    @property
    def calibration(self) -> Calibration | None:
        """Return where the camera is, as far as it is known."""
        return self._calibration

    def locate(self, image: CameraImage, info: CameraInfo) -> CameraReport:
        """Return what an image tells.

        Parameters
        ----------
        image : CameraImage
        info : CameraInfo
            Of the camera that took it; with other numbers than before, the camera is calibrated anew.

        Raises
        ------
        ValueError
            If the image has another size than its camera.
        """
        pixels = image.pixels
        if pixels.shape != (info.height, info.width, 3):
            raise ValueError(f"image of shape {pixels.shape} from a camera of {info.width} x {info.height} pixels")
        note = self._calibrate(pixels, info)
        blobs, largest = self._classifier.blobs(pixels)
        dead_share = float(np.count_nonzero(largest <= self._config.dead_code)) / largest.size
        if dead_share >= DARK_SHARE:
            return _nothing(image.time, CameraStatus.DARK, dead_share, "the image is dark")
        if self._calibration is None:
            return _nothing(image.time, CameraStatus.UNCALIBRATED, dead_share, note)
        discs: dict[MarkerColor, list[Disc]] = {color: [] for color in self._marker_of}
        for blob in blobs:
            plane = self._planes[self._marker_of[blob.color].height]
            disc = measure(blob, pixels, largest, plane, self._config)
            if disc is not None:
                discs[blob.color].append(disc)
        return self._matched(image.time, discs, dead_share, note)

    def _calibrate(self, pixels: ImageArray, info: CameraInfo) -> str:
        """Use the image for the calibration, where that needs it; return what there is to say of it."""
        if self._info is None or not _same(info, self._info):
            self._info, self._calibration, self._views = info, None, []
            self._tracks.forget()
        is_finished = len(self._views) >= self._config.calibration_frames
        self._read += 1
        if is_finished and self._read % self._config.recheck_frames:
            return ""
        view = find_marks(pixels)
        if is_finished:
            if view is None or not self._has_moved(view):
                return ""
            self._views = []
            self._tracks.forget()
            return self._learn(view, info) or CAMERA_MOVED
        if view is None:
            return "the four marks on the floor do not show; light the arena and clear its corners"
        return self._learn(view, info)

    def _has_moved(self, view: FloatArray) -> bool:
        """Return whether the camera is elsewhere than when it was calibrated, by its view of the marks (4, 2) [pixels].

        A robot in front of a mark, or its shadow, seems to displace that one; a push displaces at least three.
        """
        displacements = np.abs(view - np.mean(self._views, axis=0)).max(axis=1)
        return int(np.count_nonzero(displacements > self._config.moved_px)) >= MARKS_MOVED

    def _learn(self, view: FloatArray, info: CameraInfo) -> str:
        """Take one more view of the marks (4, 2) [pixels] into the calibration; return what is wrong with it."""
        self._views.append(view)
        # The first image gives a place at once, all together a better one; in between, maps would cost too much time.
        if len(self._views) not in (1, self._config.calibration_frames):
            return ""
        found = calibrate(np.mean(self._views, axis=0), info, self._marks)
        if found is None or found.error_px > self._config.calibration_error_px:
            self._views = []
            return "what looks like the marks on the floor does not fit them; clear the corners of the arena"
        self._calibration = found
        self._planes = plane_maps(found, [marker.height for marker in self._markers])
        return ""

    def _matched(self, time: float, discs: dict[MarkerColor, list[Disc]], dead_share: float, note: str) -> CameraReport:
        """Return the report of an image that could be read."""
        fixes: list[RobotFix] = []
        rejections: list[Rejection] = []
        strays: list[Stray] = []
        for marker in self._markers:
            of_color, robot = discs[marker.color], marker.robot
            tracks = self._tracks
            known = Whereabouts(tracks.track(robot, time), tracks.near(robot, time), tracks.left(robot))
            match = find_cover(marker, of_color, self._config, known)
            result, own = match.result, match.own
            if isinstance(result, Refusal):
                self._tracks.miss(robot)
            elif self._tracks.believes(robot, result.position, time):
                fixes.append(result)
            else:
                result, own = Refusal.ELSEWHERE, ()
            if isinstance(result, Refusal):
                rejections.append(Rejection(robot, marker.color, result))
            strays += [
                Stray(disc.color, (float(disc.center[0]), float(disc.center[1])))
                for disc in of_color
                if not any(disc is one for one in own)
            ]
        return CameraReport(time, CameraStatus.OK, tuple(fixes), tuple(rejections), tuple(strays), dead_share, note)


def _same(one: CameraInfo, other: CameraInfo) -> bool:
    return (
        (one.width, one.height) == (other.width, other.height)
        and np.array_equal(one.intrinsics, other.intrinsics)
        and np.array_equal(one.distortion, other.distortion)
    )


def _nothing(time: float, status: CameraStatus, dead_share: float, note: str) -> CameraReport:
    return CameraReport(time, status, (), (), (), dead_share, note)
