"""The camera: what it follows, how it frames and moves, and what it focuses on."""
