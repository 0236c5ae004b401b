"""Tracing: rays through the pixels of a Mitsuba scene, pass by pass."""
