"""Things: balls, boxes, benches and the merry-go-round, of nodes and links too."""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np

from pipeline.simulation.characters.layout import Link, Plan
from pipeline.simulation.spatial import Array

SPOKES = 8
"""Of the merry-go-round: with its two nodes on the axis these make 18."""

BAR = 0.03
"""Radius of its bars [m]."""

CORNERS = np.array([(x, y, z) for y in (0, 1) for x in (-0.5, 0.5) for z in (-0.5, 0.5)])
"""Of a box of size one that stands on the ground at the origin."""

EDGE = 0.02
"""Radius of the edges of boxes, in their shortest side."""

BALL_ROLLS = 0.03
"""Coulomb's coefficient of what rolls; a single node slides instead."""


def ball(radius: float, mass: float) -> Plan:
    """Return a ball: one node, and a link from it to itself, which can be touched.

    Source: Horswill 2008, "Geometric and kinematic modeling".
    """
    return Plan(
        rest=np.array([[0.0, radius, 0.0]]),
        mass=np.array([mass]),
        radius=np.array([radius]),
        links=(Link((0, 0), radius),),
        air=0.1,
        ground=0.15,
        friction=BALL_ROLLS,
        bounciness=0.55,
    )


def box(size: tuple[float, float, float], mass: float) -> Plan:
    """Return a box of eight nodes that every two of are a link apart; its edges can be touched."""
    girth = EDGE * min(size)
    inner = np.array(size) - 2.0 * girth
    rest = CORNERS * inner + [0.0, girth, 0.0]
    links = tuple(
        Link(pair, girth if _is_edge(*pair) else 0.0) for pair in combinations(range(8), 2)
    )
    return Plan(
        rest=rest,
        mass=np.full(8, mass / 8.0),
        radius=np.full(8, girth),
        links=links,
        ground=10.0,
        friction=0.6,
        edge=girth,
    )


def _is_edge(a: int, b: int) -> bool:
    return bool(np.count_nonzero(CORNERS[a] != CORNERS[b]) == 1)


def merry_go_round(radius: float, mass: float) -> Plan:
    """Return a merry-go-round: 18 nodes and 41 links, of which 25 are bars that can be touched.

    An axis that stays, a rim of eight on spokes, and a post on each. The other links only keep
    it stiff: from the tops of posts to the top of the axis, and from there down to the rim's
    next node.

    So many links leave seven ways to bend: what the rim lies on has to hold it level.

    Source: Horswill 2008, "Geometric and kinematic modeling", which counts them.
    """
    deck, top = 0.22 * radius / 1.3, 0.95 * radius / 1.3
    turn = 2.0 * math.pi * np.arange(SPOKES) / SPOKES
    around = radius * np.stack([np.cos(turn), 0.0 * turn, -np.sin(turn)], axis=1)
    rest = np.concatenate([[[0.0, deck, 0.0], [0.0, top, 0.0]], around, around])
    rest[2 : 2 + SPOKES, 1], rest[2 + SPOKES :, 1] = deck, top
    rim = [2 + k for k in range(SPOKES)]
    posts = [2 + SPOKES + k for k in range(SPOKES)]
    after = [*range(1, SPOKES), 0]
    girth = BAR * radius / 1.3
    bars = [
        (0, 1),
        *((0, node) for node in rim),
        *((rim[k], rim[after[k]]) for k in range(SPOKES)),
        *zip(rim, posts, strict=True),
    ]
    braces = [
        *((1, node) for node in posts),
        *((posts[k], rim[after[k]]) for k in range(SPOKES)),
    ]
    masses = np.full(len(rest), mass / (2 * SPOKES))
    masses[:2] = np.inf
    return Plan(
        rest=rest,
        mass=masses,
        radius=np.full(len(rest), girth),
        links=(*(Link(bar, girth) for bar in bars), *(Link(brace) for brace in braces)),
        air=0.12,
        friction=0.5,
        gliding=tuple(rim),
    )


def axes_of(p: Array, right: tuple[int, int], up: tuple[int, int]) -> Array:
    """Return the rotations (..., 3, 3) of what is rigid, from two of its directions.

    Args:
        p: (..., n, 3) its nodes [m].
        right: nodes from the first of which the second lies towards Z at rest.
        up: likewise towards Y.
    """
    z = p[..., right[1], :] - p[..., right[0], :]
    y = p[..., up[1], :] - p[..., up[0], :]
    y = y / np.sqrt((y * y).sum(axis=-1, keepdims=True))
    z = z - (z * y).sum(axis=-1, keepdims=True) * y
    z = z / np.sqrt((z * z).sum(axis=-1, keepdims=True))
    return np.stack([np.cross(y, z), y, z], axis=-1)


def directions_of(kind: str) -> tuple[tuple[int, int], tuple[int, int]] | None:
    """Return nodes that lie towards Z, and towards Y, from others; None for a ball."""
    if kind == "ball":
        return None
    if kind == "merry-go-round":
        return (2 + SPOKES // 4, 2 + 3 * SPOKES // 4), (0, 1)
    return (0, 1), (0, 4)
