"""What runs on a robot's microcontroller, at the physics rate."""
