"""Playthings."""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np

from pipeline.simulation.characters.body_plan import BodyPlan, Link
from pipeline.simulation.dynamics.hull import hull_of
from pipeline.simulation.figures.solids import Solid, ball_solid, loft
from pipeline.simulation.spatial import Array, cross, normalized
from pipeline.spec.character import Character

BALL, BALL_MASS = 0.12, 0.4
"""Radius [m] and mass of a playground's ball [kg]."""

ROUND, ROUND_MASS = 1.3, 90.0
"""Radius [m] and mass of a merry-go-round [kg]."""

BOXES = {"box": ((0.5, 0.5, 0.5), 9.0), "bench": ((0.42, 0.42, 1.5), 26.0)}
"""Extents along X, Y and Z [m] and masses [kg]."""


def size_of(member: Character) -> tuple[float, float, float]:
    """Return the extents of a box or a bench [m]."""
    x, y, z = BOXES[member.character][0]
    return x * member.scale, y * member.scale, z * member.scale


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


def ball_plan(radius: float, mass: float) -> BodyPlan:
    """Return a ball: one node, and a link from it to itself, which can be touched.

    Source: Horswill 2008, "Geometric and kinematic modeling".
    """
    return BodyPlan(
        rest=np.array([[0.0, radius, 0.0]]),
        mass=np.array([mass]),
        radius=np.array([radius]),
        links=(Link((0, 0), radius),),
        air_damping=0.1,
        ground_damping=0.15,
        friction=BALL_ROLLS,
        bounciness=0.55,
    )


def box_plan(size: tuple[float, float, float], mass: float) -> BodyPlan:
    """Return a box of eight nodes that every two of are a link apart; its edges can be touched."""
    girth = EDGE * min(size)
    inner = np.array(size) - 2.0 * girth
    rest = CORNERS * inner + [0.0, girth, 0.0]
    links = tuple(
        Link(pair, girth if _is_edge(*pair) else 0.0) for pair in combinations(range(8), 2)
    )
    return BodyPlan(
        rest=rest,
        mass=np.full(8, mass / 8.0),
        radius=np.full(8, girth),
        links=links,
        ground_damping=10.0,
        friction=0.6,
        edge_radius=girth,
    )


def _is_edge(a: int, b: int) -> bool:
    return bool(np.count_nonzero(CORNERS[a] != CORNERS[b]) == 1)


def merry_go_round_plan(radius: float, mass: float) -> BodyPlan:
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
    return BodyPlan(
        rest=rest,
        mass=masses,
        radius=np.full(len(rest), girth),
        links=(*(Link(bar, girth) for bar in bars), *(Link(brace) for brace in braces)),
        air_damping=0.12,
        friction=0.5,
        bearing_nodes=tuple(rim),
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


Seen = list[tuple[str, Solid, str]]
"""What is seen of a thing: names after its own, solids about the origin, materials."""

MATERIALS = {
    "ball": "red rubber",
    "merry-go-round": "blue painted metal",
    "box": "wood",
    "bench": "oak",
}
"""Of things that name none."""

DECK = "red painted metal"
"""Of what one stands on."""

PANELS = "ivory"
"""Of every other panel of a ball."""

BARS = 15
"""Sides of a bar."""

AROUND = 64
"""Sides of a deck."""


def looks_of(member: Character, plan: BodyPlan) -> Seen:
    """Return what is seen of a thing, standing at the origin as at rest."""
    material = member.material or MATERIALS[member.character]
    if member.character == "ball":
        return _ball(BALL * member.scale, material)
    if member.character == "box":
        x, y, z = size_of(member)
        return [("", _slab((x, y, z), (0.0, 0.5 * y, 0.0)), material)]
    if member.character == "bench":
        return _bench(size_of(member), material)
    return _merry_go_round(plan, ROUND * member.scale, material)


def _ball(radius: float, material: str) -> Seen:
    """Return a ball of two colours, by which one sees it turn."""
    whole = ball_solid(np.zeros(3), radius)
    middles = whole.vertices[whole.faces].mean(axis=1)
    light = np.arctan2(middles[:, 1], middles[:, 2]) // (np.pi / 3.0) % 2.0 == 1.0
    return [
        ("", Solid(whole.vertices, whole.faces[~light]), material),
        (".panels", Solid(whole.vertices, whole.faces[light]), PANELS),
    ]


def _bench(size: tuple[float, float, float], material: str) -> Seen:
    """Return a seat on two boards."""
    x, y, z = size
    thick = 0.11 * y
    seat = _slab((x, thick, z), (0.0, y - 0.5 * thick, 0.0))
    legs = [
        _slab((0.8 * x, y - thick, thick), (0.0, 0.5 * (y - thick), side * (0.5 * z - 2.0 * thick)))
        for side in (-1, 1)
    ]
    rail = _slab((0.9 * thick, 1.6 * thick, z - 5.0 * thick), (0.0, 0.55 * y, 0.0))
    return [("", _joined([seat, *legs, rail]), material)]


def _merry_go_round(plan: BodyPlan, radius: float, material: str) -> Seen:
    rest, girth = plan.rest, float(plan.radius[0])
    deck = float(rest[0, 1])
    shown = [link for link in plan.links if link.radius > 0.0]
    bars = [_bar(rest[link.ends[0]], rest[link.ends[1]], girth) for link in shown[1 + SPOKES :]]
    post = _bar(rest[0] * [0.0, 0.1, 0.0], rest[1], 2.0 * girth)
    profile = [(0.0, deck + girth), (radius, deck + girth), (radius, deck - girth)]
    plate = _turned([*profile, (0.3 * radius, deck - 2.0 * girth)])
    base = _turned([(5.0 * girth, deck), (8.0 * girth, 0.0)])
    return [("", _joined([*bars, post]), material), (".deck", _joined([plate, base]), DECK)]


def _bar(a: Array, b: Array, radius: float) -> Solid:
    """Return a round bar from one place to another, its ends rounded."""
    along = normalized(b - a)
    across = normalized(cross(along, np.array([1.0, 0.3, 0.2])))
    other = cross(along, across)
    angle = 2.0 * np.pi * np.arange(BARS) / BARS
    ring = np.cos(angle)[:, None] * across + np.sin(angle)[:, None] * other
    steps = [(a, s) for s in (-0.9, -0.5, 0.0)] + [(b, s) for s in (0.0, 0.5, 0.9)]
    rings = [end + radius * (s * along + np.sqrt(1.0 - s * s) * ring) for end, s in steps]
    return loft(np.stack(rings), np.stack([a - radius * along, b + radius * along]))


def _turned(profile: list[tuple[float, float]]) -> Solid:
    """Return the surface of revolution about Y through radii and heights, from top to bottom."""
    angle = 2.0 * np.pi * np.arange(AROUND) / AROUND
    ring = np.stack([np.cos(angle), np.zeros(AROUND), -np.sin(angle)], axis=1)
    rings = [max(r, 1e-4) * ring + [0.0, y, 0.0] for r, y in reversed(profile)]
    ends = np.array([[0.0, profile[-1][1], 0.0], [0.0, profile[0][1], 0.0]])
    return loft(np.stack(rings), ends)


def _slab(size: tuple[float, float, float], middle: tuple[float, float, float]) -> Solid:
    """Return a box with bevelled edges."""
    bevel = 0.06 * min(size)
    half = np.array(size) / 2.0
    corners = []
    for axis in range(3):
        reach = half - bevel
        reach[axis] = half[axis]
        signs = np.array([(a, b, c) for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)])
        corners.append(signs * reach)
    hull = hull_of(np.concatenate(corners) + np.array(middle))
    return Solid(hull.vertices, hull.faces)


def _joined(solids: list[Solid]) -> Solid:
    counts = np.cumsum([0, *(len(solid.vertices) for solid in solids)])
    return Solid(
        np.concatenate([solid.vertices for solid in solids]),
        np.concatenate(
            [solid.faces + first for solid, first in zip(solids, counts, strict=False)]
        ).astype(np.uint32),
    )
