"""Cloth folds: where sleeves, shirts and trousers gather, and how dark they are there.

Lengths are in girths (`BodyMeasures.girth`). Folds run around a limb, slanted, and are deepest
where a joint gathers the cloth.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.people.proportions import BodyMeasures
from pipeline.simulation.people.signed_distance import Field
from pipeline.simulation.people.skinned_surface import angle_around, ramp
from pipeline.simulation.spatial import Array

FOLD_DARKNESS = 0.52
"""How dark the bottom of a fold is at most: soft light is traced too coarsely for it."""

MIDDLE = 0.018
"""Half the breadth of the middle of a trunk, where folds of both sides meet."""


@dataclass(frozen=True)
class Gather:
    """Folds that a joint or an edge gathers.

    Attributes:
        level: height of the deepest one, as a fraction of an adult's height.
        reach: distance from it at which folds run out.
        spacing: distance between two folds.
        depth: of a fold.
        slant: rise of a fold from back to front, per distance.
        run: rise outward, per distance.
        front: share of their depth that is left ahead, and behind: 1 all around on both.
    """

    level: float
    reach: float
    spacing: float
    depth: float
    slant: float = 0.0
    run: float = 0.0
    front: tuple[float, float] = (1.0, 1.0)


SLEEVE = (
    Gather(0.634, 0.044, 0.029, 0.0046, slant=0.55, run=0.3, front=(1.0, 0.45)),
    Gather(0.524, 0.030, 0.026, 0.0048, slant=0.25, run=-0.3),
    Gather(0.740, 0.036, 0.034, 0.0030, slant=-0.35, run=1.0, front=(1.0, 0.7)),
)
"""Of a long sleeve: at the elbow, above the cuff, and below the shoulder."""

SHORT_SLEEVE = (Gather(0.748, 0.032, 0.034, 0.0036, slant=-0.3, run=1.2, front=(1.0, 0.7)),)

SHIRT = (
    Gather(0.610, 0.048, 0.038, 0.0062, slant=0.45, run=0.75),
    Gather(0.735, 0.044, 0.042, 0.0036, slant=0.2, run=-1.0, front=(1.0, 0.8)),
)
"""Of a shirt: at the waist and towards the armpits; free hems have `HangingFolds` as well."""

LEG = (
    Gather(0.076, 0.028, 0.032, 0.0088, slant=-0.60, run=0.5, front=(1.0, 0.6)),
    Gather(0.268, 0.046, 0.036, 0.0068, slant=-0.70, run=0.6, front=(0.35, 0.9)),
    Gather(0.455, 0.042, 0.034, 0.0066, slant=0.25, run=0.95, front=(1.0, 0.7)),
)
"""Of trousers: over the shoe, at the knee, and from the crotch outward."""

SHORTS = (Gather(0.440, 0.048, 0.036, 0.0056, slant=0.25, run=0.95, front=(1.0, 0.6)),)


def fold_depth(build: BodyMeasures, gathers: Sequence[Gather], z: float) -> Field:
    """Return how deep folds press places (n, 3) inward, as a field [m].

    Args:
        build: measures of the person.
        gathers: of the garment.
        z: of the middle of the limb [m].
    """
    g = build.girth

    def depth(places: Array) -> Array:
        x, y, aside = places[:, 0] / g, places[:, 1], (places[:, 2] - z) / g
        if z == 0.0:
            # Alike on both sides of a trunk, without a kink between them.
            aside = np.sqrt(aside * aside + MIDDLE * MIDDLE)
        found = np.zeros(len(places))
        for one in gathers:
            up = (y - build.level(one.level)) / g
            ahead = ramp(x, -0.02, 0.02)
            share = one.front[1] + (one.front[0] - one.front[1]) * ahead
            # Neighbours differ: even ones would look turned on a lathe.
            phase = (up + one.slant * x + one.run * aside) / one.spacing
            phase = phase + 0.20 * np.sin(40.0 * aside) + 0.16 * np.sin(34.0 * x + 2.0)
            # Narrow lines between broad ridges: even waves would look like rings of a hose.
            line = (0.5 + 0.5 * np.cos(2.0 * np.pi * phase)) ** 2
            found = found + one.depth * share * line * np.exp(-((up / one.reach) ** 2))
        return np.asarray(g * found)

    return depth


def folded(cloth: Field, depth: Field) -> Field:
    """Return a solid of cloth with folds pressed into it."""

    def distance(places: Array) -> Array:
        return np.asarray(cloth(places) + depth(places))

    return distance


@dataclass(frozen=True)
class HangingFolds:
    """Folds that run down cloth that hangs free, alike on both sides of a body.

    Attributes:
        top: height at which they begin [m].
        hem: height of the hem [m].
        count: of the folds.
        most: their depth at the hem [m].
        uneven: how unlike their breadths are [rad].
    """

    top: float
    hem: float
    count: int
    most: float
    uneven: float

    def depth(self, places: Array) -> Array:
        """Return how deep they press places (n, 3) inward, negative on their ridges [m]."""
        down = self._down(places)
        return np.asarray(self.most * down * down * np.cos(self._phase(places)))

    def valley(self, places: Array) -> Array:
        """Return how deep places (n, 3) lie in them, from 0 to 1 at the hem."""
        deep = 0.5 + 0.5 * np.cos(self._phase(places))
        return np.asarray(self._down(places) * deep * deep)

    def _down(self, places: Array) -> Array:
        return np.asarray(np.clip((self.top - places[:, 1]) / (self.top - self.hem), 0.0, 1.0))

    def _phase(self, places: Array) -> Array:
        around = angle_around(places)
        return np.asarray(self.count * around + self.uneven * np.sin(3.0 * around))


SEAM, SEAM_DEPTH, SEAM_REACH, SEAM_DARKNESS = 0.0115, 0.0012, 0.0016, 0.5
"""Height of the seam of a hem above its edge, its depth, and the distance in which cloth rounds
into it, in girths; and how dark it is."""


def seam_depth(build: BodyMeasures, hem: float) -> Field:
    """Return how deep the seam above a hem at a height presses places inward, as a field [m]."""
    g = build.girth

    def depth(places: Array) -> Array:
        return np.asarray(SEAM_DEPTH * g * _near_seam(build, hem, places[:, 1]))

    return depth


def seam_shade(build: BodyMeasures, hem: float, heights: Array) -> Array:
    """Return the shade (n,) of cloth at some heights about the seam above a hem [m]."""
    return 1.0 - SEAM_DARKNESS * _near_seam(build, hem, heights)


def _near_seam(build: BodyMeasures, hem: float, heights: Array) -> Array:
    away = (heights - hem - SEAM * build.girth) / (SEAM_REACH * build.girth)
    return np.asarray(np.exp(-(away**2)))


def fold_shade(build: BodyMeasures, depth: Field, places: Array) -> Array:
    """Return the shade (n,) of places in folds."""
    return 1.0 - FOLD_DARKNESS * ramp(depth(places) / build.girth, 0.0, 0.0058)
