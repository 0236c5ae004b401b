"""Turned shapes: fountain, pot, vase and lamp as shapes of revolution."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from pipeline.production.scenery.prototype import Color, Prototype, Shape, mixed
from pipeline.production.scenery.stones import rough
from pipeline.production.surroundings.lattice_noise import smoothstep

SIDES = 28
"""Sides of a shape of revolution."""

FOUNTAIN = (
    *((1.55, 0.0), (1.55, 0.1), (1.42, 0.16), (1.40, 0.42), (1.50, 0.46), (1.50, 0.54)),
    *((1.22, 0.54), (1.20, 0.36), (0.34, 0.36), (0.30, 0.5), (0.17, 0.6), (0.15, 1.0)),
    *((0.24, 1.08), (0.62, 1.24), (0.68, 1.34), (0.60, 1.34), (0.5, 1.26), (0.12, 1.26)),
    *((0.10, 1.5), (0.2, 1.6), (0.22, 1.7), (0.14, 1.82), (0.0, 1.86)),
)
"""Radii and heights of a fountain [m]."""

POT = (
    *((0.0, 0.0), (0.15, 0.0), (0.22, 0.3), (0.26, 0.31), (0.26, 0.37), (0.22, 0.37)),
    *((0.2, 0.32), (0.0, 0.32)),
)
"""Of a pot with earth in it [m]."""

VASE = (
    *((0.0, 0.0), (0.06, 0.0), (0.105, 0.08), (0.1, 0.17), (0.05, 0.25), (0.045, 0.29)),
    *((0.07, 0.33), (0.06, 0.33), (0.035, 0.29)),
)
LAMP = (
    *((0.0, 0.0), (0.09, 0.0), (0.09, 0.02), (0.03, 0.04), (0.055, 0.14), (0.02, 0.26)),
    *((0.02, 0.33), (0.19, 0.33), (0.12, 0.56), (0.0, 0.56)),
)
"""Of a vase and of a table lamp with its shade [m]."""

STONE, DAMP = (0.33, 0.30, 0.25), (0.14, 0.145, 0.10)
CLAY = (0.36, 0.165, 0.09)


def _turned(profile: tuple[tuple[float, float], ...], tone: Color, *, damp: bool = False) -> Shape:
    """Return a shape of revolution.

    Args:
        profile: its radii and heights, from the foot up [m].
        tone: its linear colour.
        damp: whether it is stone that water has stained.
    """
    radius, up = np.array(profile).T
    angle = np.linspace(0.0, 2.0 * np.pi, SIDES + 1)
    shape = Shape()
    # Each ring has corners of its own, because its edges are sharp.
    for k in range(len(radius) - 1):
        r, y = radius[[k, k + 1]][:, None], up[[k, k + 1]][:, None]
        points = np.stack([r * np.cos(angle), y + 0.0 * angle, r * np.sin(angle)], axis=-1)
        slope = np.array([up[k + 1] - up[k], radius[k] - radius[k + 1]])
        normals = np.stack(
            [slope[0] * np.cos(angle), slope[1] + 0.0 * angle, slope[0] * np.sin(angle)], axis=-1
        )
        a = np.arange(SIDES)
        b = a + SIDES + 1
        faces = np.concatenate([np.stack([a, b, a + 1], -1), np.stack([a + 1, b, b + 1], -1)])
        tones = np.asarray(tone, float) * np.ones(points.shape)
        if damp:
            wet = smoothstep(-0.2, 0.5, rough(2.0 * points.reshape(-1, 3), 7, 3))
            wet = wet * (1.0 - smoothstep(0.0, 0.5, points[..., 1].ravel() % 1.2))
            tones = mixed(STONE, DAMP, 0.75 * wet).reshape(points.shape)
        shape.add(points, np.repeat(normals[None], 2, axis=0), tones, faces, thin=False)
    return shape


@lru_cache(maxsize=1)
def fountain() -> Prototype:
    """Return a basin with a column and a bowl on it."""
    return _turned(FOUNTAIN, STONE, damp=True).prototype()


@lru_cache(maxsize=1)
def pot() -> Prototype:
    """Return a pot of clay."""
    return _turned(POT, CLAY).prototype()


@lru_cache(maxsize=1)
def vase() -> Prototype:
    """Return a white vase."""
    return _turned(VASE, tone=(0.85, 0.85, 0.85)).prototype()


@lru_cache(maxsize=1)
def lamp() -> Prototype:
    """Return a lamp of pale wood with a shade of paper."""
    return _turned(LAMP, tone=(0.72, 0.62, 0.46)).prototype()
