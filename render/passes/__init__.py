"""Passes for compositing: what the camera meets first, beside the light."""
