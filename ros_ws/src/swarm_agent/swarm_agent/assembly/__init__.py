"""Stage IV of an assembly: a boat finds its way to its partner, or follows timed guideposts."""
