"""Settings of the local positioning system (section ``lps`` of a scenario)."""

from __future__ import annotations

from dataclasses import dataclass

from swarm_msgs_py.config import Config, setting


@dataclass(frozen=True, slots=True, kw_only=True)
class LpsConfig(Config):
    """What the filter believes about its sensors, and when it stops believing a fix."""

    acceleration_sigma_mps2: float = setting(
        0.01, "standard deviation of a mean acceleration, per axis (thesis section 4.2)", unit="m/s^2", minimum=0.0
    )
    acceleration_bias_max_mps2: float = setting(
        9.8e-4, "largest accelerometer bias, 0.1 mg, per body axis (thesis section 4.2)", unit="m/s^2", minimum=0.0
    )
    yaw_sigma_rad: float = setting(
        0.01, "standard deviation of the heading; turns part of an acceleration sideways", unit="rad", minimum=0.0
    )
    push_delay_s: float = setting(
        0.12, "when in a period the velocity changes: the delay of the velocity servo, 2 zeta / omega_n (spec 12.2)",
        unit="s", minimum=0.0,
    )  # fmt: skip
    push_delay_sigma_s: float = setting(0.03, "how far that may be off", unit="s", minimum=0.0)
    initial_speed_sigma_mps: float = setting(
        0.1, "standard deviation of the velocity at the first fix, per axis; robots start at rest",
        unit="m/s", minimum=0.0,
    )  # fmt: skip
    restart_speed_sigma_mps: float = setting(
        0.5, "the same when the filter restarts in motion (top speed)", unit="m/s", minimum=0.0
    )
    gate_chi_square: float = setting(
        13.8, "a fix is rejected if its normalized innovation squared exceeds this (2 d.o.f., 0.999)", above=0.0
    )
    rejections_max: int = setting(
        5, "consecutive rejections after which the filter doubts itself and restarts at the fix", minimum=1
    )
