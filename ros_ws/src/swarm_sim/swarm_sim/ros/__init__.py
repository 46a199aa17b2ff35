"""ROS face of the simulated world."""
