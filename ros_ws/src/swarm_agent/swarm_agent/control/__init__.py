"""How do I get there? Path following and collision avoidance: a velocity for the firmware."""
