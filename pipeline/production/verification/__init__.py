"""Verification: whether the outputs of a scene are what was written."""
