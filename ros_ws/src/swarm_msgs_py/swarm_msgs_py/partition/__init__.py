"""From a shape to goals, one per robot."""

from swarm_msgs_py.partition.config import Method, PartitionConfig
from swarm_msgs_py.partition.partitioning import GoalSet, adapt, check_fits, forget, needed_scale, partition

__all__ = ["GoalSet", "Method", "PartitionConfig", "adapt", "check_fits", "forget", "needed_scale", "partition"]
