"""Shares of ground: how much of each of its colours a vertex shows, for the scalar variant."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from render.config import Material
from render.surfaces.patterns import SOFT, SOFT_DEG

STEEP, CREST, HOLLOW = "vertex_steep", "vertex_crest", "vertex_hollow"
"""Mesh attributes: shares of bare rock, of crests and of hollows, 0 to 1."""

Shares = dict[str, NDArray[np.float32]]


def share_names(words: Material | None) -> list[str]:
    """Return the attributes that a material needs."""
    if words is None:
        return []
    colors = {
        CREST: words.crest_color,
        HOLLOW: words.hollow_color,
        STEEP: words.steep_color,
    }
    return [name for name, color in colors.items() if color is not None]


def shares(words: Material, vertices: NDArray[np.float32], normals: NDArray[np.float32]) -> Shares:
    """Return the attributes of vertices, by slope and height, with ragged borders.

    Args:
        words: the material.
        vertices: (V, 3) [m].
        normals: (V, 3).
    """
    x, y, z = vertices.T
    # Waves whose lengths have no common measure: never seen to repeat, and equal anywhere.
    ragged = np.sin(5.1 * x + 1.7 * z + 2.3 * y) + np.sin(3.3 * z - 4.4 * x + 1.1)
    ragged += np.sin(9.7 * x + 8.3 * z) * np.sin(7.9 * z - 6.1 * y)
    slope = np.degrees(np.arccos(np.clip(np.abs(normals[:, 1]), 0, 1))) + 2.5 * ragged
    height = y + 0.1 * SOFT * ragged
    places = {
        STEEP: (slope - words.steep_deg) / SOFT_DEG,
        CREST: (height - words.crest_height) / SOFT,
        HOLLOW: (words.hollow_height - height) / SOFT,
    }
    return {name: _step(places[name]) for name in share_names(words)}


def _step(place: NDArray[np.floating]) -> NDArray[np.float32]:
    t = (0.5 + 0.5 * place).clip(0, 1)
    return np.asarray(t * t * (3 - 2 * t), np.float32)
