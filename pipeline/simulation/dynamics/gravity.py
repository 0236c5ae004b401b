"""Gravity: one number that all who fall share."""

GRAVITY = 9.81
"""Of the earth, downward along Y [m/s²]."""
