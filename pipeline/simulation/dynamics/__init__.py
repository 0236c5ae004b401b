"""Mass and what follows from it (Sims 1987, ch. 7)."""
