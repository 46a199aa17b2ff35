"""CuBoats in continuous space: hull, thrusters, magnets, wind and waves, and the firmware that holds a pose."""
