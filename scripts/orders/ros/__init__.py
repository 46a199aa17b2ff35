"""The part of orders that needs ROS."""
