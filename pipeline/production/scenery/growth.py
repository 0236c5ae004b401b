"""Growth: where on the land plants thrive, trees stand together and the ground is trodden bare.

All fields depend on the place in the world and a seed alone. Trails follow the level lines of
noise, which wind, part and never repeat; they and bare spots are drawn on the ground, too.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from pipeline.production.scenery.clearings import Clearings
from pipeline.production.scenery.hearths import Hearths
from pipeline.production.scenery.puddles import Puddles
from pipeline.production.scenery.track import Track
from pipeline.production.surroundings.lattice_noise import fractal, smoothstep
from pipeline.simulation.spatial import Array
from render.color import linear
from render.config import Material, Weather
from render.ground_wear import TEXELS, GroundWear

Habitat = Literal[
    "open", "turf", "tufts", "untrodden", "clumps", "grove", "hedge", "shade", "rubble"
]
"""Where a species grows: in the open, there as turf, in tufts, in tufts where nobody walks, or in
loose clumps, in groves, along hedges and the edges of groves, below trees, or on bare ground, too.
"""

RASTER = 128.0
"""Side of the square on which bare ground is drawn [m]."""

TRAIL_BEND = 38.0
"""Size of the bends of trails [m]."""
TRAIL_HALF = (0.16, 0.62)
"""Distances from the middle of a trail up to which it is bare, and from which nothing is [m]."""

WASH_BEND, WASH_HALF = 27.0, (0.5, 1.7)
"""Size of the bends of dry beds of streams [m]; distances from the middle of one up to which it is
bare, and from which nothing of it is left [m]."""
RUBBLE, RUBBLE_EDGE, RUBBLE_LEAST = 6.5, (0.15, 0.55), 0.22
"""Width of stony patches of dry land [m], values of their noise between which they begin, and share
of the stones that lie between them."""
PALER = 0.16
"""How much nearer to white the silt of a dry bed is than the paler colour of its soil, in sRGB."""

TUFT, TUFT_LEAST, TUFT_EDGE = 0.85, 0.22, (-0.4, 0.4)
"""Width of tufts [m], the share of their density between them, and values of their noise between
which they begin."""
TURF_LEAST = 0.6
"""Share of the density of turf between tufts."""
CLUMP, CLUMP_LEAST, CLUMP_EDGE = 1.9, 0.05, (-0.05, 0.4)
"""The same of clumps."""

GATHERED: Mapping[Habitat, float] = {"turf": 0.80, "tufts": 0.60, "untrodden": 0.60, "clumps": 0.39}
"""Share of their full density that species have on average where they stand in tufts or clumps."""

GROVE, GROVE_EDGE = 58.0, (0.05, 0.4)
"""Width of groves [m], and values of their noise between which they begin."""
HEDGE_BEND, HEDGE_HALF = 150.0, (1.2, 3.2)
"""Size of the fields between hedges, and half the width of a hedge with its fringe [m]."""
THICKET = 13.0
"""Width of thickets of bushes in the open [m]."""

WORN_BY = 0.35, 1.1
"""Distances from the ways of performers between which they wear the ground down [m]."""
WORN_SHARE = 0.5

WALKED = 0.3, 1.7
"""Distances from the ways of performers between which tall grass begins [m]."""

THIN_SHARE = 0.14
"""Share of soil that shows between the tufts of grass."""

SOILS = {
    "grass": "#786a52",
    "moss": "#5f4e3a",
    "soil": "#a89679",
    "rock": "#7f766a",
    "gravel": "#8b7658",
}
"""Colour of worn ground by the texture of the ground."""

LIGHTLY = {"moss": 0.45, "rock": 0.7}
"""Share of the soil that shows where ground is worn, by its texture; all of it on others."""

WET = 0.55
"""Brightness of soaked soil, as a share of dry soil, in sRGB values."""


@dataclass(frozen=True, eq=False)
class Growth:
    """Fields of one scene.

    Attributes:
        seed: of the scene.
        clearings: of the performers, None without any.
        puddles: that rain has left, None without any.
        track: over the meadow, None without one.
        dry: whether it is dry land: beds of streams that are dry cross it, and stones lie along
            them and in patches.
        hearths: of fires, which are bare, None without any.
    """

    seed: int
    clearings: Clearings | None = None
    puddles: Puddles | None = None
    track: Track | None = None
    dry: bool = False
    hearths: Hearths | None = None

    def worn(self, x: Array, z: Array) -> Array:
        """Return the share (N,) of bare soil at places of the world, performers apart [m]."""
        places = np.stack([x, z], axis=-1)
        uneven = self._uneven(places)
        if self.track is not None:
            trail = self.track.bare(places, uneven)
        else:
            line = self._line(places, TRAIL_BEND, 4100)
            trail = 1.0 - smoothstep(*TRAIL_HALF, line - 0.16 * uneven)
        broad = fractal(places / 5.5, self.seed + 4120, 2)
        spots = 0.5 * smoothstep(0.75, 1.25, broad + 0.45 * uneven)
        result = np.maximum(trail * (0.86 + 0.14 * uneven), spots)
        if self.dry:
            result = np.maximum(result, self.wash(places))
        if self.hearths is not None:
            result = np.maximum(result, self.hearths.bare(places, uneven))
        return np.asarray(np.clip(result, 0.0, 1.0))

    def drawn(self, x: Array, z: Array) -> Array:
        """Return the share (N,) of soil that shows, between tufts and on performers' ways too."""
        places = np.stack([x, z], axis=-1)
        thin = 1.0 - (self.gathered("tufts", places) - TUFT_LEAST) / (1.0 - TUFT_LEAST)
        covered = 1.0 - THIN_SHARE * thin
        if self.clearings is not None:
            near = 1.0 - smoothstep(*WORN_BY, self.clearings.distance(x, z))
            uneven = self._uneven(places)
            covered = covered * (1.0 - WORN_SHARE * near * smoothstep(-0.5, 0.5, uneven))
        result = np.maximum(self.worn(x, z), 1.0 - covered)
        if self.puddles is not None:
            result = np.maximum(result, self.puddles.mud(x, z))
        return result

    def wash(self, places: Array) -> Array:
        """Return how far inside the dry bed of a stream places (N, 2) are, 0 to 1."""
        away = self._line(places, WASH_BEND, 4180) - 0.35 * self._uneven(places)
        return 1.0 - smoothstep(*WASH_HALF, away)

    def _rubble(self, places: Array) -> Array:
        """Return the share (N,) of stones that lie at places (N, 2) of dry land."""
        inside = self.wash(places)
        patch = smoothstep(*RUBBLE_EDGE, fractal(places / RUBBLE, self.seed + 4190, 2))
        share = np.maximum(patch, 4.0 * inside * (1.0 - inside))
        return np.asarray(RUBBLE_LEAST + (1.0 - RUBBLE_LEAST) * share)

    def _uneven(self, places: Array) -> Array:
        return fractal(places / 1.7, self.seed + 4110, 2)

    def grove(self, places: Array) -> Array:
        """Return how far inside a grove places (N, 2) are, 0 to 1."""
        value = fractal(places / GROVE, self.seed + 4130, 3)
        return smoothstep(*GROVE_EDGE, value)

    def hedge(self, places: Array) -> Array:
        """Return how near to the middle of a hedge places (N, 2) are, 0 to 1."""
        line = 1.0 - smoothstep(*HEDGE_HALF, self._line(places, HEDGE_BEND, 4140))
        gaps = smoothstep(-0.45, -0.15, fractal(places / 31.0, self.seed + 4150, 2))
        return np.asarray(line * gaps)

    def share(self, habitat: Habitat, x: Array, z: Array) -> Array:
        """Return the share (N,) of its full density that a habitat leaves a species."""
        places = np.stack([x, z], axis=-1)
        if habitat == "rubble":
            return self._rubble(places) if self.dry else np.ones(len(x))
        if habitat == "grove":
            return np.maximum(0.04 + 0.96 * self.grove(places), 0.55 * self.hedge(places))
        if habitat == "hedge":
            inside = self.grove(places)
            edge = 4.0 * inside * (1.0 - inside)
            # In the open, a few thickets.
            few = 0.3 * smoothstep(0.35, 0.7, fractal(places / THICKET, self.seed + 4180, 2))
            return np.clip(few + 0.5 * edge + 0.25 * inside + self.hedge(places), 0.0, 1.0)
        free = 1.0 - self.worn(x, z)
        if self.puddles is not None:
            free = free * self.puddles.dry(x, z)
        if habitat == "shade":
            return np.asarray(free * (0.12 + 0.88 * self.grove(places)))
        if habitat == "untrodden" and self.clearings is not None:
            free = free * smoothstep(*WALKED, self.clearings.distance(x, z))
        return np.asarray(free * self.gathered(habitat, places))

    def gathered(self, habitat: Habitat, places: Array) -> Array:
        """Return the share (N,) of its full density that a species has in and between its tufts.

        Between them a few stand alone.
        """
        if habitat in ("turf", "tufts", "untrodden"):
            value = fractal(places / TUFT, self.seed + 4160, 2)
            least = TURF_LEAST if habitat == "turf" else TUFT_LEAST
            return np.asarray(least + (1.0 - least) * smoothstep(*TUFT_EDGE, value))
        if habitat == "clumps":
            value = fractal(places / CLUMP, self.seed + 4170, 3)
            return np.asarray(CLUMP_LEAST + (1.0 - CLUMP_LEAST) * smoothstep(*CLUMP_EDGE, value))
        return np.ones(len(places))

    def wear(self, material: Material, weather: Weather, middle: Array) -> GroundWear | None:
        """Return the bare ground around a place (2,) [m], None on ground that wears not."""
        if material.texture not in SOILS:
            return None
        soil = SOILS[material.texture]
        step = RASTER / TEXELS
        corner = np.round(middle / step) * step - 0.5 * RASTER
        at = (np.arange(TEXELS) + 0.5) * step
        x, z = np.meshgrid(corner[0] + at, corner[1] + at)
        share = self.drawn(x.ravel(), z.ravel()).reshape(x.shape)
        from_edge = np.minimum(at, RASTER - at)
        fade = smoothstep(0.5, 14.0, from_edge)
        share = share * fade * fade[:, None]
        rgb = np.array([int(soil[k : k + 2], 16) for k in (1, 3, 5)]) / 255.0
        share = share * LIGHTLY.get(material.texture, 1.0)
        if self.dry:
            pale = np.asarray(material.color if material.color2 is None else material.color2)
            rgb = pale + PALER * (1.0 - pale)
        wet = min(weather.wetness / 0.5, 1.0)
        r, g, b = linear(rgb * (1.0 + wet * (WET - 1.0))).tolist()
        texels = np.rint(255.0 * share).astype(np.uint8)
        return GroundWear((float(corner[0]), float(corner[1])), RASTER, texels, (r, g, b))

    def _line(self, places: Array, bend: float, salt: int) -> Array:
        """Return about the distances (N,) from winding lines with bends of a size [m]."""
        seed, step = self.seed + salt, 0.02 * bend

        def value(at: Array) -> Array:
            return fractal(at / bend, seed, 2)

        here = value(places)
        slopes = [(value(places + step * np.eye(2)[k]) - here) / step for k in (0, 1)]
        return np.asarray(np.abs(here) / np.maximum(np.hypot(*slopes), 0.3 / bend))
