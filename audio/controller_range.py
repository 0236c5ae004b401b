"""Controller range: how far a pitch bend goes."""

from __future__ import annotations

BEND_RANGE = 12
"""Semitones of the full pitch bend, to either side."""
