"""Land cover: what grows or lies where on the land, as colours of its vertices.

Near the terrain the land shows the material of the ground; farther out the cover takes over in
ragged patches, by height, slope and noise: woods, meadow, scree, rock, snow.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from pipeline.production.surroundings.lattice_noise import fractal, noise, resolved, smoothstep
from pipeline.simulation.spatial import Array

Color = tuple[float, float, float]

GRASS: Color = (0.088, 0.122, 0.034)
DRY_GRASS: Color = (0.245, 0.205, 0.105)
WOODS: Color = (0.028, 0.044, 0.016)
SCREE: Color = (0.185, 0.165, 0.135)
ROCK: Color = (0.150, 0.138, 0.122)
SNOW: Color = (0.82, 0.85, 0.90)
SAND: Color = (0.47, 0.365, 0.235)
RED_ROCK: Color = (0.27, 0.150, 0.095)
PALE_ROCK: Color = (0.42, 0.265, 0.16)
SCRUB: Color = (0.082, 0.088, 0.042)
BEACH: Color = (0.34, 0.275, 0.185)
WET: Color = (0.13, 0.105, 0.075)

WOODS_FROM = (170.0, 380.0)
"""Distances between which woods rise to the height of trees [m]; nearer ones are plants."""

NEAR, FAR = 14.0, 120.0
"""Distances between which the cover takes over from the material of the ground [m]."""


@dataclass(frozen=True, eq=False)
class Site:
    """N places on the land.

    Attributes:
        places: (N, 2) in the frame of the grid [m].
        out: (N,) distance beyond the terrain [m].
        spacing: (N, 2) between neighbours outward and around [m].
        height: (N,) over the level of the land [m].
        steepness: (N,) rise per metre.
        seed: of the noise.
        ground: linear mean colour of the ground near the terrain.
    """

    places: Array
    out: Array
    spacing: Array
    height: Array
    steepness: Array
    seed: int
    ground: Color

    def fractal(self, width: float, salt: int, octaves: int = 4) -> Array:
        """Return noise (N,), about -1 to 1, with features `width` metres wide."""
        widest = self.spacing.max(axis=-1) / width
        return fractal(self.places / width, self.seed + 200 + 10 * salt, octaves, spacing=widest)

    def noise(self, width: float, seed: int, spacing: Array) -> Array:
        """Return noise (N,) of one width [m], as far as places of a spacing (N,) [m] show it."""
        return resolved(width, spacing) * noise(self.places / width, seed)


def cover(site: Site, kind: str) -> Array:
    """Return the colours (N, 3), linear, of a kind of surroundings, and their shares (N, 1).

    Returns:
        (N, 4): the share of the colour, less the share of the ground's own material, is last.
    """
    color = COVERS[kind](site)
    # Broad light and dark, as of the shadows of clouds and of soils.
    stains = site.noise(21.0, 5, site.spacing.max(axis=-1))
    color = color * (1.0 + 0.16 * site.fractal(90.0, 7) + 0.10 * stains)[:, None]
    ragged = site.out * (1.0 + 0.7 * np.clip(site.fractal(23.0, 8), -1.0, 1.0))
    share = smoothstep(NEAR, FAR, ragged)
    if kind == "dunes":
        # Sand is of one colour: the tones of what covers land would be stains on it.
        share = share * (0.25 + 0.75 * smoothstep(0.45, 0.8, site.steepness))
    return np.concatenate([np.clip(color, 0.004, 0.9), share[:, None]], axis=1)


def woods(site: Site, kind: str) -> Array:
    """Return the share (N,) of the land that trees cover."""
    cover_at = {"hills": 0.10, "mountains": 0.12, "plain": 0.10, "forest": -0.45, "sea": 0.10}
    if kind not in cover_at:
        return np.zeros(len(site.out))
    # Mostly in patches some hundred metres wide, with frayed edges.
    patch = site.fractal(330.0, 1, 5) + 0.25 * site.fractal(60.0, 2)
    line = 210.0 if kind == "mountains" else 420.0
    share = smoothstep(cover_at[kind], cover_at[kind] + 0.16, patch)
    share = share * (1.0 - smoothstep(0.65, 1.0, site.steepness))
    ragged = site.height + 70.0 * site.fractal(200.0, 3)
    share = share * (1.0 - smoothstep(line, 1.5 * line, ragged))
    return np.asarray(share * smoothstep(0.3, 2.5, site.height + (3.0 if kind != "sea" else 0.0)))


def canopy(site: Site, kind: str) -> Array:
    """Return the height (N,) of far woods over the ground [m]: ragged lines of trees."""
    trees = woods(site, kind) * smoothstep(*WOODS_FROM, site.out)
    # A line of trees is seen from the side: only how close vertices are around counts.
    around = site.spacing[:, 1]
    crowns = 3.5 * site.noise(13.0, site.seed + 71, around)
    crowns += 2.5 * site.noise(5.0, site.seed + 72, around)
    return np.asarray(trees * (6.5 + crowns))


def _mixed(first: Array | Color, second: Color | Array, share: Array) -> Array:
    a, b = np.asarray(first, float), np.asarray(second, float)
    return np.asarray(a + (b - a) * share[:, None])


def _lush(site: Site) -> Array:
    """Return the ground's own colour going over to meadows, fresh and dry."""
    dry = smoothstep(-0.5, 0.6, site.fractal(170.0, 4))
    meadow = _mixed(GRASS, DRY_GRASS, 0.55 * dry)
    own = np.asarray(site.ground, float)
    # Land keeps something of its near colour, greener than bare soil, to the horizon.
    return 0.45 * own + 0.55 * meadow


def _green(site: Site, kind: str) -> Array:
    color = _mixed(_lush(site), SCREE, 0.7 * smoothstep(0.5, 0.85, site.steepness))
    ragged = site.steepness + 0.2 * site.fractal(40.0, 5)
    color = _mixed(color, ROCK, smoothstep(0.75, 1.15, ragged))
    return _mixed(color, WOODS, 0.92 * woods(site, kind))


def _alpine(site: Site) -> Array:
    color = _green(site, "mountains")
    ragged = site.height + 60.0 * site.fractal(260.0, 6, 5)
    bare = smoothstep(230.0, 420.0, ragged)
    rock = _mixed(ROCK, SCREE, smoothstep(-0.4, 0.6, site.fractal(120.0, 9)))
    color = _mixed(color, rock, np.maximum(bare, smoothstep(0.8, 1.2, site.steepness)))
    lying = 1.0 - smoothstep(0.85, 1.35, site.steepness - 0.0004 * site.height)
    own_snow = 1.0 if min(site.ground) > 0.5 else 0.0
    snow = smoothstep(400.0 - 460.0 * own_snow, 640.0 - 420.0 * own_snow, ragged) * lying
    return _mixed(color, SNOW, snow)


def _desert(site: Site) -> Array:
    own = 0.5 * np.asarray(site.ground, float) + 0.5 * np.asarray(SAND)
    sand = np.broadcast_to(own, (len(site.out), 3))
    band = noise(np.stack([site.height / 17.0, 0.02 * site.height], axis=-1), site.seed + 61)
    rock = _mixed(RED_ROCK, PALE_ROCK, smoothstep(-0.5, 0.5, band + 0.2 * site.fractal(30.0, 5)))
    return _mixed(sand, rock, smoothstep(0.55, 0.95, site.steepness))


def _banded(site: Site) -> Array:
    """Return the beds of table mountains over plains of their own soil, with dry scrub."""
    own = np.asarray(site.ground, float)
    plain = _mixed(own, DRY_GRASS, 0.55 * smoothstep(-0.3, 0.6, site.fractal(140.0, 4)))
    scrub = smoothstep(0.1, 0.7, site.fractal(48.0, 1, 5)) * (
        1.0 - smoothstep(0.3, 0.6, site.steepness)
    )
    plain = _mixed(plain, SCRUB, 0.45 * scrub)
    level = site.height + 6.0 * site.fractal(160.0, 6)
    band = noise(np.stack([level / 17.0, 0.01 * level], axis=-1), site.seed + 61)
    rock = _mixed(RED_ROCK, PALE_ROCK, smoothstep(-0.5, 0.5, band))
    rock = rock * (0.75 + 0.2 * site.fractal(90.0, 9, 3))[:, None]
    color = _mixed(
        plain, 0.5 * own + 0.5 * np.asarray(RED_ROCK), smoothstep(0.22, 0.5, site.steepness)
    )
    return _mixed(color, rock, smoothstep(0.5, 0.9, site.steepness))


def _coast(site: Site) -> Array:
    color = _green(site, "sea")
    sandy = 1.0 - smoothstep(0.5, 2.2, site.height + 0.5 * site.fractal(18.0, 5))
    color = _mixed(color, BEACH, sandy)
    return _mixed(color, WET, 1.0 - smoothstep(-0.6, -0.2, site.height))


COVERS: Mapping[str, Callable[[Site], Array]] = {
    "hills": lambda site: _green(site, "hills"),
    "mountains": _alpine,
    "plain": lambda site: _green(site, "plain"),
    "dunes": _desert,
    "mesas": _banded,
    "forest": lambda site: _green(site, "forest"),
    "sea": _coast,
}
