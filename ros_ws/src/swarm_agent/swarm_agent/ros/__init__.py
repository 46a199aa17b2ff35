"""ROS face of one robot."""
