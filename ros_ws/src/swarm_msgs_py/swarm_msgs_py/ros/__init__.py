"""The shared half of the seam between cores and ROS: channels, conversions, parameters, running nodes."""
