"""Body skin: a body from which thick limbs grow without a seam.

The stumps of necks, tails and thighs join the body's smooth union. Its skin follows the body,
and over a stump more and more the limb, inside whose own skin it ends.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.figures.network import HEAD, LEG, TAIL
from pipeline.simulation.figures.skeleton import Limb, Link
from pipeline.simulation.figures.skins import Skin
from pipeline.simulation.figures.solids import body_solid
from pipeline.simulation.spatial import Array

GROWING = (LEG, HEAD, TAIL)
"""Kinds of limbs that a body may grow into. Arms turn too far."""

STOUT = 0.30
"""Radius of a limb's root, as a part of the body's, from which on it has a stump."""

REACH, LONGEST = 1.7, 0.55
"""Length of a stump in radii of its root, and at most in lengths of its link."""

EVEN = 0.8
"""How much nearer to one stump than to another what follows it alone is, in radii."""

SLIM = 0.90
"""Radius of a stump's end as a part of the link's there: it ends inside the limb's skin."""


@dataclass(frozen=True, eq=False)
class Stump:
    """The begin of a limb.

    Attributes:
        link: number of its first link.
        ends: (2, 3) in the creation frame [m].
        radii: there [m].
    """

    link: int
    ends: Array
    radii: tuple[float, float]


def stumps_of(
    limbs: Sequence[Limb], links: Sequence[Link], girth: float, material: str, own: str
) -> list[Stump]:
    """Return the stumps that grow from a body.

    Args:
        limbs: of the figure.
        links: of the figure.
        girth: radius of the body [m].
        material: of the body's solid.
        own: what links are made of that name no material.
    """
    found = []
    for limb in limbs:
        number = limb.links[0]
        link = links[number]
        alike = (link.material or own) == (material or own)
        stout = link.radii[0] >= STOUT * girth
        if limb.kind not in GROWING or not alike or not stout or link.shape != "round":
            continue
        span = link.ends[1] - link.ends[0]
        length = float(np.sqrt((span * span).sum()))
        part = min(REACH * link.radii[0] / length, LONGEST)
        end = link.radii[0] + (link.radii[1] - link.radii[0]) * part
        ends = np.stack([link.ends[0], link.ends[0] + part * span])
        found.append(Stump(number, ends, (link.radii[0], SLIM * end)))
    return found


def body_skin(
    points: Array,
    radii: Array,
    bones: Sequence[tuple[int, int]],
    flatness: float,
    stumps: Sequence[Stump],
) -> Skin:
    """Return the skin of a body and its stumps.

    Args:
        points: (n, 3) nodes in the creation frame [m].
        radii: (n,) of the solid at the nodes [m].
        bones: pairs of nodes.
        flatness: height as a part of the width.
        stumps: that grow from it.
    """
    n = len(points)
    everywhere = np.concatenate([points, *(stump.ends for stump in stumps)])
    thick = np.concatenate([radii, *(np.array(stump.radii) for stump in stumps)])
    more = [(n + 2 * k, n + 2 * k + 1) for k in range(len(stumps))]
    solid = body_solid(everywhere, thick, [*bones, *more], flatness)
    count = len(solid.vertices)
    links, share = np.zeros((count, 2), dtype=np.int64), np.zeros(count)
    if stumps:
        near = [_near(solid.vertices, stump) for stump in stumps]
        follows, distances = (np.array(values) for values in zip(*near, strict=True))
        nearest = distances.argmin(axis=0)
        rows = np.arange(count)
        links[:, 1] = np.array([stump.link for stump in stumps])[nearest]
        share = follows[nearest, rows] * _apart(distances)
    return Skin(solid.vertices, solid.faces, links, share)


def _apart(distances: Array) -> Array:
    """Return 0 halfway between two stumps (S, n), which follows neither, and 1 away from there.

    Args:
        distances: (S, n) of places from the stumps' lines, in radii.
    """
    if len(distances) == 1:
        return np.ones(distances.shape[1])
    first, second = np.sort(distances, axis=0)[:2]
    return _smooth((second - first) / EVEN)


def _near(places: Array, stump: Stump) -> tuple[Array, Array]:
    """Return how much places (n, 3) follow a limb, and how far they are from it in radii.

    They do more along its stump, and less away from it.
    """
    span = stump.ends[1] - stump.ends[0]
    square = float((span * span).sum())
    away = places - stump.ends[0]
    along = (away * span).sum(axis=-1) / square
    off = away - np.clip(along, 0.0, 1.0)[:, None] * span
    distance: Array = np.sqrt((off * off).sum(axis=-1)) / stump.radii[0]
    near = _smooth((2.5 - distance) / 1.6)
    return near * _smooth((along + 0.6) / 1.5), distance


def _smooth(s: Array) -> Array:
    s = np.clip(s, 0.0, 1.0)
    result: Array = s * s * (3.0 - 2.0 * s)
    return result
