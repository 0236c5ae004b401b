"""Pronking: creatures that hop, by forces of their legs (Sims 1987, chapter 11)."""
