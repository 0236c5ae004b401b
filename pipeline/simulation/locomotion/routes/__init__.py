"""Routes of walking creatures, their progress, and the trajectories of their bodies."""
