"""Gaits, paces, moods, and the transitions between them."""
