"""Feet of animals as they stand: hooves, paws with toes and claws, toes of birds and reptiles."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pipeline.simulation.figures.hide.lumps import SIDE, Lump, ball, cone
from pipeline.simulation.figures.hide.sheets import tube
from pipeline.simulation.figures.hide.stance import Chain
from pipeline.simulation.figures.solids import Solid
from pipeline.simulation.spatial import UP, Array, cross, normalized

CLAW_SIZE = 0.6
"""Size of the claws of a paw, whose coat hides their roots."""

TWO_TOES = 5.0
"""Length of two toes with claws, as of a kangaroo, in those of a paw with more."""

FINGER, FINGER_HANGS = 2.6, 0.55
"""Length of the fingers of an arm, in the radius of its end, and how much they hang down."""

HIND_TOES = 1.7
"""Length of the toes of a hind leg with a heel, in those of a leg without."""

LEVEL_LINK = 0.55
"""Sine of the slope up to which a foot points along its last link."""


def foot_way(chain: Chain) -> Array:
    """Return the level direction (3,) in which a foot points."""
    way = chain.ways[-1]
    if abs(float(way[1])) > LEVEL_LINK:
        out = chain.points[-1] - chain.points[0]
        level = np.array([out[0], 0.0, out[2]])
        # Legs that hang point their feet ahead, legs that spread point them outward.
        spread = float(np.linalg.norm(level)) > 0.7 * abs(float(out[1])) and abs(out[2]) > abs(
            out[0]
        )
        way = (
            level + np.array([0.6 * abs(out[2]), 0.0, 0.0]) if spread else np.array([1.0, 0.0, 0.0])
        )
    return normalized(np.array([way[0], 0.0, way[2]]))


def paw_lumps(chain: Chain, toes: int, girth: Array, claws: bool) -> Iterator[Lump]:
    """Yield a pad, and toes side by side; `girth` is width and height in the drawn radius."""
    r, tip, way = float(chain.radii[-1]), chain.points[-1], foot_way(chain)
    side = cross(way, UP)
    axes = np.stack([way, UP, side])
    wide = _paw_width(toes, claws) * float(girth[0])
    if toes == 2 and not claws:
        yield from _pad_lumps(tip, r, axes, wide)
        return
    yield ball(tip + r * (0.10 * way - 0.25 * UP), (1.15 * r, 0.72 * r, wide * r), 0.5 * r, axes)
    if toes == 2:
        # The sole of a hopper goes on below its long toes.
        ends = (0.66 * r, 0.85 * wide * r), (0.50 * r, 0.72 * wide * r)
        yield cone(
            tip - 0.30 * r * UP, tip + r * (0.95 * TWO_TOES * way - 0.45 * UP), *ends, 0.5 * r
        )
    for k in range(toes):
        place = (k - 0.5 * (toes - 1)) / max(0.5 * (toes - 1), 0.5)
        thick = 0.80 / max(toes, 2) ** 0.55
        off = place * (wide - 0.55 * thick)
        root = tip + r * (0.45 * way - 0.35 * UP + off * side)
        end = tip + r * (_toe_reach(toes, place) * way - (0.98 - thick) * UP + 1.12 * off * side)
        yield cone(root, end, (0.62 * r, thick * r), (0.95 * thick * r, 0.92 * thick * r), 0.12 * r)


def _pad_lumps(tip: Array, r: float, axes: Array, wide: float) -> Iterator[Lump]:
    """Yield the broad, flat pad of a camel, parted in front into two toes.

    Args:
        tip: (3,) end of the leg [m].
        r: its drawn radius [m].
        axes: (3, 3) directions ahead, up and to the side, as rows.
        wide: half the width of the pad, in the radius.
    """
    way, _, side = axes
    yield ball(tip + r * (0.05 * way - 0.15 * UP), (0.78 * r, 0.62 * r, 0.66 * r), 0.4 * r, axes)
    yield ball(tip + r * (0.25 * way - 0.44 * UP), (1.25 * r, 0.40 * r, wide * r), 0.35 * r, axes)
    for sign in (-1.0, 1.0):
        at = tip + r * (1.05 * way - 0.48 * UP + 0.50 * sign * wide * side)
        yield ball(at, (0.82 * r, 0.34 * r, 0.44 * wide * r), 0.10 * r, axes)


def hand_lumps(chain: Chain, fingers: int, girth: Array) -> Iterator[Lump]:
    """Yield a palm and hanging fingers; `girth` is width and height in the drawn radius."""
    r, tip = float(chain.radii[-1]), chain.points[-1]
    way = normalized(chain.ways[-1] - FINGER_HANGS * UP)
    side = normalized(cross(chain.ways[-1], UP) + 1e-6 * SIDE)
    axes = np.stack([way, cross(side, way), side])
    wide = 1.2 * float(girth[0])
    yield ball(tip + 0.5 * r * way, (1.3 * r, 0.75 * r, wide * r), 0.6 * r, axes)
    thick = 0.95 / max(fingers, 2) ** 0.6
    for k in range(fingers):
        place = (k - 0.5 * (fingers - 1)) / max(0.5 * (fingers - 1), 0.5)
        off = place * (wide - 0.4 * thick) * side
        length = FINGER * (1.0 - 0.18 * place**2)
        root = tip + r * (0.8 * way + off)
        end = tip + r * (length * way + 1.25 * off - 0.35 * UP)
        ends = (thick * r, thick * r), (0.62 * thick * r, 0.62 * thick * r)
        yield cone(root, end, *ends, 0.2 * r)


def sole_lump(chain: Chain) -> Lump:
    """Return the round foot of a leg like a column, which widens to a flat sole."""
    r, tip = float(chain.radii[-1]), chain.points[-1]
    top, low = tip + 0.30 * r * UP, tip - 0.62 * r * UP
    sizes = np.array([0.45, 1.02, 0.98]), np.array([0.38, 1.22, 1.14])
    axes = np.stack([-UP, np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])])
    return Lump(top, low, r * sizes[0], r * sizes[1], axes, 0.3 * r)


def _paw_width(toes: int, claws: bool) -> float:
    """Return half the width of a paw, in the drawn radius."""
    return 1.15 if toes > 2 or not claws else 0.95


def _toe_reach(toes: int, place: float) -> float:
    """Return how far ahead a toe ends, in the radius of its foot, by its place from -1 to 1."""
    size = TWO_TOES if toes == 2 else 1.0
    return size * (1.05 + 0.45 * (1.0 - 0.30 * place**2))


def paw_claws(chain: Chain, toes: int, girth: Array, size: float = CLAW_SIZE) -> Iterator[Solid]:
    """Yield the claws of a paw; `girth` is width and height in the drawn radius."""
    r, tip, way = float(chain.radii[-1]), chain.points[-1], foot_way(chain)
    side = cross(way, UP)
    for k in range(toes):
        place = (k - 0.5 * (toes - 1)) / max(0.5 * (toes - 1), 0.5)
        thick = 0.80 / max(toes, 2) ** 0.55
        wide = _paw_width(toes, True) * float(girth[0])
        off = place * (wide - 0.55 * thick) * 1.12
        ahead = _toe_reach(toes, place) + 0.7 * thick
        root = tip + r * (ahead * way - (0.90 - thick) * UP + off * side)
        curve = np.array(
            [
                root,
                root + size * r * (0.32 * way - 0.05 * UP),
                root + size * r * (0.50 * way - 0.34 * UP),
            ]
        )
        yield tube(curve, r * np.array([0.20, 0.15, 0.03]) * min(size, 1.6), 6)


def toe_nails(chain: Chain, toes: int) -> Iterator[Solid]:
    """Yield the nails around a round foot."""
    r, tip = float(chain.radii[-1]), chain.points[-1]
    for k in range(toes):
        angle = np.radians(-54.0 + 108.0 * (k + 0.5) / toes) * 1.1
        way = np.array([np.cos(angle), 0.0, np.sin(angle)])
        at = tip + r * (0.96 * way - 0.72 * UP)
        curve = np.array(
            [at - 0.02 * r * UP, at + 0.14 * r * UP, at + 0.32 * r * UP - 0.08 * r * way]
        )
        yield tube(curve, r * np.array([0.24, 0.22, 0.08]), 6, 0.8)


def spread_toes(chain: Chain, toes: int, claws: bool) -> Iterator[tuple[Solid, Solid | None]]:
    """Yield the toes of a bird, a frog or a lizard, and their claws where they have any."""
    r, tip, way = float(chain.radii[-1]), chain.points[-1], foot_way(chain)
    side = cross(way, UP)
    if toes == 2:
        turns = [(0.0, 4.4, 1.15), (34.0 * np.sign(tip[2] or 1.0), 2.9, 0.8)]
    elif toes == 3:
        turns = [(0.0, 4.2, 1.0), (36.0, 3.4, 0.9), (-36.0, 3.4, 0.9)]
    else:
        fan = np.linspace(-62.0, 62.0, toes if toes > 4 else 3)
        turns = [(float(a), 4.0 - abs(float(a)) / 60.0, 0.85) for a in fan]
        if toes == 4:
            turns.append((180.0, 2.0, 0.75))
    if len(chain.ways) == 3 and toes > 4:
        # The long foot of a hind leg with a heel, as a frog's.
        turns = [(0.8 * a, HIND_TOES * length, 0.9 * thick) for a, length, thick in turns]
    for degrees, length, thick in turns:
        a = np.radians(degrees)
        ahead = np.cos(a) * way + np.sin(a) * side
        low = tip - 0.30 * r * UP
        curve = np.array(
            [
                low,
                low + 0.35 * length * r * ahead + 0.10 * r * UP,
                low + 0.75 * length * r * ahead - 0.28 * r * UP,
                low + length * r * ahead - 0.34 * r * UP,
            ]
        )
        toe = tube(curve, r * thick * np.array([0.75, 0.60, 0.52, 0.40]), 8)
        if not claws:
            yield toe, None
            continue
        tipped = curve[-1] + 0.15 * r * ahead
        claw = np.array(
            [
                tipped,
                tipped + 0.5 * r * ahead + 0.1 * r * UP,
                tipped + 0.95 * r * ahead - 0.22 * r * UP,
            ]
        )
        yield toe, tube(claw, r * thick * np.array([0.36, 0.25, 0.04]), 6)
