"""Dancers: a simulated torso, its two controllers, the dance, the measure (Matarić et al. 1998)."""
