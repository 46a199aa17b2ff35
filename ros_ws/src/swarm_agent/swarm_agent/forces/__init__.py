"""Where do the forces of the shape, of the neighbors and of the obstacles drive me? (method A of the thesis)."""
