"""Limbs of arthropods: jointed legs, antennae of beads, and claws, as they stand."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pipeline.simulation.figures.hide.sheets import tube
from pipeline.simulation.figures.hide.stance import Chain
from pipeline.simulation.figures.solids import Solid
from pipeline.simulation.spatial import UP, Array, cross, normalized

AROUND = 8
"""Vertices around a link."""

FEET = 4
"""Segments of the last link of a leg, its tarsus."""


def leg_segment(chain: Chain, i: int, detail: float) -> Solid:
    """Return one link of a leg, slender at its joints; the last one has the segments of a foot.

    Args:
        chain: the leg as it stands.
        i: number of the link.
        detail: share of the usual vertices along and around it.
    """
    a, b = chain.points[i], chain.points[i + 1]
    r_a, r_b = float(chain.radii[i]), float(chain.radii[i + 1])
    if i == 0:
        # The base of a leg is no thicker than its knee, though its hip may be.
        r_a = min(r_a, 1.35 * r_b)
    is_foot = i == len(chain.ways) - 1 and i > 0
    t = np.linspace(0.0, 1.0, round(detail * (14 if is_foot else 9)))
    radii = r_a + (r_b - r_a) * t
    if is_foot:
        shape = 0.95 - 0.22 * np.cos(2.0 * np.pi * FEET * np.clip((t - 0.35) / 0.65, 0.0, 1.0))
        shape = np.where(t < 0.35, np.interp(t, [0.0, 0.12, 0.35], [0.55, 0.95, 0.74]), shape)
    else:
        # A thigh is thickest before its middle, a shin at its end.
        top = 0.42 if i == 0 else 0.66
        shape = np.interp(t, [0.0, 0.10, top, 0.92, 1.0], [0.60, 0.84, 1.28, 0.96, 0.70])
    middle = a + t[:, None] * (b - a)
    # Shells of legs are a little bowed.
    bow = 0.06 * float(chain.lengths[i]) * np.sin(np.pi * t) * (0.0 if is_foot else 1.0)
    middle = middle + bow[:, None] * UP * (1.0 - abs(chain.ways[i][1]))
    return tube(middle, radii * shape, max(round(detail * AROUND), 6))


def leg_spines(chain: Chain, i: int) -> Iterator[Solid]:
    """Yield spines along the lower side of a shin."""
    side = normalized(cross(chain.ways[i], UP))
    r = float(chain.radii[i + 1])
    for share in (0.45, 0.62, 0.79, 0.94):
        at = chain.points[i] + share * chain.spans[i]
        for sign in (-1.0, 1.0):
            out = normalized(0.8 * sign * side - 0.5 * UP + 0.8 * chain.ways[i])
            curve = np.array([at, at + 1.5 * r * out, at + 2.6 * r * out])
            yield tube(curve, r * np.array([0.26, 0.16, 0.02]), 5)


def antenna_segment(chain: Chain, i: int, club: bool = False) -> Solid:
    """Return one link of an antenna as a string of beads; a clubbed one ends thick."""
    a, b = chain.points[i], chain.points[i + 1]
    r_a, r_b = float(chain.radii[i]), float(chain.radii[i + 1])
    r_a = min(r_a, 1.4 * r_b) if i == 0 else r_a
    beads = (
        1
        if i == 0 and len(chain.ways) > 1
        else max(3, round(float(chain.lengths[i]) / (3.2 * max(r_a, r_b))))
    )
    beads = min(beads, 9)
    t = np.linspace(0.0, 1.0, 3 * beads + 1)
    shape = 0.92 - 0.26 * np.cos(2.0 * np.pi * beads * t)
    if club and i == len(chain.ways) - 1:
        shape = shape * (1.0 + 1.1 * t**2)
    return tube(a + t[:, None] * (b - a), (r_a + (r_b - r_a) * t) * shape, 6)


def is_claw(chain: Chain) -> bool:
    """Return whether a limb ends in a claw: drawn thick before a thin tip."""
    if len(chain.ways) < 2:
        return False
    palm, tip = float(chain.radii[-2]), float(chain.radii[-1])
    return palm > 2.0 * tip and palm > 1.3 * float(chain.radii[-3])


def claw_solids(chain: Chain, sign: float) -> list[Solid]:
    """Return the palm of a claw and its two fingers.

    Args:
        chain: a limb whose last two nodes are the palm and the tip.
        sign: 1 on the right side of the body, -1 on the left.
    """
    palm, tip = chain.points[-2], chain.points[-1]
    r, way = float(chain.radii[-2]), chain.ways[-1]
    side = normalized(cross(way, UP)) * sign
    length = float(chain.lengths[-1])
    t = np.linspace(0.0, 1.0, 12)
    back = palm - 1.25 * r * way
    line = back + t[:, None] * (0.95 * r + 0.45 * length) * way
    shape = np.interp(t, [0.0, 0.10, 0.45, 0.80, 1.0], [0.34, 0.66, 1.10, 0.92, 0.50])
    solids = [tube(line, r * shape, 14, 0.74, side)]
    for inner in (-1.0, 1.0):
        # The outer finger is the thicker one; both curve so that their tips meet.
        thick = 0.50 if inner > 0 else 0.40
        root = palm + 0.10 * length * way + 0.42 * r * inner * side
        bow = palm + 0.58 * length * way + 0.62 * r * inner * side
        end = tip + 0.06 * r * inner * side
        s = np.linspace(0.0, 1.0, 11)[:, None]
        curve = (1 - s) ** 2 * root + 2 * s * (1 - s) * bow + s**2 * end
        sizes = r * thick * np.interp(s[:, 0], [0.0, 0.25, 0.8, 1.0], [0.85, 1.0, 0.55, 0.10])
        teeth = 1.0 + 0.10 * np.sin(np.arange(11) * 2.6)
        solids.append(tube(curve, sizes * teeth, 9))
    return solids


def sting_solid(chain: Chain) -> Solid:
    """Return a bulb that ends in a curved sting, on the last link of a tail."""
    a, b = chain.points[-2], chain.points[-1]
    r, way = float(chain.radii[-2]), chain.ways[-1]
    bend = chain.ways[-1] - chain.ways[-2]
    down = normalized(bend - float((bend * way).sum()) * way) if np.abs(bend).max() > 1e-3 else -UP
    t = np.linspace(0.0, 1.0, 16)
    line = a - 0.7 * r * way + t[:, None] * (b - a + 0.7 * r * way)
    line = line + (0.55 * r * np.clip(t - 0.45, 0, 1) ** 2 * 4.0)[:, None] * down
    shape = np.interp(
        t, [0, 0.1, 0.32, 0.5, 0.62, 0.8, 1.0], [0.5, 0.85, 1.2, 0.95, 0.45, 0.22, 0.03]
    )
    return tube(line, r * shape, 12)


def mandibles(tip: Array, along: Array, radius: float, size: float) -> list[Solid]:
    """Return two toothed jaws that curve towards each other."""
    side = normalized(cross(along, UP))
    down = cross(along, side)
    solids = []
    for sign in (-1.0, 1.0):
        line = ((0.35, 0.48, 0.20), (1.05, 0.72, 0.26), (1.55, 0.52, 0.30), (1.80, 0.06, 0.32))
        points = np.array(
            [
                tip
                + radius
                * (1.0 + (size - 1.0) * (a > 0.5))
                * (a * along + sign * s * side + d * down)
                for a, s, d in line
            ]
        )
        s = np.linspace(0.0, 1.0, 10)
        curve = np.stack([np.interp(s, np.linspace(0, 1, 4), points[:, k]) for k in range(3)], -1)
        curve[1:-1] = 0.25 * curve[:-2] + 0.5 * curve[1:-1] + 0.25 * curve[2:]
        sizes = radius * size * np.interp(s, [0, 0.5, 1.0], [0.26, 0.20, 0.03])
        solids.append(tube(curve, sizes * (1.0 + 0.14 * np.sin(9.0 * s)), 8))
    return solids
