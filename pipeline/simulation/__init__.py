"""Scene -> Take: everything that moves, and nothing of how it is filmed."""
