"""Whether the libraries that a run needs are there."""

from __future__ import annotations

import importlib.util

from bringup.scenario import Scenario
from swarm_msgs_py.errors import ConfigError
from swarm_sim.config import Backend


def check_physics(scenario: Scenario) -> None:
    """Refuse a physics back end whose library is not installed.

    Raises
    ------
    ConfigError
        Naming what to install or use instead.
    """
    if scenario.sim.physics.backend is Backend.BULLET and importlib.util.find_spec("pybullet") is None:
        raise ConfigError("sim.physics.backend: pybullet is not installed; run `make`, or use --physics massdamper")
