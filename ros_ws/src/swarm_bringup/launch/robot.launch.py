"""One robot: ``ros2 launch swarm_bringup robot.launch.py robot:=4 type:=2``."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

ARGUMENTS = {
    "robot": ("0", int, "number of the robot; its namespace is /rNN"),
    "type": ("1", int, "type of the robot: 1, 2 or 3"),
    "period_s": ("0.5", float, "control period [s], the same for all"),
    "start_x_m": ("0.0", float, "where it stands at the start [m], with start_sigma_m"),
    "start_y_m": ("0.0", float, "where it stands at the start [m], with start_sigma_m"),
    "start_sigma_m": ("0.0", float, "standard deviation of that, per axis [m]; 0: not known"),
}
"""Name -> default, type and meaning; each is a parameter of the node. ``ros2 param`` shows all others."""


def generate_launch_description() -> LaunchDescription:
    """Return the node of one robot."""
    declared = [DeclareLaunchArgument(name, default_value=text, description=about)
                for name, (text, _, about) in ARGUMENTS.items()]  # fmt: skip
    parameters = {name: ParameterValue(LaunchConfiguration(name), value_type=kind)
                  for name, (_, kind, _) in ARGUMENTS.items()}  # fmt: skip
    node = Node(package="swarm_agent", executable="agent_node", parameters=[parameters], output="screen")
    return LaunchDescription([*declared, node])
