"""The coverage family behind the seam of `bringup.family`."""
