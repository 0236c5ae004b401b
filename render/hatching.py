"""Hatching: ground that is shown in the colour of a warning, with a rim and slanting lines."""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

from render.color import linear

TINTED = "vertex_tinted"
"""Mesh attribute: share of the faces about a vertex that are to be hatched, 0 to 1."""

WARNING = (0.85, 0.12, 0.06)
"""The colour of a warning, sRGB."""

TINT, LINE, RIM = 0.42, 0.30, 0.35
"""Share of that colour between the lines, and what lines and the rim add to it."""

SPACING = 0.24
"""From line to line [m]."""


def hatched(si: Any, color: Any) -> Any:
    """Return the colour of ground, hatched where its attribute says so."""
    share = si.shape.eval_attribute_1(TINTED, si)
    inside = _step((share - 0.42) * (1.0 / 0.16))
    rim = _step(1.0 - dr.abs(share - 0.5) * (1.0 / 0.16))
    across = (si.p.x + si.p.z + 0.5 * si.p.y) * (1.0 / SPACING)
    line = _step(1.5 - 5.0 * dr.abs(across - dr.floor(across) - 0.5))
    tint = inside * (TINT + dr.maximum(LINE * line, RIM * rim))
    return dr.lerp(color, mi.Color3f(*(float(c) for c in linear(WARNING))), tint)


def _step(t: Any) -> Any:
    t = dr.clip(t, 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)
