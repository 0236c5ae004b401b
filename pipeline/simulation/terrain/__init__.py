"""Surface height, slope and forbidden zones (Sims 1987, ch. 8)."""

from pipeline.simulation.terrain.ground import Ground, build_ground, level_ground

__all__ = ["Ground", "build_ground", "level_ground"]
