"""Motion of bodies, heads and free limbs that follows from the walk."""
