"""Where am I? Inertial dead reckoning, corrected by position fixes (thesis section 3.2.4)."""
