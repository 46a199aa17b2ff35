"""From a shape to goals, one per robot."""

from mission_computer.partition.config import Method, PartitionConfig
from mission_computer.partition.partitioning import GoalSet, adapt, check_fits, partition

__all__ = ["GoalSet", "Method", "PartitionConfig", "adapt", "check_fits", "partition"]
