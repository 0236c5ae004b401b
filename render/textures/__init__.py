"""Procedural textures of ground and objects: seamless tiles of colour and relief.

The relief is in metres for a tile of its natural size, so that its slopes are those of real soil,
sand or rock. All patterns come from fixed seeds. Tiles have no low frequencies (see `noise`),
because a light or dark spot of the size of a tile reveals the repetition.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from render.textures import ground_patterns, object_patterns
from render.textures.noise import TILE, Plane, noise

__all__ = ["TILE", "Plane", "Tile", "creases", "lumps", "patches", "patterns", "tile"]


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


@lru_cache(maxsize=2)
def tile(pattern: str) -> Tile:
    """Return the tile of a pattern of `render.config.material.Texture`.

    Of its 12 MiB little is asked for again once a mipmap was made of it, so few are kept.
    """
    shade, warmth, relief, size = _PATTERNS[pattern](np.random.default_rng(_SEED))
    shade = shade / shade.mean()
    warmth = np.clip(warmth, -1, 1)
    planes = [np.asarray(plane, np.float32) for plane in (shade, warmth, _softened(relief))]
    return Tile(planes[0], planes[1], planes[2], size)


@lru_cache(maxsize=4)
def patches(size: int = 512) -> Plane:
    """Return a (size, size) map of soft patches, 0 to 1 with mean near 0.5."""
    rng = np.random.default_rng(_SEED + 1)
    field = noise(rng, 2.2, first=2, size=size) + 0.35 * noise(rng, 1.2, first=24, size=size)
    return (1 / (1 + np.exp(-2.2 * field))).astype(np.float32)


CREASE_BREADTH, UNDULATION = 0.48, 0.06
"""Breadth of creases of cloth, in the deviation of the noise that they follow, and how high cloth
swells between them, in the height of a crease."""


def creases(size: int = 1024) -> Plane:
    """Return a (size, size) relief of worn cloth; slopes along its rows have a deviation of 1."""
    rng = np.random.default_rng(_SEED + 3)
    relief = np.zeros((size, size), np.float32)
    # Unlike ones: two that cross evenly are a quilt.
    for turn_deg, weight in ((50.0, 1.0), (-64.0, 0.8), (8.0, 0.6)):
        bend = noise(rng, 2.2, first=3, last=24, size=size, stretch=3.2, turn_deg=turn_deg)
        # Narrow ridges that run out on cloth that is nearly smooth between them.
        where = 1.0 / (1.0 + np.exp(-4.0 * noise(rng, 2.0, first=2, last=6, size=size) + 0.8))
        relief += weight * where * np.exp(-((bend / CREASE_BREADTH) ** 2))
    relief += UNDULATION * noise(rng, 2.4, first=4, last=16, size=size)
    return _with_unit_slopes(relief)


@lru_cache(maxsize=4)
def lumps(size: int = 512) -> Plane:
    """Return a (size, size) relief of uneven ground whose slopes have a deviation of 1 per tile."""
    rng = np.random.default_rng(_SEED + 2)
    return _with_unit_slopes(
        noise(rng, 1.9, first=3, size=size) + 0.12 * noise(rng, 1.0, first=30, size=size)
    )


def _with_unit_slopes(relief: Plane) -> Plane:
    """Return a relief whose slopes along the rows have a deviation of 1 per tile."""
    slope = (np.roll(relief, -1, 1) - np.roll(relief, 1, 1)) * (0.5 * len(relief))
    return np.asarray(relief / slope.std(), np.float32)


def patterns() -> tuple[str, ...]:
    """Return the names of all patterns."""
    return tuple(_PATTERNS)


_SEED = 19870501


def _softened(relief: Plane) -> Plane:
    """Return the relief without its highest frequencies, which only sparkle."""
    for axis in (0, 1):
        relief = 0.5 * relief + 0.25 * (np.roll(relief, 1, axis) + np.roll(relief, -1, axis))
    return relief


_PATTERNS: dict[str, Callable[[np.random.Generator], ground_patterns.Drawn]] = {
    "soil": ground_patterns.soil,
    "sand": ground_patterns.sand,
    "grass": ground_patterns.grass,
    "moss": ground_patterns.moss,
    "snow": ground_patterns.snow,
    "rock": ground_patterns.rock,
    "gravel": ground_patterns.gravel,
    "mud": ground_patterns.mud,
    "asphalt": ground_patterns.asphalt,
    "ice": ground_patterns.ice,
    "waves": ground_patterns.waves,
    "tiles": ground_patterns.tiles,
    "checker": ground_patterns.checker,
    "slabs": ground_patterns.slabs,
    "wood": object_patterns.wood,
    "planks": object_patterns.planks,
    "mottle": object_patterns.mottle,
    "shell": object_patterns.shell,
    "carapace": object_patterns.carapace,
    "fur": object_patterns.fur,
    "plumage": object_patterns.plumage,
    "pores": object_patterns.pores,
    "wrinkles": object_patterns.wrinkles,
    "scales": object_patterns.scales,
    "weave": object_patterns.weave,
    "scratches": object_patterns.scratches,
    "brushed": object_patterns.brushed,
    "plaster": object_patterns.plaster,
    "clay": object_patterns.clay,
    "marble": object_patterns.marble,
}
