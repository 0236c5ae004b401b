"""Gesture: what people tell one another with hands and head, beside what they do."""

from __future__ import annotations

GREET, POINT, REFUSE = "greet", "point", "refuse"

GESTURES = (GREET, POINT, REFUSE)
"""Names of gestures."""
