"""Checks that need more than one part of a scenario: what each part allows, and all of them together do not."""

from __future__ import annotations

import math

import numpy as np
import shapely

from bringup.labels import first_few
from bringup.layout import rally_point
from bringup.scenario import Scenario
from mission_computer.plan_making import PlanMaker
from swarm_agent.decision.homing import home_point
from swarm_agent.planning.path_planner import planner_for
from swarm_msgs_py.errors import ConfigError, FrameError
from swarm_msgs_py.extensions import STRATEGIES, extension
from swarm_msgs_py.messages.bodies import UNREACHABLE, Plan
from swarm_msgs_py.robots import RobotType
from swarm_msgs_py.roster import Roster
from swarm_msgs_py.types import FloatArray, NodeId, robot_name
from swarm_sim.scene import Scene


def _longest_path_m(scenario: Scenario) -> float:
    """Return the longest path that robots can tell each other [m]: whole steps in 16 bits."""
    return (UNREACHABLE - 1) * scenario.agent.decision.cost_step_m


def check_size(scenario: Scenario, bounds: tuple[float, float, float, float]) -> None:
    """Refuse an arena in which a straight path can be longer than robots can tell.

    Raises
    ------
    ConfigError
    """
    diagonal, longest_m = math.hypot(bounds[2] - bounds[0], bounds[3] - bounds[1]), _longest_path_m(scenario)
    if diagonal > longest_m:
        raise ConfigError(
            f"the arena measures {diagonal:.0f} m across, robots can tell path lengths up to {longest_m:.0f} m; "
            "make it smaller"
        )


def check_margins(scenario: Scenario) -> None:
    """Refuse goals so near to each other that avoidance keeps the neighbors from reaching them.

    Raises
    ------
    ConfigError
        Naming both settings.
    """
    gap, margin = scenario.mission.partition.gaps.robot_m, scenario.agent.control.avoidance.margin_m
    if gap <= 2.0 * margin:
        raise ConfigError(
            f"mission.partition.gaps.robot_m ({gap:g} m) must be more than twice agent.control.avoidance.margin_m "
            f"({margin:g} m), else robots stop before their goals; raise the one or lower the other"
        )


def check_extensions(scenario: Scenario) -> None:
    """Refuse a decision method that no installed package adds.

    Raises
    ------
    ConfigError
        With the nearest name.
    """
    if scenario.agent.decision.strategy is not None:
        extension(STRATEGIES, scenario.agent.decision.strategy)


def check_events(scenario: Scenario) -> None:
    """Refuse events that cannot happen: after the end, to robots that are not there, or to one that is dead by then.

    Raises
    ------
    ConfigError
        Naming the event.
    """
    count, seen = scenario.robots.count, set[int]()
    for number, event in enumerate(scenario.events):
        if event.at_s >= scenario.duration_s:
            raise ConfigError(
                f"events[{number}].at_s: {event.at_s:g} s is not before the time limit of {scenario.duration_s:g} s; "
                "lower it, or raise duration_s"
            )
        for robot in event.kill:
            name = robot_name(NodeId(robot))
            if robot >= count:
                raise ConfigError(f"events[{number}].kill: there is no {name}; the robots are r00 to {_last_of(count)}")
            if robot in seen:
                raise ConfigError(f"events[{number}].kill: {name} is killed twice; remove it here or there")
            seen.add(robot)
    for number, event in enumerate(scenario.events):
        for robot in event.add:
            _check_addition(scenario, number, robot)
    stops = [number for number, event in enumerate(scenario.events) if event.stop is not None]
    if len(stops) > 1:
        raise ConfigError(f"events[{stops[1]}].stop: the mission computer is stopped twice; remove it here or there")


def _check_addition(scenario: Scenario, number: int, robot: int) -> None:
    """Refuse a robot that is not there, is added twice, or dies at the time or later."""
    name = robot_name(NodeId(robot))
    if robot >= scenario.robots.count:
        raise ConfigError(
            f"events[{number}].add: there is no {name}; the robots are r00 to {_last_of(scenario.robots.count)}"
        )
    if sum(event.add.count(robot) for event in scenario.events) > 1:
        raise ConfigError(f"events[{number}].add: {name} is added twice; remove it here or there")
    at_s = scenario.events[number].at_s
    if any(robot in event.kill and event.at_s >= at_s for event in scenario.events):
        raise ConfigError(
            f"events[{number}].add: {name} is killed then, or later; a robot may come back, but not die after"
        )


def _last_of(count: int) -> str:
    return robot_name(NodeId(count - 1))


def plan_maker(scenario: Scenario, roster: Roster, obstacles: tuple[FloatArray, ...]) -> PlanMaker:
    """Return what makes the plans of the mission computer."""
    mission = scenario.mission
    return PlanMaker(mission.partition, roster, obstacles, scenario.map.bounds_m, mission.asked)


def first_plan(scenario: Scenario, contour: FloatArray, roster: Roster, obstacles: tuple[FloatArray, ...]) -> Plan:
    """Return the plan that the mission computer will make first; see `first_plan_of`."""
    return first_plan_of(plan_maker(scenario, roster, obstacles), contour)


def first_plan_of(maker: PlanMaker, contour: FloatArray) -> Plan:
    """Return the first plan of who makes all of them.

    Raises
    ------
    ConfigError
        If it is too large for the radio.
    ShapeError
        If the shape cannot be used.
    """
    try:
        return maker.for_shape(1, contour, ())
    except FrameError as error:
        raise ConfigError(f"the plan cannot be radioed: {error}") from None


def check_reach(scenario: Scenario, scene: Scene, plan: Plan) -> None:
    """Refuse robots without a path to any goal of their type, and goals that no robot of their type has a path to.

    In a plan without goals, the point to which lost robots return stands for them.

    Raises
    ------
    ConfigError
        Naming the robots, or the goal with its place and the clearance that it lacks.
    """
    walled_off: list[NodeId] = []
    longest = 0.0
    for _, kind in sorted({robot.type.type: robot.type for robot in scene.robots}.items()):
        if plan.task.has_goals:
            _check_clearance(scenario, scene, plan, kind)
        costs, robots = _costs(scenario, scene, plan, kind)
        has_path, ids = np.isfinite(costs), np.flatnonzero(plan.goal_types == kind.type)
        walled_off += [robot for robot, row in zip(robots, has_path, strict=True) if not row.any()]
        blocked = np.flatnonzero(~has_path.any(axis=0))
        if len(blocked) and has_path.any():
            raise ConfigError(
                f"no path leads to {_goal(plan, int(ids[blocked[0]]))} for robots of type {kind.type}; "
                "move the obstacles apart, or move the shape"
            )
        longest = max(longest, float(costs[has_path].max(initial=0.0)))
    if walled_off:
        names = first_few([robot_name(robot) for robot in sorted(walled_off)])
        raise ConfigError(
            f"no path leads from {names} to the shape; "
            "move the obstacles apart, or start elsewhere (another seed, start.half_side_m, start.positions_m)"
        )
    longest_m = _longest_path_m(scenario)
    if longest > longest_m:
        raise ConfigError(
            f"a path from start to goal is {longest:.0f} m long, robots can tell lengths up to {longest_m:.0f} m; "
            "open a shorter way between the obstacles, or start nearer"
        )


def check_rally_point(scenario: Scenario, scene: Scene) -> None:
    """Refuse a rally point that some robot cannot drive to.

    Raises
    ------
    ConfigError
        Naming the first such robot, and the setting.
    """
    point = np.array([rally_point(scenario)])
    for robot in scene.robots:
        planner = planner_for(scene.obstacles, robot.type.coverage_radius_m, scenario.agent.planning)
        if not np.isfinite(planner.costs(np.array(robot.position), point)).all():
            raise ConfigError(
                f"{robot_name(robot.id)} has no path to the rally point ({point[0, 0]:g}, {point[0, 1]:g}): it is "
                "in or against an obstacle, outside the arena or walled off; move it into the open"
            )


def _costs(scenario: Scenario, scene: Scene, plan: Plan, kind: RobotType) -> tuple[FloatArray, list[NodeId]]:
    """Return the path length from each robot of a type to each goal of it, (n, g), inf for none [m]; and the robots."""
    planner = planner_for(scene.obstacles, kind.coverage_radius_m, scenario.agent.planning)
    goals = plan.goals[plan.goal_types == kind.type]
    if not plan.task.has_goals:
        goals = home_point(plan.contour, planner.space)[None]
    robots = [robot for robot in scene.robots if robot.type.type == kind.type]
    costs = np.array([planner.costs(np.array(robot.position), goals) for robot in robots])
    return costs, [robot.id for robot in robots]


def _check_clearance(scenario: Scenario, scene: Scene, plan: Plan, kind: RobotType) -> None:
    """Refuse goals in the margin that the path planner keeps to obstacles."""
    space = planner_for(scene.obstacles, kind.coverage_radius_m, scenario.agent.planning).space
    for goal in np.flatnonzero(plan.goal_types == kind.type):
        if space.is_free(plan.goals[goal]):
            continue
        solid = shapely.union_all([shapely.Polygon(obstacle) for obstacle in scene.obstacles])
        free = float(solid.distance(shapely.Point(plan.goals[goal])))
        needed = kind.coverage_radius_m + scenario.agent.planning.clearance_margin_m
        raise ConfigError(
            f"{_goal(plan, int(goal))} cannot be reached by robots of type {kind.type}: the nearest obstacle is "
            f"{free:.2f} m away, their path planner keeps {needed:.2f} m; raise mission.partition.gaps.obstacle_m, "
            "lower agent.planning.clearance_margin_m, or move the shape"
        )


def _goal(plan: Plan, goal: int) -> str:
    x, y = (float(coordinate) for coordinate in plan.goals[goal])
    return f"goal {goal} at ({x:.2f}, {y:.2f})"
