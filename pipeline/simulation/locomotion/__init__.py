"""Gaits, steps, body paths, walking (Sims 1987, ch. 9 and 10)."""
