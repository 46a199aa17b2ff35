"""Where should I be? Plan, cost rows, assignment: the goal that this robot takes."""
