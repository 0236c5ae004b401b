"""Surfaces: materials and their patterns as Mitsuba BSDFs."""
