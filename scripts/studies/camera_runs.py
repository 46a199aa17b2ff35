"""One run of the camera study: one camera, freshly mounted, and a sequence of images that have nothing in common.

But for look-alikes: the image before one shows the same robots without it.
"""

from __future__ import annotations

import time
from collections import Counter
from dataclasses import dataclass, replace

import cv2
import numpy as np

from mission_computer.vision.camera_localizer import CameraLocalizer
from mission_computer.vision.config import VisionConfig
from studies.camera_cases import Case, arena_markers, before, covers, hard_case, in_view, plain_case, shot
from studies.camera_scores import Scores
from swarm_msgs_py.markers import FloorMarks
from swarm_msgs_py.messages.camera_report import CameraReport, CameraStatus
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import BoolArray
from swarm_sim.camera.overhead_camera import OverheadCamera
from swarm_sim.config import CameraConfig, Renderer
from swarm_sim.metrics.camera import FALSE_M

FRAME_S = 100.0
"""Time between two images that have nothing in common [s]: so long that no track helps, nor hinders."""
WATCHED_S = 0.1
"""Time from the image before a look-alike appears [s]: tracks tell the two apart, images cannot."""


@dataclass(frozen=True, slots=True)
class Run:
    """What a worker needs to know.

    Attributes
    ----------
    seed : int
        Of camera, light and images.
    images : int
        How many count, after those from which the camera is calibrated.
    renderer : Renderer
        What draws them.
    """

    seed: int
    images: int
    renderer: Renderer = Renderer.RASTER

    @property
    def key(self) -> str:
        """Return what distinguishes this run from any other."""
        return f"seed={self.seed},images={self.images},renderer={self.renderer.value}"


def perform(run: Run) -> Scores:
    """Take the images of a run and read them; equal runs give equal scores, but for the time they took."""
    cv2.setNumThreads(1)
    markers, marks, vision = arena_markers(), FloorMarks(), VisionConfig()
    config = _varied(CameraConfig(is_on=True), run.seed)
    camera = OverheadCamera(config, covers(), marks, run.seed, run.renderer)
    localizer = CameraLocalizer(vision, markers, marks)
    scores = Scores(images=run.images)
    costs: list[float] = []

    def read(number: int, instant: float, case: Case) -> CameraReport:
        image = shot(camera, number, instant, case)
        began = time.thread_time()
        report = localizer.locate(image, camera.info)
        costs.append(1e3 * (time.thread_time() - began))
        return report

    for number in range(run.images + vision.calibration_frames):
        rng = rng_for(run.seed, "camera study", number)
        is_first, instant = number < vision.calibration_frames, FRAME_S * number
        case = plain_case(markers, rng) if is_first else hard_case(markers, rng)
        prelude = before(case)
        if prelude is not None:
            read(number, instant - WATCHED_S, prelude)
        report = read(number, instant, case)
        if not is_first:
            scores = _counted(scores, report, case, in_view(case, markers, camera.optics))
    camera.close()
    return replace(scores, cost_ms=(*np.percentile(costs, (50.0, 99.0)).tolist(), max(costs)))


def _varied(config: CameraConfig, seed: int) -> CameraConfig:
    """Return another light, lens and sensor for each seed."""
    rng = rng_for(seed, "camera study settings")
    return replace(
        config,
        radial_distortion=float(rng.uniform(-0.1, 0.0)),
        light_gradient=float(rng.uniform(0.0, 0.5)),
        vignette=float(rng.uniform(0.0, 0.3)),
        noise_codes=float(rng.uniform(1.0, 4.0)),
        spot_px=float(rng.uniform(1.0, 2.0)),
    )


def _counted(scores: Scores, report: CameraReport, case: Case, seen: BoolArray) -> Scores:
    """Return the scores with one more image."""
    found = {int(fix.robot): fix for fix in report.fixes}
    fixes = [fix for robot, fix in sorted(found.items()) if seen[robot]]
    errors = [float(np.hypot(*(fix.position - case.positions[fix.robot]))) for fix in fixes]
    turns = [float(abs((fix.yaw - case.yaws[fix.robot] + np.pi) % (2.0 * np.pi) - np.pi)) for fix in fixes]
    false = sum(float(np.hypot(*(fix.position - case.positions[fix.robot]))) > FALSE_M for fix in report.fixes)
    hidden = Counter(r.reason.value for r in report.rejections if not seen[r.robot])
    missed = Counter(r.reason.value for r in report.rejections if seen[r.robot])
    if report.status is not CameraStatus.OK:
        missed[report.status.value] += int(seen.sum())
    # A fix of something else is a false identity; it would only blur what the errors of true fixes are.
    true = [(error, turn) for error, turn in zip(errors, turns, strict=True) if error <= FALSE_M]
    return replace(
        scores,
        in_view=scores.in_view + int(seen.sum()),
        found=scores.found + len(true),
        false=scores.false + false,
        beyond_view=scores.beyond_view + int((~seen).sum()),
        found_beyond=scores.found_beyond + len(found) - len(fixes),
        square_sum_m2=scores.square_sum_m2 + sum(error**2 for error, _ in true),
        max_m=max([scores.max_m, *(error for error, _ in true)]),
        square_sum_rad2=scores.square_sum_rad2 + sum(turn**2 for _, turn in true),
        max_rad=max([scores.max_rad, *(turn for _, turn in true)]),
        missed=_added(scores.missed, missed),
        hidden=_added(scores.hidden, hidden),
    )


def _added(one: dict[str, int], other: Counter[str]) -> dict[str, int]:
    return dict(sorted((Counter(one) + other).items()))
