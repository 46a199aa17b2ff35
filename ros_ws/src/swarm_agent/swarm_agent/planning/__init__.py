"""What does it cost to get there? Shortest collision-free paths of a disc among polygons (thesis section 3.4)."""
