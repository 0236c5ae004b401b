"""Surroundings: the land that goes on from the edge of the terrain to the horizon."""
