"""Patterns of the ground and of things: tiles of colour and relief, made by numpy.

A tile is square and continues over its edges. Its relief is in metres for a tile
of its natural size, so that the slopes which the light sees are those of real
soil, sand or rock. All patterns come from fixed seeds.

Slow variation is kept out of the tiles on purpose (see `noise`): a light or dark
spot the size of the tile is what the eye finds when a tile is laid again and again.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from render.textures import grounds, things
from render.textures.noise import TILE, Plane, noise

__all__ = ["TILE", "Plane", "Tile", "patches", "patterns", "tile"]


@dataclass(frozen=True, eq=False)
class Tile:
    """One pattern.

    Attributes:
        shade: (TILE, TILE) factor on the linear base colour, about 1 on average.
        warmth: (TILE, TILE) -1 to 1, shifts the colour from blue to red.
        relief: (TILE, TILE) height [m] of a tile of natural size.
        size: natural size of the tile [m].
    """

    shade: Plane
    warmth: Plane
    relief: Plane
    size: float


@lru_cache(maxsize=16)
def tile(pattern: str) -> Tile:
    """Return the tile of a pattern of `render.words.material.Texture`."""
    shade, warmth, relief, size = _PATTERNS[pattern](np.random.default_rng(_SEED))
    shade = shade / shade.mean()
    warmth = np.clip(warmth, -1, 1)
    planes = [np.asarray(plane, np.float32) for plane in (shade, warmth, _softened(relief))]
    return Tile(planes[0], planes[1], planes[2], size)


@lru_cache(maxsize=4)
def patches(size: int = 512) -> Plane:
    """Return a (size, size) map of slow patches, 0 to 1 with soft borders, mean near 0.5."""
    rng = np.random.default_rng(_SEED + 1)
    field = noise(rng, 2.2, first=2, size=size) + 0.35 * noise(rng, 1.2, first=24, size=size)
    return (1 / (1 + np.exp(-2.2 * field))).astype(np.float32)


def patterns() -> tuple[str, ...]:
    """Return the names of all patterns."""
    return tuple(_PATTERNS)


_SEED = 19870501


def _softened(relief: Plane) -> Plane:
    """Return the relief without slopes from pixel to pixel, which only sparkle."""
    for axis in (0, 1):
        relief = 0.5 * relief + 0.25 * (np.roll(relief, 1, axis) + np.roll(relief, -1, axis))
    return relief


_PATTERNS: dict[str, Callable[[np.random.Generator], grounds.Drawn]] = {
    "soil": grounds.soil,
    "sand": grounds.sand,
    "grass": grounds.grass,
    "snow": grounds.snow,
    "rock": grounds.rock,
    "gravel": grounds.gravel,
    "mud": grounds.mud,
    "asphalt": grounds.asphalt,
    "ice": grounds.ice,
    "tiles": grounds.tiles,
    "checker": grounds.checker,
    "wood": things.wood,
    "planks": things.planks,
    "mottle": things.mottle,
    "shell": things.shell,
    "fur": things.fur,
    "plumage": things.plumage,
    "pores": things.pores,
    "weave": things.weave,
    "scratches": things.scratches,
    "brushed": things.brushed,
    "plaster": things.plaster,
    "clay": things.clay,
    "marble": things.marble,
}
