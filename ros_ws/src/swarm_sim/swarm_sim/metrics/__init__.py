"""What happened in a run: the recorded trace and the measures of spec section 14, from true states only."""
