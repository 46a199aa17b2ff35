"""ROS face of the mission computer."""
