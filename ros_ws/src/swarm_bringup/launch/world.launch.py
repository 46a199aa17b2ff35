"""The world and the mission computer, for robots elsewhere: ``ros2 launch swarm_bringup world.launch.py``."""

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

ARGUMENTS = {
    "counts": ("3", "number of robots of types 1, 2 and 3, as in 3,2,1; they are numbered in this order"),
    "shape": ("hw_2_square", "shape to form: library name, file, or text:TEXT"),
    "room_m2": ("6.0", "the shape is made this large per robot [m^2]; 0: it is as large as it is"),
    "spacing_m": ("2.0", "distance between robots at the start [m]"),
    "period_s": ("0.5", "control period [s], the same for all"),
    "real_time": ("true", "true: pace by the wall clock; false: as fast as everybody answers"),
    "seed": ("0", "seed of everything that is drawn"),
}


def generate_launch_description() -> LaunchDescription:
    """Return both nodes; when either ends, whatever was launched with it ends, too: nothing could go on."""
    declared = [DeclareLaunchArgument(name, default_value=text, description=about)
                for name, (text, about) in ARGUMENTS.items()]  # fmt: skip
    return LaunchDescription([*declared, OpaqueFunction(function=_nodes)])


def _nodes(context: LaunchContext) -> list[Node]:
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    counts, period_s = [int(count) for count in given["counts"].split(",")], float(given["period_s"])
    world = {
        "counts": counts,
        "spacing_m": float(given["spacing_m"]),
        "seed": int(given["seed"]),
        "period_s": period_s,
        "real_time": given["real_time"].lower() == "true",
    }
    shape = ParameterValue(LaunchConfiguration("shape"), value_type=str)  # else its text would be read as YAML
    mission = {"counts": counts, "shape": shape, "room_m2": float(given["room_m2"]), "period_s": period_s}
    starts = (("swarm_sim", "world_node", world), ("mission_computer", "mission_node", mission))
    return [
        Node(
            package=package,
            executable=executable,
            parameters=[settings],
            output="screen",
            on_exit=Shutdown(reason=f"{executable} has ended"),
        )
        for package, executable, settings in starts
    ]
