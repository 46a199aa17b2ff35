"""Orders to a swarm that runs over ROS, for people without the ``ros2`` command."""
