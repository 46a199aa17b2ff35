"""Cost of the table-top camera: taking an image, and reading robots out of it, on one core.

Prints median and 99th percentile of processor milliseconds per image at two resolutions, for robots apart, and for the
hard images of the camera study (target: image to fixes in at most 15 ms at 640 x 480).
Run it on an otherwise idle machine: ``PYTHONPATH=scripts python benchmarks/bench_vision.py``.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

import cv2
import numpy as np

from mission_computer.vision.camera_localizer import CameraLocalizer
from mission_computer.vision.config import VisionConfig
from studies.camera_cases import Case, arena_markers, hard_case, plain_case
from swarm_msgs_py.markers import CoverMarker, FloorMarks
from swarm_msgs_py.randomness import rng_for
from swarm_sim.camera.overhead_camera import OverheadCamera, blacken_half
from swarm_sim.config import CameraConfig

IMAGES = 100
SEED = 7
SIZES = ((640, 480), (1280, 960))
KINDS: dict[str, Callable[[tuple[CoverMarker, ...], np.random.Generator], Case]] = {
    "robots apart": plain_case,
    "hard": hard_case,
}


def main() -> None:
    """Measure and print the table."""
    cv2.setNumThreads(1)
    print(f"{'image':<12}{'content':<14}{'take ms':>9}{'read ms':>9}{'99 % ms':>9}{'found':>8}")
    for width, height in SIZES:
        config = replace(CameraConfig(is_on=True), width_px=width, height_px=height)
        camera = OverheadCamera(config, arena_markers(), FloorMarks(), SEED)
        for name, make in KINDS.items():
            taking, reading, found = measure(camera, make)
            print(
                f"{f'{width}x{height}':<12}{name:<14}{np.median(taking):>9.1f}{np.median(reading):>9.1f}"
                f"{np.percentile(reading, 99.0):>9.1f}{found:>8}"
            )


def measure(
    camera: OverheadCamera, make: Callable[[tuple[CoverMarker, ...], np.random.Generator], Case]
) -> tuple[list[float], list[float], int]:
    """Return what taking and reading each image cost [ms], after the calibration, and how many fixes there were."""
    markers, vision = arena_markers(), VisionConfig()
    localizer = CameraLocalizer(vision, markers, FloorMarks())
    taking, reading, found = [], [], 0
    for number in range(IMAGES + vision.calibration_frames):
        rng = rng_for(SEED, "vision benchmark", number)
        case = (plain_case if number < vision.calibration_frames else make)(markers, rng)
        began = time.thread_time()
        image = camera.take(number, 100.0 * number, case.positions, case.yaws, case.spots)
        taken = time.thread_time()
        assert image is not None  # nobody switched the camera off
        if case.is_half_black:
            blacken_half(image.pixels)
        start = time.thread_time()
        report = localizer.locate(image, camera.info)
        if number >= vision.calibration_frames:
            taking.append(1e3 * (taken - began))
            reading.append(1e3 * (time.thread_time() - start))
            found += len(report.fixes)
    return taking, reading, found


if __name__ == "__main__":
    main()
