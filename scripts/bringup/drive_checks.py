"""Checks of wheels before anything starts: whether robots can move as their controllers ask them to."""

from __future__ import annotations

import math

from bringup.scenario import Scenario
from swarm_msgs_py.errors import ConfigError
from swarm_sim.config import Drive, Ground


def check_drive(scenario: Scenario) -> None:
    """Refuse wheels on a ground that they do not roll on, and step motors too slow or too coarse for the controllers.

    Raises
    ------
    ConfigError
        Naming the settings.
    """
    drive, control = scenario.sim.drive, scenario.agent.control
    if drive.kind is not Drive.OMNI_WHEELS:
        return
    if scenario.sim.terrain.ground is not Ground.PLANE:
        raise ConfigError("omni wheels roll on even ground alone; set sim.terrain.ground to plane")
    omni = drive.omni
    steps_per_m = omni.steps_per_turn / (2.0 * math.pi * omni.wheel_radius_m)
    fastest = control.speed_max_m_s * steps_per_m
    if omni.rate_max_hz < fastest:
        raise ConfigError(
            f"sim.drive.omni.rate_max_hz ({omni.rate_max_hz:g} Hz) is less than the {fastest:.0f} Hz that "
            f"agent.control.speed_max_m_s ({control.speed_max_m_s:g} m/s) takes; raise the one or lower the other"
        )
    slowest = min(control.gain_1_s * control.park_m, control.speed_max_m_s) * steps_per_m
    if omni.rate_resolution_hz > slowest:
        raise ConfigError(
            f"sim.drive.omni.rate_resolution_hz ({omni.rate_resolution_hz:g} Hz) is coarser than the {slowest:.0f} Hz "
            "with which a robot comes to its goal (agent.control.gain_1_s times park_m); lower it"
        )
