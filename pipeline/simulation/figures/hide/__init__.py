"""Hides: grown-together surfaces of animals, meshed once as they stand."""
