"""Dancers: a torso, two controllers, the dance, the measure (Matarić, Zordan and Mason 1998)."""
