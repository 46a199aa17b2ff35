"""A whole swarm on one machine: ``ros2 launch swarm_bringup swarm.launch.py counts:=3,2,1 shape:=hw_3_pentagon``."""

from pathlib import Path

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription, OpaqueFunction
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

WORLD = Path(__file__).parent / "world.launch.py"


def generate_launch_description() -> LaunchDescription:
    """Return the world and the mission computer, with their arguments, and one node per robot.

    Everything ends with the world or the mission computer; when a robot's node ends, the swarm goes on without it.
    """
    counts = DeclareLaunchArgument("counts", default_value="3", description="robots of types 1, 2 and 3, as in 3,2,1")
    period = DeclareLaunchArgument("period_s", default_value="0.5", description="control period [s]")
    world = IncludeLaunchDescription(PythonLaunchDescriptionSource(str(WORLD)))
    return LaunchDescription([counts, period, world, OpaqueFunction(function=_robots)])


def _robots(context: LaunchContext) -> list[Node]:
    counts = [int(count) for count in LaunchConfiguration("counts").perform(context).split(",")]
    period_s = float(LaunchConfiguration("period_s").perform(context))
    types = [kind for kind, count in enumerate(counts, start=1) for _ in range(count)]
    return [
        Node(
            package="swarm_agent",
            executable="agent_node",
            parameters=[{"robot": robot, "type": kind, "period_s": period_s}],
            output="screen",
        )
        for robot, kind in enumerate(types)
    ]
