"""Experiment `formation`: fifty robots in their places, real sensors, radio and localizers, and nothing else.

Robots are told where they start with an error of 2 m (erratum E14), exchange hellos over the simulated radio, range to
their neighbors and run the localizer of the product. There is no decision, no control and no loss, so the errors are
those of localization alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from bringup.compose import ScenarioActors
from bringup.cross_checks import first_plan
from bringup.layout import robot_types, told_start, walls
from bringup.resolution import contour_of, resolve
from bringup.scenario import Scenario
from bringup.scenario_file import ROBOT_COUNT, Override, load_scenario
from studies.lps_cells import Cell, Motion, Trial
from studies.lps_scores import Scores, score
from studies.wandering import Wandering
from swarm_agent.localization.estimate import Estimate
from swarm_agent.localization.localizer import Localizer
from swarm_agent.localization.positioning import PositioningMonitor, Signs
from swarm_msgs_py.frames import decode_frame, encode_frame
from swarm_msgs_py.messages.control import VelocityCommand
from swarm_msgs_py.messages.radio import SIGMA_UNKNOWN, Hello, Presence, RouteRows
from swarm_msgs_py.messages.report import Positioning
from swarm_msgs_py.networking.neighbors import NeighborTable
from swarm_msgs_py.roster import Roster
from swarm_msgs_py.step_io import AgentInputs
from swarm_msgs_py.types import FloatArray, NodeId
from swarm_sim.scene import Scene

SCENARIO = "formation-50"
SHAPES = ("formation_1", "formation_2", "formation_3", "formation_4")
_NO_ROUTES = RouteRows(*(np.zeros(0, dtype=np.int64) for _ in range(3)))
_ORIGIN, _NO_IDEA = np.zeros(2), np.eye(2) * SIGMA_UNKNOWN**2


def shape_of(seed: int) -> str:
    """Return the shape of a seed: the four formation shapes in turn."""
    return SHAPES[(seed - 1) % len(SHAPES)]


def overrides_of(cell: Cell, seed: int, robots: int) -> tuple[Override, ...]:
    """Return what a cell and a seed change in the scenario."""
    settings: Mapping[str, object] = {
        ROBOT_COUNT: robots,
        "seed": seed,
        "shape.name": shape_of(seed),
        "robots.position_sensor_share": cell.share,
        "sim.physics.backend": "massdamper",
        "sim.ranging.model": cell.ranging.value,
        "sim.ranging.sigma_m": cell.sigma_m,
        "agent.lps.mode": cell.mode.value,
        "agent.lps.period_s": cell.period_s,
        "agent.lps.range_sigma_m": cell.sigma_m,
        "agent.lps.position_noise_sigma_m": cell.sigma_m,
    }
    return tuple(Override("study", key, value) for key, value in settings.items())


def in_formation(cell: Cell, seed: int, robots: int) -> Scenario:
    """Return the resolved scenario in which the robots start at goals of their types, in the order of ids."""
    scenario, _ = load_scenario(SCENARIO, overrides_of(cell, seed, robots))
    ground, places = _ground(shape_of(seed), robots)
    start = replace(scenario.robots.start, positions_m=places)
    # Nobody looks at what is near here, and looking costs as much time as all other sensors.
    sim = replace(scenario.sim, proximity=replace(scenario.sim.proximity, range_m=0.0))
    return replace(scenario, shape=ground.shape, map=ground.map, robots=replace(scenario.robots, start=start), sim=sim)


@lru_cache(maxsize=len(SHAPES))
def _ground(shape: str, robots: int) -> tuple[Scenario, tuple[tuple[float, float], ...]]:
    """Return a scenario with shape and map written out, and one goal per robot; neither depends on cell or seed."""
    scenario = resolve(
        *load_scenario(SCENARIO, (Override("study", ROBOT_COUNT, robots), Override("study", "shape.name", shape)))
    )
    types = robot_types(scenario)
    plan = first_plan(scenario, contour_of(scenario), Roster.of(types), walls(scenario))
    goals_of = {number: iter(plan.goals[plan.goal_types == number].tolist()) for number in {t.type for t in types}}
    return scenario, tuple((x, y) for x, y in (next(goals_of[kind.type]) for kind in types))


@dataclass(frozen=True, slots=True, eq=False)
class Belief:
    """What one robot says of itself in one tick.

    Attributes
    ----------
    estimate : Estimate or None
    is_localized : bool
        Whether it counts itself as localized, by the rule of its mode (spec section 6).
    hello : bytes
        Frame that tells its neighbors.
    """

    estimate: Estimate | None
    is_localized: bool
    hello: bytes


class Robot:
    """One robot that does nothing but localize itself, and tell its neighbors where it is.

    Parameters
    ----------
    robot : NodeId
    scenario : Scenario
        Resolved.
    scene : Scene
    is_parked : bool
        Whether it knows that it stands still.
    """

    def __init__(self, robot: NodeId, scenario: Scenario, scene: Scene, *, is_parked: bool) -> None:
        self._id, self._type, self._is_parked = robot, scene.robots[robot].type.type, is_parked
        start, period, lps = told_start(scenario, scene, robot), scenario.sim.period_s, scenario.agent.lps
        self._localizer = Localizer(lps, period, start)
        self._monitor = PositioningMonitor(lps, period)
        self._neighbors = NeighborTable(scenario.agent.network.missed_adverts)

    def step(self, inputs: AgentInputs) -> Belief:
        """Advance by one tick."""
        tick, localizer = inputs.tick, self._localizer
        self._neighbors.hear(tick, [frame for frame in map(decode_frame, inputs.inbox) if isinstance(frame, Hello)])
        self._neighbors.expire(tick)
        heard = self._neighbors.presences
        told = _ORIGIN if self._is_parked else None
        estimate = localizer.step(tick, inputs.imu, inputs.fix, inputs.ranges, heard, told=told)
        presence = Presence(
            position=estimate.position if estimate else _ORIGIN,
            velocity=estimate.velocity if estimate else _ORIGIN,
            covariance=estimate.covariance if estimate else _NO_IDEA,
            shared=estimate.shared if estimate else 0.0,
            tick=tick,
            robot_type=self._type,
            is_beacon=localizer.is_beacon,
            mode=0,
            epoch=0,
            digest=0,
        )
        beacons = sum(neighbor.is_beacon for neighbor in heard.values())
        is_corrected = estimate is not None and estimate.is_corrected
        signs = Signs(beacons, localizer.is_beacon, is_corrected, presence.sigma)
        is_localized = self._monitor.step(tick, signs) is Positioning.LOCALIZED
        return Belief(estimate, is_localized, encode_frame(Hello(self._id, tick & 0xFFFF, presence, _NO_ROUTES)))


def run_formation(cell: Cell, seed: int, trial: Trial) -> Scores:
    """Return the scores of one cell and seed.

    Parameters
    ----------
    cell : Cell
    seed : int
    trial : Trial
    """
    scenario = in_formation(cell, seed, trial.robots)
    actors = ScenarioActors(scenario)
    is_parked = cell.motion is Motion.PARKED
    robots = {robot: Robot(robot, scenario, actors.scene, is_parked=is_parked) for robot in actors.robots}
    ticks, count = round(trial.duration_s / scenario.sim.period_s), len(robots)
    estimates, covariances = np.full((ticks, count, 2), np.nan), np.ones((ticks, count, 2, 2))
    truth, is_localized = np.empty((ticks, count, 2)), np.zeros((ticks, count), dtype=np.bool_)
    positions = np.array([spec.position for spec in actors.scene.robots])
    wandering = Wandering(positions, scenario.sim.period_s, seed) if cell.motion is Motion.WANDER else None
    simulation = actors.simulation()
    for tick in range(ticks):
        agents = simulation.observe().agents
        outboxes: dict[NodeId, tuple[bytes, ...]] = {}
        for row, (robot, inputs) in enumerate(agents.items()):
            belief = robots[robot].step(inputs)
            outboxes[robot], is_localized[tick, row] = (belief.hello,), belief.is_localized
            if belief.estimate is not None:
                estimates[tick, row] = belief.estimate.position
                covariances[tick, row] = belief.estimate.covariance
        simulation.apply(_commands(wandering, positions, agents), outboxes)
        motion = simulation.advance()
        truth[tick], positions = motion.positions, motion.samples[-1]
    simulation.close()
    is_blind = np.array([not spec.has_position_sensor for spec in actors.scene.robots])
    is_late = np.arange(ticks) * scenario.sim.period_s >= trial.warm_up_s
    return score(estimates, covariances, truth, is_late[:, None] & is_blind, is_localized)


def _commands(
    wandering: Wandering | None, positions: FloatArray, agents: Mapping[NodeId, AgentInputs]
) -> Mapping[NodeId, VelocityCommand]:
    """Return what the robots are told to do; nothing, if they are to rest."""
    if wandering is None:
        return {}
    yaws = np.array([inputs.imu.yaw for inputs in agents.values()])  # exact unless the scenario makes it noisy
    return dict(zip(agents, wandering.step(positions, yaws), strict=True))
