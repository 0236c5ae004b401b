"""Gravity: the acceleration that all rooms share."""

GRAVITY = 9.81
"""Of the earth, downward along Y [m/s²]."""
