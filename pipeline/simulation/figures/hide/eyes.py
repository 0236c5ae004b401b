"""Eyes of animals: balls with iris, pupil and a catchlight, between dark lids."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pipeline.simulation.figures.hide.head import Head
from pipeline.simulation.figures.hide.sheets import (
    Paint,
    lay,
    linear_color,
    outward,
    painted,
    small_ball,
)
from pipeline.simulation.figures.hide.stance import smoothstep
from pipeline.simulation.figures.solids import Solid, loft
from pipeline.simulation.spatial import Array, cross, normalized

EYE_AROUND = 16

EYE_ANGLES = np.array([10.0, 19.5, 22.0, 24.5, 34.0, 41.0, 48.0, 55.0, 61.0, 68.0, 100.0])
"""Rings of an eyeball from where it looks [degrees]: fine where pupil and iris end. Those
up to the iris are shaped as the pupil, whose edge would be ragged across them."""

PUPIL_DEG, IRIS_DEG = 22.0, 55.0

PUPILS: Mapping[str, tuple[float, float]] = {
    "round": (1.0, 1.0),
    "slit": (1.9, 0.42),
    "bar": (0.62, 1.6),
}
"""Height and width of a pupil by its shape, in those of a round one."""

SCLERA = "#1e1611"
"""Colour of the visible part of an eye around its iris: animals show no white."""

GLOW_SHARE, GLOW_SIZE = 0.55, 1.6
"""Share at the lower edge of the iris of the light that its cornea gathers there, and how bright it
is, in the iris: an eye without it looks like a button."""

CATCHLIGHT_DEG, CATCHLIGHT_SIZE = 27.0, 0.15
"""Angle of the reflection of the sky [degrees], and its radius in the eye's.

That of the sun alone is less than a pixel.
"""

CATCHLIGHT_DEPTH = 0.07
"""Depth of the middle of its ball in the eye, in the eye's radius."""

LID_CORNERS = 16.0
"""What the opening of lids is more at the corners [degrees]."""

TEAR_DUCT = 9.0
"""What the opening is more at the inner corner than at the outer one [degrees]."""

LID_RINGS = ((0.0, 1.015), (2.5, 1.07), (9.0, 1.105), (24.0, 1.11), (58.0, 0.98))
"""Rings of lids: angle beyond their edge [degrees], and radius in that of the eye."""

UPPER_LID = 0.05
"""How much thicker the upper lid is than the lower one, in the radius of the eye."""

LID_RIM = (1.0, 1.0, 0.55, 0.0, 0.0)
"""Share of the dark rim at these rings: beyond it a lid has the coat of the face."""


def _axes(head: Head, side: float) -> Array:
    """Return rows (3, 3): where an eye looks, up, and ahead."""
    look = head.way(head.skull.look, side)
    up = normalized(cross(look, head.axes[0]))
    up = up if up[1] > 0 else -up
    ahead = cross(look, up)
    ahead = ahead if float((ahead * head.axes[0]).sum()) > 0 else -ahead
    # The outer corner is higher than the inner one.
    slant = np.radians(head.skull.slant)
    return np.stack(
        [
            look,
            np.cos(slant) * up + np.sin(slant) * ahead,
            np.cos(slant) * ahead - np.sin(slant) * up,
        ]
    )


def _ring_places(angles: Array, sizes: Array | float, axes: Array) -> Array:
    """Return places (..., 3) at angles (..., EYE_AROUND) from where an eye looks [rad]."""
    azimuth = np.arange(EYE_AROUND) * (2.0 * np.pi / EYE_AROUND)
    flat = np.cos(azimuth)[:, None] * axes[1] + np.sin(azimuth)[:, None] * axes[2]
    unit = np.cos(angles)[..., None] * axes[0] + np.sin(angles)[..., None] * flat
    return np.asarray(sizes)[..., None] * unit


def eyeball(head: Head, side: float, iris: str) -> tuple[Solid, Paint]:
    """Return an eye, and its paint."""
    axes, size, middle = _axes(head, side), head.eye_radius, head.eye(side)
    azimuth = np.arange(EYE_AROUND) * (2.0 * np.pi / EYE_AROUND)
    tall, wide = PUPILS[head.skull.pupil]
    reach = PUPIL_DEG / np.hypot(np.cos(azimuth) / tall, np.sin(azimuth) / wide)
    angles = np.stack(
        [
            np.interp(EYE_ANGLES, [0.0, PUPIL_DEG, IRIS_DEG, 180.0], [0.0, r, IRIS_DEG, 180.0])
            for r in reach
        ],
        axis=1,
    )
    angles = np.radians(angles)
    ends = middle + size * np.stack([axes[0], -axes[0]])
    solid = outward(loft(middle + _ring_places(angles, size, axes), ends))
    ways = (solid.vertices - middle) @ axes.T / size
    off = np.degrees(np.arccos(np.clip(ways[:, 0], -1.0, 1.0)))
    paint = np.concatenate(
        [np.tile(linear_color(SCLERA), (len(off), 1)), np.ones((len(off), 1))], 1
    )
    lay(paint, "#0d0907", smoothstep((IRIS_DEG + 8.0 - off) / 8.0))
    lay(paint, iris, smoothstep((IRIS_DEG - off) / 6.0))
    low = smoothstep(0.5 - 0.9 * ways[:, 1] / np.sin(np.radians(IRIS_DEG)))
    low *= smoothstep((IRIS_DEG - 3.0 - off) / 6.0) * GLOW_SHARE
    paint[:, :3] *= 1.0 + (GLOW_SIZE - 1.0) * low[:, None]
    paint[:, :3] = np.minimum(paint[:, :3], 1.0)
    inside = np.append(np.repeat(EYE_ANGLES < PUPIL_DEG + 1.0, EYE_AROUND), [True, False])
    lay(paint, "#050404", inside.astype(float))
    bright = np.array([1.0, 0.8, 0.6]) * np.sin(np.radians(CATCHLIGHT_DEG))
    bright[0] = np.cos(np.radians(CATCHLIGHT_DEG))
    bright = normalized(bright) @ axes
    light = small_ball(
        middle + (1.0 - CATCHLIGHT_DEPTH) * size * bright, CATCHLIGHT_SIZE * size, 8, 3
    )
    faces = light.faces + np.uint32(len(solid.vertices))
    whole = Solid(
        np.concatenate([solid.vertices, light.vertices]), np.concatenate([solid.faces, faces])
    )
    return whole, np.concatenate([paint, painted(len(light.vertices), "#f4f6fa")])


def eyelids(head: Head, side: float) -> tuple[Solid, Array]:
    """Return the almond-shaped lids around an eye, and the share of their dark rim."""
    axes, size, middle = _axes(head, side), head.eye_radius, head.eye(side)
    azimuth = np.arange(EYE_AROUND) * (2.0 * np.pi / EYE_AROUND)
    edge = head.skull.lid_opening + LID_CORNERS * np.sin(azimuth) ** 2
    edge -= head.skull.droop * np.maximum(np.cos(azimuth), 0.0)
    edge += TEAR_DUCT * np.maximum(np.sin(azimuth), 0.0) ** 4
    beyond, radii = np.array(LID_RINGS).T
    angles = np.radians(edge + beyond[:, None])
    thick = radii[:, None] + UPPER_LID * (radii > 1.05)[:, None] * np.maximum(np.cos(azimuth), 0.0)
    rings = middle + _ring_places(angles, size * thick, axes)
    # Both ends are inside the ball.
    solid = outward(loft(rings, np.stack([middle, middle - 0.5 * size * axes[0]])))
    return solid, np.concatenate([np.repeat(LID_RIM, EYE_AROUND), [1.0, 0.0]])
