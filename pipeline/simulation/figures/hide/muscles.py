"""Muscles and bones that stand out on the trunk and the upper legs of a mammal on four legs.

They come from the drawn nodes alone: from shoulder, elbow, hip and stifle, and their radii. Unions
are narrow, so that a furrow stays between one muscle and the next.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from pipeline.simulation.figures.hide.lumps import Lump, ball, cone, union_distance
from pipeline.simulation.figures.hide.stance import Chain
from pipeline.simulation.spatial import Array

FORWARD = np.array([1.0, 0.0, 0.0])

Offset = tuple[float, float, float]
"""Ahead, up and outward, in the radius of the node."""

LOIN_PLACE, LOIN_RISE, LOIN_BITE = 0.34, 0.10, 0.10
"""Where the hollow of the loin is: ahead of the hip, in the way to the shoulder; above the middle
of the trunk, and how deep, in the radius of the hip."""

FURROW = 0.11
"""Width of the union of one muscle with the next, in the radius of the joint they move."""


def _at(node: Array, radius: float, outward: float, offset: Offset) -> Array:
    """Return a place (3,) beside a node [m]."""
    return np.asarray(node + radius * np.array([offset[0], offset[1], outward * offset[2]]))


def shoulder_muscles(leg: Chain) -> Iterator[Lump]:
    """Yield shoulder blade, upper arm, the muscle behind it, and the breast of a foreleg."""
    hip, elbow, r, r_e = leg.points[0], leg.points[1], float(leg.radii[0]), float(leg.radii[1])
    out = float(np.sign(hip[2]))
    point = _at(hip, r, out, (0.70, -0.62, 0.26))
    blend = FURROW * r
    yield ball(_at(hip, r, out, (0.62, -0.62, -0.52)), (0.72 * r, 0.86 * r, 0.56 * r), 0.40 * r)
    yield cone(
        _at(hip, r, out, (-0.55, 1.10, 0.02)),
        point,
        (0.46 * r, 0.34 * r),
        (0.48 * r, 0.52 * r),
        blend,
        FORWARD,
        0.10,
    )
    yield cone(
        _at(hip, r, out, (-0.66, 0.06, 0.40)),
        _at(elbow, r_e, out, (-0.50, 0.35, 0.12)),
        (0.60 * r, 0.54 * r),
        (0.86 * r_e, 0.72 * r_e),
        blend,
        FORWARD,
        0.12,
    )
    yield cone(
        point,
        _at(elbow, r_e, out, (0.18, 0.0, 0.0)),
        (0.52 * r, 0.46 * r),
        (1.05 * r_e, 0.92 * r_e),
        1.3 * blend,
        FORWARD,
    )


def haunch_muscles(leg: Chain, knee_girth: float, is_upright: bool = False) -> Iterator[Lump]:
    """Yield hip bone, croup, the muscles before and behind the thigh bone, and the calf.

    Args:
        leg: a hind leg of three links or more.
        knee_girth: mean of width and depth of its first joint, in the drawn radius.
        is_upright: whether the trunk is, whose hip bones the belly hides.
    """
    hip, knee, r = leg.points[0], leg.points[1], float(leg.radii[0])
    r_k, span = knee_girth * float(leg.radii[1]), leg.spans[1]
    out, blend = float(np.sign(hip[2])), FURROW * r
    yield cone(
        _at(hip, r, out, (0.55, 0.46, 0.02)),
        _at(hip, r, out, (-0.56, 0.20, 0.16)),
        (0.46 * r, 0.42 * r),
        (0.56 * r, 0.54 * r),
        1.4 * blend,
    )
    if not is_upright:
        bone = 0.24 * r, 0.20 * r, 0.24 * r
        yield ball(_at(hip, r, out, (0.86, 0.58, 0.34)), bone, 1.5 * blend)
    yield cone(
        _at(hip, r, out, (0.36, -0.10, 0.28)),
        _at(knee, r_k, out, (0.10, 0.10, 0.05)),
        (0.70 * r, 0.52 * r),
        (1.06 * r_k, 0.86 * r_k),
        1.0 * blend,
        FORWARD,
        0.10,
    )
    yield cone(
        _at(hip, r, out, (-0.60, -0.06, 0.26)),
        knee + 0.42 * span - 0.30 * r_k * FORWARD,
        (0.54 * r, 0.50 * r),
        (0.58 * r_k, 0.52 * r_k),
        blend,
        FORWARD,
        0.10,
    )
    yield cone(
        _at(knee, r_k, out, (-0.52, -0.30, 0.06)),
        knee + 0.62 * span - 0.25 * r_k * FORWARD,
        (0.62 * r_k, 0.56 * r_k),
        (0.36 * r_k, 0.30 * r_k),
        0.4 * r_k,
        FORWARD,
        0.15,
    )


def loin_hollows(
    trunk: Sequence[Lump], hind: Sequence[Chain], shoulder: float, height: float
) -> Iterator[Lump]:
    """Yield the hollows between the last rib and the hip bone, on both sides.

    Args:
        trunk: its lumps.
        hind: the hind legs.
        shoulder: how far ahead the shoulders are [m].
        height: of the middle of the trunk [m].
    """
    for leg in hind:
        hip, r = leg.points[0], float(leg.radii[0])
        out = float(np.sign(hip[2]))
        x = float(hip[0]) + LOIN_PLACE * (shoulder - float(hip[0]))
        y = height + LOIN_RISE * r
        # The trunk's surface there, by bisection from its middle.
        inner, outer = 0.0, 4.0 * r
        for _ in range(24):
            z = 0.5 * (inner + outer)
            inside = float(union_distance(trunk, np.array([[x, y, out * z]]))[0]) < 0.0
            inner, outer = (z, outer) if inside else (inner, z)
        size = (0.62 * r, 0.95 * r, 0.40 * r)
        middle = np.array([x, y, out * (inner + size[2] - LOIN_BITE * r)])
        yield ball(middle, size, 0.35 * r, carved=True)
