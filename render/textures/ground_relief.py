"""Ground relief: the heights of a ground's pattern, whose slopes bend the normals of its shader."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from render.config import Material
from render.image_resizing import half_size
from render.textures import Plane, patches, tile
from render.textures.layers import (
    CALM,
    FIRST_LAYER,
    LARGE_PATCHES,
    PATCH_CONTRAST,
    PATCHES,
    RIPPLED,
    RIPPLED_MOST,
    SECOND_LAYER,
    Layer,
)

RELIEFS = frozenset({"soil", "sand", "snow", "rock", "gravel", "mud", "grass", "moss"})
"""Patterns that are seen as uneven ground."""


def has_relief(material: Material) -> bool:
    """Return whether the ground of a material is uneven."""
    return material.texture in RELIEFS and material.bump > 0.0


def ground_relief(
    material: Material, places: NDArray[np.float64], spacing: float
) -> NDArray[np.float64]:
    """Return the heights (N,) of level ground, of zero mean [m].

    Both layers of the pattern are mixed as the shader mixes them.

    Args:
        material: of the ground.
        places: (N, 2) x and z [m].
        spacing: of the places, finer detail than which is left out [m].
    """
    drawn, size = tile(material.texture), material.texture_scale
    plane, count = drawn.relief, round(spacing / size * len(drawn.relief))
    while count > 1 and len(plane) > 8:
        plane, count = half_size(plane), count // 2
    plane = plane - plane.mean()
    heights = _sampled(plane, places / size, FIRST_LAYER)
    if material.color2 is not None:
        share = np.full(len(places), 0.5)
        for layer in (PATCHES, LARGE_PATCHES):
            share += PATCH_CONTRAST * (_sampled(patches(), places / size, layer) - 0.5)
        share = np.clip(share, 0.0, 1.0)
        second = _sampled(plane, places / size, SECOND_LAYER)
        # At constant variance, as slopes are mixed.
        heights = ((1.0 - share) * heights + share * second) / np.hypot(share, 1.0 - share)
        if material.texture in RIPPLED:
            heights *= CALM + (1.0 - CALM) * RIPPLED_MOST * share
    return np.asarray(material.bump * size / drawn.size * heights)


def _sampled(plane: Plane, places: NDArray[np.float64], layer: Layer) -> NDArray[np.float64]:
    """Return a repeating plane at places (N, 2) in tiles of the first layer, bilinear."""
    c, s = np.cos(np.radians(layer.turn_deg)), np.sin(np.radians(layer.turn_deg))
    u, v = places.T / layer.scale
    width = len(plane)
    x, y = (c * u - s * v) * width - 0.5, (s * u + c * v) * width - 0.5
    i, j = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    x, y = x - i, y - j
    i, j, right, down = i % width, j % width, (i + 1) % width, (j + 1) % width
    upper = plane[j, i] * (1 - x) + plane[j, right] * x
    lower = plane[down, i] * (1 - x) + plane[down, right] * x
    return np.asarray(upper * (1 - y) + lower * y)
