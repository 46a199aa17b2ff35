"""What the cores log, as ROS log messages of the node that runs them."""

from __future__ import annotations

import logging

from rclpy.impl.logging_severity import LoggingSeverity
from rclpy.impl.rcutils_logger import RcutilsLogger
from rclpy.node import Node


class RosLogHandler(logging.Handler):
    """Hands records of Python's `logging` to a ROS logger.

    Parameters
    ----------
    logger : RcutilsLogger
        From ``node.get_logger()``; child loggers are named after the Python loggers.
    """

    def __init__(self, logger: RcutilsLogger) -> None:
        super().__init__()
        self._logger = logger

    def emit(self, record: logging.LogRecord) -> None:
        """Log one record under the nearest ROS severity."""
        severity = LoggingSeverity(min(record.levelno // 10 * 10, LoggingSeverity.FATAL) or LoggingSeverity.DEBUG)
        self._logger.get_child(record.name).log(self.format(record), severity)


def bridge_logging(node: Node, level: int = logging.INFO) -> None:
    """Send everything that this process logs to the logger of a node, and nowhere else."""
    root = logging.getLogger()
    root.handlers = [RosLogHandler(node.get_logger())]
    root.setLevel(level)
