"""Manes and tails of hair, as closed surfaces."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pipeline.simulation.figures.hide.head import Head
from pipeline.simulation.figures.hide.lumps import Lump, cone
from pipeline.simulation.figures.hide.sheets import hair_tail, outward
from pipeline.simulation.figures.hide.stance import Chain
from pipeline.simulation.figures.hide.trunk import spline
from pipeline.simulation.figures.solids import Solid, loft
from pipeline.simulation.spatial import Array, cross, normalized

MANE_ROWS, MANE_POINTS = 30, 9

CLEARANCE = 0.24
"""Height above the ground at which a tail of hair ends, in that of its root."""


def mane_solid(chain: Chain, kind: str, head: Head, heights: Array) -> Solid:
    """Return the mane on the crest of a neck.

    Args:
        chain: of the head.
        kind: "hanging" to the right side of the neck, or "upright".
        head: at its end.
        heights: (n,) of the neck at its nodes, in the drawn radii.
    """
    points = np.concatenate([chain.points[:-1], [head.place((0.16, 0.5, 0.0))]])
    radii = np.concatenate([chain.radii[:-1] * heights, [0.55 * chain.radii[-2]]])
    curve, sizes = spline(points, radii, 12)
    t = np.linspace(0.24, 1.0, MANE_ROWS)
    s = np.linspace(0.0, 1.0, len(curve))
    middle = np.stack([np.interp(t, s, curve[:, k]) for k in range(3)], axis=-1)
    r = np.interp(t, s, sizes)
    ways = normalized(np.gradient(middle, axis=0))
    side = np.array([0.0, 0.0, 1.0])
    up = normalized(cross(np.broadcast_to(side, ways.shape), ways))
    number = np.arange(MANE_ROWS)
    ragged = 0.82 + 0.18 * np.sin(2.3 * number) * np.cos(1.1 * number + 0.5)
    ends_in = np.clip(np.minimum(number + 1, MANE_ROWS - number) / 4.0, 0.25, 1.0)
    if kind == "upright":
        return _upright(middle, up, r, ragged * ends_in)
    reach = np.radians(16.0 + 88.0 * ragged * ends_in)
    u = np.linspace(0.0, 1.0, MANE_POINTS)
    rings = []
    for k in range(MANE_ROWS):
        angle = np.radians(-22.0) + u * (reach[k] + np.radians(22.0))
        deep, wide = 1.05 * r[k], 0.76 * r[k]
        lift = (0.15 + 0.09 * np.sin(2.9 * k)) * np.sin(np.pi * np.clip(u * 1.05, 0, 1)) ** 0.5
        flat = np.cos(angle)[:, None] * up[k] * deep + np.sin(angle)[:, None] * side * wide
        outer = middle[k] + flat * (1.0 + lift[:, None] + 0.03)
        inner = middle[k] + flat * 0.90
        # Locks lean back towards the withers as they hang.
        lean = -0.25 * r[k] * (u**1.5)[:, None] * ways[k]
        rings.append(np.concatenate([outer + lean, (inner + lean)[::-1]]))
    ends = np.stack([rings[0].mean(axis=0), rings[-1].mean(axis=0)])
    return outward(loft(np.array(rings), ends))


def _upright(middle: Array, up: Array, r: Array, tall: Array) -> Solid:
    angle = np.arange(10) * (2.0 * np.pi / 10)
    rings = []
    for k in range(len(middle)):
        high = 0.30 * r[k] * tall[k]
        ring = np.cos(angle)[:, None] * up[k] * high + np.sin(angle)[:, None] * np.array(
            [0.0, 0.0, 0.14 * r[k]]
        )
        rings.append(middle[k] + up[k] * (r[k] * 1.0 + 0.3 * high) + ring)
    ends = np.stack([rings[0].mean(axis=0), rings[-1].mean(axis=0)])
    return outward(loft(np.array(rings), ends))


def hair_solid(chain: Chain, kind: str, ground: float) -> Solid:
    """Return a tail of long hair, or a fan of plumes.

    Args:
        chain: of the tail.
        kind: "hair" or "fan".
        ground: height of the soles [m].
    """
    curve, _ = spline(chain.points, chain.radii, 6)
    t = np.linspace(0.0, 1.0, len(curve))
    widest = float(chain.radii[1:].max())
    if kind == "fan":
        return hair_tail(curve, widest * np.interp(t, [0, 0.5, 0.85, 1], [1.3, 1.5, 1.15, 0.5]))
    # Hair hangs: beyond the dock the tail turns down and ends far below it.
    length = float(np.linalg.norm(np.diff(curve, axis=0), axis=-1).sum())
    fall = np.clip(t - 0.35, 0.0, 1.0) ** 1.5
    curve = curve + np.stack([0.10 * length * fall, -0.30 * length * fall, 0 * fall], axis=-1)
    root, low = curve[0, 1], float(curve[:, 1].min())
    lowest = ground + CLEARANCE * (root - ground)
    if low < lowest < root:
        curve[:, 1] = root + (curve[:, 1] - root) * (root - lowest) / (root - low)
    sizes = widest * np.interp(
        t, [0.0, 0.12, 0.3, 0.55, 0.8, 0.94, 1.0], [0.55, 0.72, 0.95, 1.20, 1.15, 0.75, 0.30]
    )
    return hair_tail(curve, sizes)


def tassel_lumps(chain: Chain, kind: str) -> Iterator[Lump]:
    """Yield the tuft at the end of a tail, or the bush along all of it."""
    curve, _ = spline(chain.points, chain.radii, 6)
    widest = float(chain.radii[1:].max())
    if kind == "tassel":
        a, b = curve[-3], curve[-1]
        low = b + 1.1 * (b - a)
        yield cone(a, b, (0.8 * widest,) * 2, (1.45 * widest,) * 2, 0.5 * widest)
        yield cone(b, low, (1.45 * widest,) * 2, (0.25 * widest,) * 2, 0.5 * widest)
        return
    sizes = np.interp(
        np.linspace(0, 1, len(curve)), [0, 0.3, 0.65, 0.9, 1], [0.9, 1.7, 2.1, 1.4, 0.4]
    )
    for k in range(len(curve) - 1):
        ends = [(widest * float(sizes[j]),) * 2 for j in (k, k + 1)]
        yield cone(curve[k], curve[k + 1], ends[0], ends[1], 0.3 * widest)
