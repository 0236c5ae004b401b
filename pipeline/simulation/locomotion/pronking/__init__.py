"""Creatures that hop by the forces of their legs (Sims 1987, chapter 11)."""
