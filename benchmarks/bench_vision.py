"""Cost of the table-top camera: taking an image, and reading robots out of it, on one core.

Prints median, 99th percentile and maximum of processor milliseconds per image at two resolutions, for robots apart and
for the hard images of the camera study, the first images with their calibration among them. The target is image to
fixes in at most 15 ms at 640 x 480; exit code 1: an image took longer, on this machine as busy as it was.
Run it on an otherwise idle machine: ``PYTHONPATH=scripts python benchmarks/bench_vision.py [--renderer bullet]``.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import replace

import cv2
import numpy as np

from mission_computer.vision.camera_localizer import CameraLocalizer
from mission_computer.vision.config import VisionConfig
from studies.camera_cases import Case, arena_markers, covers, hard_case, plain_case, shot
from swarm_msgs_py.markers import CoverMarker, FloorMarks
from swarm_msgs_py.randomness import rng_for
from swarm_sim.camera.overhead_camera import OverheadCamera
from swarm_sim.config import CameraConfig, Renderer

IMAGES = 100
SEED = 7
SIZES = ((640, 480), (1280, 960))
JUDGED, LIMIT_MS = (640, 480), 15.0
"""The size for which there is a target, and the target [ms]."""
KINDS: dict[str, Callable[[tuple[CoverMarker, ...], np.random.Generator], Case]] = {
    "robots apart": plain_case,
    "hard": hard_case,
}


def main(argv: Sequence[str] | None = None) -> int:
    """Measure and print the table; return the exit code."""
    parser = argparse.ArgumentParser(description="Time the camera and its reader.")
    parser.add_argument("--renderer", choices=[each.value for each in Renderer], default=Renderer.RASTER.value)
    renderer = Renderer(parser.parse_args(argv).renderer)
    cv2.setNumThreads(1)
    slowest = 0.0
    print(f"{'image':<12}{'content':<14}{'take ms':>9}{'read ms':>9}{'99 % ms':>9}{'max ms':>9}{'found':>8}")
    for width, height in SIZES:
        config = replace(CameraConfig(is_on=True), width_px=width, height_px=height)
        camera = OverheadCamera(config, covers(), FloorMarks(), SEED, renderer)
        for name, make in KINDS.items():
            taking, reading, found = measure(camera, make)
            slowest = max(slowest, *reading) if (width, height) == JUDGED else slowest
            print(
                f"{f'{width}x{height}':<12}{name:<14}{np.median(taking):>9.1f}{np.median(reading):>9.1f}"
                f"{np.percentile(reading, 99.0):>9.1f}{max(reading):>9.1f}{found:>8}"
            )
        camera.close()
    return int(slowest > LIMIT_MS)


def measure(
    camera: OverheadCamera, make: Callable[[tuple[CoverMarker, ...], np.random.Generator], Case]
) -> tuple[list[float], list[float], int]:
    """Return what taking and reading each image cost [ms], from the first on, and how many fixes there were."""
    markers, vision = arena_markers(), VisionConfig()
    localizer = CameraLocalizer(vision, markers, FloorMarks())
    taking, reading, found = [], [], 0
    for number in range(IMAGES + vision.calibration_frames):
        rng = rng_for(SEED, "vision benchmark", number)
        case = (plain_case if number < vision.calibration_frames else make)(markers, rng)
        began = time.thread_time()
        image = shot(camera, number, 100.0 * number, case)
        taken = time.thread_time()
        report = localizer.locate(image, camera.info)
        reading.append(1e3 * (time.thread_time() - taken))
        taking.append(1e3 * (taken - began))
        found += len(report.fixes)
    return taking, reading, found


if __name__ == "__main__":
    sys.exit(main())
