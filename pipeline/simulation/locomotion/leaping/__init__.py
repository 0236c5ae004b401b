"""Leaping: jumps of creatures that walk, and how they are handed over between the two."""
