"""The one place that knows which back ends there are."""

from __future__ import annotations

from importlib import import_module

from swarm_msgs_py.errors import PhysicsError
from swarm_sim.config import Backend, Drive, SimConfig
from swarm_sim.scene import Scene
from swarm_sim.world.massdamper_world import MassDamperWorld
from swarm_sim.world.wheeled_world import WheeledWorld
from swarm_sim.world.world import World


def make_world(config: SimConfig, scene: Scene, seed: int) -> World:
    """Return a started world of the configured back end.

    Parameters
    ----------
    config : SimConfig
    scene : Scene
        Checked scene.
    seed : int
        Seed of the run; shapes the terrain, and the slip of wheels.

    Raises
    ------
    PhysicsError
        If the back end is not installed or refuses the scene.
    """
    if config.physics.backend is Backend.MASSDAMPER:
        has_wheels = config.drive.kind is Drive.OMNI_WHEELS
        return WheeledWorld(config, scene, seed) if has_wheels else MassDamperWorld(config, scene)
    try:
        # Imported on demand: the other back end must work where this one is not installed.
        module = import_module("swarm_sim.world.pybullet_world")
    except ImportError as error:
        raise PhysicsError(
            f"physics back end 'bullet' is not installed ({error}); install pybullet or use --physics massdamper"
        ) from error
    world: World = module.PyBulletWorld(config, scene, seed)
    return world
