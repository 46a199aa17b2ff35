"""The assembly family behind the seam of `bringup.family`."""
