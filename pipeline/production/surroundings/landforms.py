"""Landforms: how high the land is, far from the terrain, for each kind of surroundings.

Every landform is a function of the place and of the distance beyond the edge of the terrain. Near
the edge it is 0, where the roughness of the terrain goes on; then come swells, hills, and ridges
one behind the other, each higher than the last, so that from a man's height several are seen.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from pipeline.production.surroundings.lattice_noise import eroded, fractal, ridged, smoothstep
from pipeline.simulation.spatial import Array

Landform = Callable[[Array, Array, int], Array]
"""From places (N, 2) [m], distances beyond the edge (N,) [m] and a seed to heights (N,) [m]."""

REACH = 7000.0
"""Distance at which the land ends, behind its last ridge [m]."""

KNOLLS = 0.2
"""Height of knolls relative to that of swells."""

DUNE_SPACING, DUNE_HEIGHT = 140.0, 21.0
"""Distance of the crests of dunes, and their height [m]: slip faces are no steeper than sand is."""

WINDWARD = 0.68
"""Share of a dune's length on the side that the wind blows up."""

SEA_DEPTH = 4.0
"""Depth of the bottom of the sea [m]."""

BEACH_SLOPE, BEACH_WANDER = 0.042, 4.0
"""Fall of a beach for each metre, and how far its lines wander [m]."""


Shape = Callable[[Array], Array]
"""From places (M, 2) [m] to heights (M,) [m]."""


def _rising(places: Array, out: Array, span: tuple[float, float], shape: Shape) -> Array:
    """Return heights (N,) of a shape that rises over a span of distances [m] from nothing."""
    result = np.zeros(len(out))
    there = out > span[0]
    result[there] = smoothstep(*span, out[there]) * shape(places[there])
    return result


def _swells(places: Array, out: Array, seed: int, height: float) -> Array:
    """Return gentle swells that set in some tens of metres away, and knolls nearer by.

    Knolls keep the ground beyond the terrain from ending in a level line before what lies lower.
    """

    def swells(p: Array) -> Array:
        return height * fractal(p / 150.0, seed, 3) + 0.35 * height * fractal(p / 62.0, seed + 5, 2)

    def knolls(p: Array) -> Array:
        return KNOLLS * height * fractal(p / 27.0, seed + 7, 3)

    return _rising(places, out, (4.0, 130.0), swells) + _rising(places, out, (2.5, 45.0), knolls)


def _uneven(places: Array, seed: int) -> Array:
    """Return a factor, 0.35 to 1.35, that makes a chain of hills higher here than there."""
    return 0.85 + 0.5 * np.clip(fractal(places / 2600.0, seed, 2), -1.0, 1.0)


def _bent(places: Array, seed: int, width: float, by: float) -> Array:
    """Return places moved by up to about `by` metres, in swirls `width` metres wide."""
    return places + by * np.stack(
        [fractal(places / width, seed + 50 + k, 2) for k in range(2)], axis=-1
    )


def _hills(places: Array, out: Array, seed: int) -> Array:
    def near(p: Array) -> Array:
        return 8.0 + 52.0 * eroded(p / 520.0, seed + 10)

    def middle(p: Array) -> Array:
        return 170.0 * eroded(p / 1300.0, seed + 20, 5)

    def far(p: Array) -> Array:
        return 420.0 * ridged(p / 2300.0, seed + 30, 6) * _uneven(p, seed + 40)

    return (
        _swells(places, out, seed, 9.0)
        + _rising(places, out, (120.0, 800.0), near)
        + _rising(places, out, (800.0, 2400.0), middle)
        + _rising(places, out, (2600.0, 4800.0), far)
    )


def _mountains(places: Array, out: Array, seed: int) -> Array:
    def foot(p: Array) -> Array:
        return 10.0 + 90.0 * eroded(p / 700.0, seed + 10, 5)

    def chain(p: Array) -> Array:
        ridge = ridged(_bent(p, seed, 1500.0, 320.0) / 2100.0, seed + 20)
        out = np.hypot(*p.T)
        high = 330.0 + 560.0 * smoothstep(2400.0, 4600.0, out) * ridge**0.2
        return high * ridge * _uneven(p, seed + 40)

    return (
        _swells(places, out, seed, 6.0)
        + _rising(places, out, (160.0, 1100.0), foot)
        + _rising(places, out, (1100.0, 2600.0), chain)
    )


def _plain(places: Array, out: Array, seed: int) -> Array:
    def middle(p: Array) -> Array:
        # Low rises here and there, so that no line of the horizon is straight.
        here = smoothstep(-0.25, 0.55, fractal(p / 1500.0, seed + 60, 2))
        return here * (6.0 + 62.0 * eroded(p / 760.0, seed + 50, 5))

    def far(p: Array) -> Array:
        return 300.0 * eroded(p / 1900.0, seed + 20) * _uneven(p, seed + 40)

    return (
        _swells(places, out, seed, 8.0)
        + _rising(places, out, (260.0, 1300.0), middle)
        + _rising(places, out, (2200.0, 4600.0), far)
    )


def _dunes(places: Array, out: Array, seed: int) -> Array:
    def dunes(p: Array) -> Array:
        # Crests lie across the wind, which blows along the second axis: a long slope up to a
        # sharp crest, and a steep one down from it where sand slides.
        bent = _bent(p, seed, 190.0, 46.0)
        wander = 0.9 * fractal(bent / np.array([330.0, 420.0]), seed + 10, 2)
        phase = bent[:, 1] / DUNE_SPACING + wander
        along = phase - np.floor(phase)
        up, down = along / WINDWARD, (1.0 - along) / (1.0 - WINDWARD)
        # Crests end, and others begin beside them.
        share = smoothstep(-0.75, 0.65, fractal(bent / np.array([210.0, 150.0]), seed + 11, 2))
        return DUNE_HEIGHT * share * np.where(up < 1.0, up * up * (1.6 - 0.6 * up), down)

    def great(p: Array) -> Array:
        # Sand seas: long rounded crests across the wind, each row higher than the last.
        bent = _bent(p, seed + 3, 520.0, 150.0) / np.array([1150.0, 430.0])
        crest = 1.0 - np.abs(fractal(bent, seed + 20, 2))
        return (34.0 + 76.0 * smoothstep(500.0, 1900.0, np.hypot(*p.T))) * _rounded(crest)

    def ranges(p: Array) -> Array:
        # Worn hills half sunk in sand, blue with distance: no edge of them is level or sheer.
        worn = eroded(_bent(p, seed, 900.0, 180.0) / 1700.0, seed + 30, 6)
        return 250.0 * worn**1.5 * _uneven(p, seed + 40)

    return (
        _rising(places, out, (20.0, 300.0), dunes)
        + _rising(places, out, (260.0, 1200.0), great)
        + _rising(places, out, (1500.0, 4400.0), ranges)
    )


def _rounded(crest: Array) -> Array:
    """Return the profile of dunes, 0 to 1, from crests of 1 that are as sharp as roofs."""
    return np.asarray(smoothstep(0.25, 1.06, crest))


def _forest(places: Array, out: Array, seed: int) -> Array:
    def near(p: Array) -> Array:
        return 4.0 + 38.0 * eroded(p / 380.0, seed + 10)

    def far(p: Array) -> Array:
        return 210.0 * eroded(p / 1200.0, seed + 20) * _uneven(p, seed + 40)

    return (
        _swells(places, out, seed, 7.0)
        + _rising(places, out, (60.0, 420.0), near)
        + _rising(places, out, (600.0, 2600.0), far)
    )


def _sea(places: Array, out: Array, seed: int) -> Array:
    """Return the land at a bay: a coast with headlands and a far shore; the sea is near 0."""
    sunk = smoothstep(0.55, 1.5, out / 75.0 + 0.9 * fractal(places / 240.0, seed + 10, 4))
    swells = _swells(places, out, seed, 2.0)
    return swells * (1.0 - sunk) - SEA_DEPTH * sunk + _far_coast(places, out, seed)


def beach(places: Array, out: Array, seed: int) -> Array:
    """Return the land of a bay before a terrace: a beach that falls evenly, far out under water."""
    wander = BEACH_WANDER * fractal(places / 34.0, seed + 10, 3) * smoothstep(2.0, 14.0, out)
    fall = BEACH_SLOPE * np.maximum(out + wander, 0.0)
    deep = smoothstep(30.0, 90.0, out)
    return -(fall + (SEA_DEPTH - fall) * deep) + _far_coast(places, out, seed)


def _far_coast(places: Array, out: Array, seed: int) -> Array:
    """Return headlands and the far shore of a bay, over the bottom of the sea."""

    def headlands(p: Array) -> Array:
        return (SEA_DEPTH + 46.0) * smoothstep(0.15, 0.5, fractal(p / 900.0, seed + 20, 4))

    def shore(p: Array) -> Array:
        return 330.0 * eroded(p / 1700.0, seed + 30) * _uneven(p, seed + 40)

    return np.maximum(
        _rising(places, out, (260.0, 900.0), headlands),
        _rising(places, out, (3000.0, 4700.0), shore),
    )


def _mesas(places: Array, out: Array, seed: int) -> Array:
    """Return table mountains: walls over slopes of scree, with level tops, before a far range."""

    def tables(p: Array, width: float, salt: int) -> Array:
        value = fractal(_bent(p, seed + salt, 0.3 * width, 0.05 * width) / width, seed + salt, 4)
        gully = 0.05 * np.abs(fractal(p / (0.07 * width), seed + salt + 7, 3))
        scree = smoothstep(-0.02, 0.34, value - gully)
        wall = smoothstep(0.27, 0.33, value - gully)
        upper = smoothstep(0.42, 0.46, value - gully)
        return np.asarray(0.36 * scree + 0.46 * wall + 0.18 * upper)

    def near(p: Array) -> Array:
        return 95.0 * tables(p, 620.0, 10)

    def middle(p: Array) -> Array:
        return 210.0 * tables(p, 1500.0, 20)

    def far(p: Array) -> Array:
        return 330.0 * eroded(p / 2100.0, seed + 30, 5) * _uneven(p, seed + 40)

    return (
        _swells(places, out, seed, 6.0)
        + _rising(places, out, (480.0, 800.0), near)
        + _rising(places, out, (1200.0, 1900.0), middle)
        + _rising(places, out, (2800.0, 4800.0), far)
    )


def _flat(places: Array, out: Array, seed: int) -> Array:
    del places, seed
    return np.zeros_like(out)


LANDFORMS: Mapping[str, Landform] = {
    "hills": _hills,
    "mountains": _mountains,
    "plain": _plain,
    "dunes": _dunes,
    "mesas": _mesas,
    "forest": _forest,
    "sea": _sea,
    "none": _flat,
}
