"""Settings of the camera localization."""

from __future__ import annotations

from dataclasses import dataclass

from swarm_msgs_py.config import Config, setting

HUE_TOLERANCE_MAX_RAD = 0.42
"""With a larger one, hues of blue and pink would lie within reach of each other; half of the least gap is 0.428 rad."""


@dataclass(frozen=True, slots=True, kw_only=True)
class VisionConfig(Config):
    """How robots are found in images."""

    calibration_frames: int = setting(
        10, "images from which the camera's place is found; the first of them already gives fixes", minimum=1
    )
    calibration_error_px: float = setting(
        2.0,
        "largest distance of a floor mark from where the calibration expects it; what a maker says wrongly of a lens "
        "makes a few tenths, a wrong mark tens",
        unit="pixels",
        above=0.0,
    )
    recheck_frames: int = setting(
        50, "images between two looks at the marks, whether the camera is still where it was", minimum=1
    )
    moved_px: float = setting(
        1.5,
        "the camera has moved when three of the marks are farther than this from where they were",
        unit="pixels",
        above=0.0,
    )
    spread_min_codes: int = setting(
        24, "least difference between color channels of a pixel that is looked at", unit="codes of 255", minimum=1
    )
    saturation_min: float = setting(
        0.35, "least chroma per lightness (CIELAB) of a disc; does not depend on the light", minimum=0.0
    )
    hue_tolerance_rad: float = setting(
        0.38,
        "largest difference of a pixel's CIELAB hue from that of its color",
        unit="rad",
        above=0.0,
        maximum=HUE_TOLERANCE_MAX_RAD,
    )
    area_min_px: int = setting(
        12, "fewer colored pixels than this are no disc, in an image of 480 rows", unit="pixels", minimum=1
    )
    dead_code: int = setting(
        8, "pixels with no channel above this show nothing, not even a black cover", unit="codes of 255", minimum=0
    )
    radius_tolerance: float = setting(
        0.12,
        "largest relative error of a disc's radius; tolerances of discs grow below a radius of 3.6 pixels",
        above=0.0,
        maximum=0.25,
    )
    elongation_max: float = setting(1.15, "largest ratio of a disc's axes", minimum=1.0)
    solidity_tolerance: float = setting(
        0.1, "largest relative difference between a blob's area and that of the ellipse of its moments", above=0.0
    )
    spot_px: float = setting(
        1.5,
        "side of the square that lens and sensor spread a point over; widens the moments of small discs",
        unit="pixels",
        minimum=0.0,
        maximum=4.0,
    )
    backing_max: float = setting(
        0.3, "largest brightness of what surrounds a disc, relative to the disc: covers are black", above=0.0
    )
    baseline_tolerance_m: float = setting(
        0.005, "largest error of the distance between the two discs of a cover", unit="m", above=0.0
    )
    center_sigma_px: float = setting(
        0.05, "standard deviation of a disc's measured middle, per axis", unit="pixels", above=0.0
    )
    calibration_sigma_m: float = setting(
        0.0005,
        "standard deviation, per axis, of what is left of errors of lens and calibration",
        unit="m",
        minimum=0.0,
    )
    reach_mps: float = setting(
        0.3,
        "how fast a robot may have moved since its last fix; a cover farther away is not its own, unless it stays",
        unit="m/s",
        above=0.0,
    )
    reach_m: float = setting(0.03, "and how far in no time", unit="m", minimum=0.0)
    moved_images: int = setting(
        10,
        "a robot that shows where it cannot have driven is believed after this many images in a row: it was carried",
        minimum=1,
    )
    notice_after_s: float = setting(
        0.3, "what is not as it should be for this long is told to the operator", unit="s", minimum=0.0
    )
    notice_over_s: float = setting(
        1.0,
        "and so is what more than half of the images of this long show; it is over when at most a quarter show it",
        unit="s",
        above=0.0,
    )
    dead_share_max: float = setting(0.1, "larger share of black pixels than this is told", above=0.0, maximum=1.0)
    touch_m: float = setting(
        0.004, "robots with a smaller gap than this between their covers touch, as far as one can see", unit="m"
    )
