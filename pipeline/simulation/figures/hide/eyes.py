"""Eyes of animals: balls with iris, pupil and a catchlight, between dark lids."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pipeline.simulation.figures.hide.head import Head
from pipeline.simulation.figures.hide.sheets import Paint, lay, linear_color, outward
from pipeline.simulation.figures.hide.stance import smoothstep
from pipeline.simulation.figures.solids import Solid, loft
from pipeline.simulation.spatial import Array, cross, normalized

EYE_AROUND = 16

EYE_ANGLES = np.radians([8, 15, 20, 26, 34, 41, 48, 55, 61, 68, 100])
"""Rings of an eyeball from where it looks [rad]: fine where pupil and iris end."""

PUPIL_DEG, IRIS_DEG = 22.0, 55.0

PUPILS: Mapping[str, tuple[float, float]] = {
    "round": (1.0, 1.0),
    "slit": (1.7, 0.45),
    "bar": (0.65, 1.35),
}
"""Height and width of a pupil by its shape, in those of a round one."""

SCLERA = "#1e1611"
"""Colour of the visible part of an eye around its iris: animals show no white."""

CATCHLIGHT_DEG, CATCHLIGHT_SIZE_DEG = 33.0, 11.0
"""Angle and radius of the reflection of the sky: that of the sun alone is less than a pixel."""

LID_OPENING, LID_CORNERS, LID_DROOP = 57.0, 13.0, 9.0
"""Angle at which lids end, what it is more at the corners, and less above [degrees]."""

LID_RINGS = ((0.0, 1.02), (3.0, 1.11), (11.0, 1.16), (26.0, 1.17), (58.0, 1.02))
"""Rings of lids: angle beyond their edge [degrees], and radius in that of the eye."""

LID_RIM = (1.0, 1.0, 0.7, 0.1, 0.0)
"""Share of the dark rim at these rings: beyond it a lid has the coat of the face."""


def _axes(head: Head, side: float) -> Array:
    """Return rows (3, 3): where an eye looks, up, and ahead."""
    look = head.way(head.skull.look, side)
    up = normalized(cross(look, head.axes[0]))
    up = up if up[1] > 0 else -up
    ahead = cross(look, up)
    ahead = ahead if float((ahead * head.axes[0]).sum()) > 0 else -ahead
    return np.stack([look, up, ahead])


def _ring_places(angles: Array, sizes: Array | float, axes: Array) -> Array:
    """Return places (..., 3) at angles (..., EYE_AROUND) from where an eye looks [rad]."""
    azimuth = np.arange(EYE_AROUND) * (2.0 * np.pi / EYE_AROUND)
    flat = np.cos(azimuth)[:, None] * axes[1] + np.sin(azimuth)[:, None] * axes[2]
    unit = np.cos(angles)[..., None] * axes[0] + np.sin(angles)[..., None] * flat
    return np.asarray(sizes)[..., None] * unit


def eyeball(head: Head, side: float, iris: str) -> tuple[Solid, Paint]:
    """Return an eye, and its paint."""
    axes, size, middle = _axes(head, side), head.eye_radius, head.eye(side)
    angles = np.repeat(EYE_ANGLES[:, None], EYE_AROUND, axis=1)
    ends = middle + size * np.stack([axes[0], -axes[0]])
    solid = outward(loft(middle + _ring_places(angles, size, axes), ends))
    ways = (solid.vertices - middle) @ axes.T / size
    off = np.degrees(np.arccos(np.clip(ways[:, 0], -1.0, 1.0)))
    turned = np.arctan2(ways[:, 2], ways[:, 1])
    tall, wide = PUPILS[head.skull.pupil]
    shape = np.hypot(np.cos(turned) / tall, np.sin(turned) / wide)
    paint = np.concatenate(
        [np.tile(linear_color(SCLERA), (len(off), 1)), np.ones((len(off), 1))], 1
    )
    lay(paint, "#0d0907", smoothstep((IRIS_DEG + 8.0 - off) / 8.0))
    lay(paint, iris, smoothstep((IRIS_DEG - off) / 6.0))
    lay(paint, "#050404", smoothstep((PUPIL_DEG - off * shape) / 5.0 + 0.5))
    bright = np.array([1.0, 0.8, 0.6]) * np.sin(np.radians(CATCHLIGHT_DEG))
    bright[0] = np.cos(np.radians(CATCHLIGHT_DEG))
    away = np.degrees(np.arccos(np.clip(ways @ bright, -1.0, 1.0)))
    lay(paint, "#f4f6fa", 0.9 * smoothstep((CATCHLIGHT_SIZE_DEG - away) / 6.0))
    return solid, paint


def eyelids(head: Head, side: float) -> tuple[Solid, Array]:
    """Return the almond-shaped lids around an eye, and the share of their dark rim."""
    axes, size, middle = _axes(head, side), head.eye_radius, head.eye(side)
    azimuth = np.arange(EYE_AROUND) * (2.0 * np.pi / EYE_AROUND)
    edge = LID_OPENING + LID_CORNERS * np.sin(azimuth) ** 2
    edge -= LID_DROOP * np.maximum(np.cos(azimuth), 0.0)
    beyond, radii = np.array(LID_RINGS).T
    angles = np.radians(edge + beyond[:, None])
    rings = middle + _ring_places(
        angles, np.broadcast_to(size * radii[:, None], angles.shape), axes
    )
    # Both ends are inside the ball.
    solid = outward(loft(rings, np.stack([middle, middle - 0.5 * size * axes[0]])))
    return solid, np.concatenate([np.repeat(LID_RIM, EYE_AROUND), [1.0, 0.0]])
