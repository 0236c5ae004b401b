"""Lights: sun, sky, moon, stars, studio, panoramas and lamps as Mitsuba emitters."""
