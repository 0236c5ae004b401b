"""Playthings: balls, boxes, benches and merry-go-rounds, as nodes and links and as meshes."""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np

from pipeline.simulation.characters.body_plan import BodyPlan, Link
from pipeline.simulation.dynamics.hull import hull_of
from pipeline.simulation.figures.solids import Solid, ball_solid, join_solids, loft
from pipeline.simulation.spatial import Array, cross, normalized
from pipeline.spec.character import Character

BALL_RADIUS, BALL_MASS = 0.12, 0.4  # of a playground's ball [m], [kg]
DECK_RADIUS, MERRY_GO_ROUND_MASS = 1.3, 90.0  # [m], [kg]

BOX_SIZES = {"box": ((0.5, 0.5, 0.5), 9.0), "bench": ((0.42, 0.42, 1.5), 26.0)}
"""Extents along X, Y and Z [m] and masses [kg]."""


def box_size(member: Character) -> tuple[float, float, float]:
    """Return the extents of a box or a bench [m]."""
    x, y, z = BOX_SIZES[member.character][0]
    return x * member.scale, y * member.scale, z * member.scale


SPOKES = 8  # of a merry-go-round; with two nodes on the axis these make 18 nodes
BAR_RADIUS = 0.03  # of a merry-go-round of full size [m]
EDGE_FRACTION = 0.02  # radius of a box's edges, in its shortest side
BALL_FRICTION = 0.03  # Coulomb's coefficient: a single node slides instead of rolling

CORNERS = np.array([(x, y, z) for y in (0, 1) for x in (-0.5, 0.5) for z in (-0.5, 0.5)])
"""Corners of a unit box that stands on the ground at the origin."""


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
        friction=BALL_FRICTION,
        bounciness=0.55,
    )


def box_plan(size: tuple[float, float, float], mass: float) -> BodyPlan:
    """Return a box of eight nodes, linked pairwise; its edges can be touched."""
    edge_radius = EDGE_FRACTION * min(size)
    rest = CORNERS * (np.array(size) - 2.0 * edge_radius) + [0.0, edge_radius, 0.0]
    links = tuple(
        Link(pair, edge_radius if _is_edge(*pair) else 0.0) for pair in combinations(range(8), 2)
    )
    return BodyPlan(
        rest=rest,
        mass=np.full(8, mass / 8.0),
        radius=np.full(8, edge_radius),
        links=links,
        ground_damping=10.0,
        friction=0.6,
        edge_radius=edge_radius,
    )


def _is_edge(a: int, b: int) -> bool:
    return bool(np.count_nonzero(CORNERS[a] != CORNERS[b]) == 1)


def merry_go_round_plan(radius: float, mass: float) -> BodyPlan:
    """Return a merry-go-round: 18 nodes and 41 links, of which 25 are bars that can be touched.

    An axis that stays in place, a rim of eight on spokes, and a post on each. The other links are
    braces: from the tops of posts to the top of the axis, and from there down to the rim's next
    node. So many links leave seven ways to bend: a level bearing holds the rim.

    Source: Horswill 2008, "Geometric and kinematic modeling", which counts them.
    """
    deck, top = 0.22 * radius / 1.3, 0.95 * radius / 1.3
    turn = 2.0 * math.pi * np.arange(SPOKES) / SPOKES
    ring = radius * np.stack([np.cos(turn), 0.0 * turn, -np.sin(turn)], axis=1)
    rest = np.concatenate([[[0.0, deck, 0.0], [0.0, top, 0.0]], ring, ring])
    rest[2 : 2 + SPOKES, 1], rest[2 + SPOKES :, 1] = deck, top
    rim = [2 + k for k in range(SPOKES)]
    posts = [2 + SPOKES + k for k in range(SPOKES)]
    next_spoke = [*range(1, SPOKES), 0]
    bar_radius = BAR_RADIUS * radius / 1.3
    bars = [
        (0, 1),
        *((0, node) for node in rim),
        *((rim[k], rim[next_spoke[k]]) for k in range(SPOKES)),
        *zip(rim, posts, strict=True),
    ]
    braces = [
        *((1, node) for node in posts),
        *((posts[k], rim[next_spoke[k]]) for k in range(SPOKES)),
    ]
    masses = np.full(len(rest), mass / (2 * SPOKES))
    masses[:2] = np.inf
    return BodyPlan(
        rest=rest,
        mass=masses,
        radius=np.full(len(rest), bar_radius),
        links=(
            *(Link(bar, bar_radius, is_deck=set(bar) <= {0, *rim}) for bar in bars),
            *(Link(brace) for brace in braces),
        ),
        air_damping=0.12,
        friction=0.5,
        bearing_nodes=tuple(rim),
    )


def axes_of(p: Array, right: tuple[int, int], up: tuple[int, int]) -> Array:
    """Return the rotations (..., 3, 3) of a rigid thing from two of its axes.

    Args:
        p: (..., n, 3) its nodes [m].
        right: nodes along Z at rest.
        up: nodes along Y at rest.
    """
    z = p[..., right[1], :] - p[..., right[0], :]
    y = p[..., up[1], :] - p[..., up[0], :]
    y = y / np.sqrt((y * y).sum(axis=-1, keepdims=True))
    z = z - (z * y).sum(axis=-1, keepdims=True) * y
    z = z / np.sqrt((z * z).sum(axis=-1, keepdims=True))
    return np.stack([np.cross(y, z), y, z], axis=-1)


def axis_nodes(kind: str) -> tuple[tuple[int, int], tuple[int, int]] | None:
    """Return pairs of nodes along Z and along Y of a thing; None for a ball."""
    if kind == "ball":
        return None
    if kind == "merry-go-round":
        return (2 + SPOKES // 4, 2 + 3 * SPOKES // 4), (0, 1)
    return (0, 1), (0, 4)


NamedSolids = list[tuple[str, Solid, str]]
"""Suffixes of the thing's name, solids about the origin, materials."""

MATERIALS = {
    "ball": "red rubber",
    "merry-go-round": "blue painted metal",
    "box": "wood",
    "bench": "oak",
}
"""Default materials."""

DECK_MATERIAL, PANEL_MATERIAL = "red painted metal", "ivory"
BAR_SIDES, DECK_SIDES = 15, 64


def thing_solids(member: Character, plan: BodyPlan) -> NamedSolids:
    """Return the meshes of a thing at rest at the origin."""
    material = member.material or MATERIALS[member.character]
    if member.character == "ball":
        whole = ball_solid(np.zeros(3), BALL_RADIUS * member.scale)
        middles = whole.vertices[whole.faces].mean(axis=1)
        light = np.arctan2(middles[:, 1], middles[:, 2]) // (np.pi / 3.0) % 2.0 == 1.0
        return [
            ("", Solid(whole.vertices, whole.faces[~light]), material),
            (".panels", Solid(whole.vertices, whole.faces[light]), PANEL_MATERIAL),
        ]
    if member.character == "box":
        x, y, z = box_size(member)
        return [("", _slab((x, y, z), (0.0, 0.5 * y, 0.0)), material)]
    if member.character == "bench":
        return _bench_solids(box_size(member), material)
    return _merry_go_round_solids(plan, DECK_RADIUS * member.scale, material)


def _bench_solids(size: tuple[float, float, float], material: str) -> NamedSolids:
    x, y, z = size
    thickness = 0.11 * y
    seat = _slab((x, thickness, z), (0.0, y - 0.5 * thickness, 0.0))
    legs = [
        _slab(
            (0.8 * x, y - thickness, thickness),
            (0.0, 0.5 * (y - thickness), side * (0.5 * z - 2.0 * thickness)),
        )
        for side in (-1, 1)
    ]
    stretcher = _slab((0.9 * thickness, 1.6 * thickness, z - 5.0 * thickness), (0.0, 0.55 * y, 0.0))
    return [("", join_solids([seat, *legs, stretcher]), material)]


def _merry_go_round_solids(plan: BodyPlan, radius: float, material: str) -> NamedSolids:
    rest, bar_radius = plan.rest, float(plan.radius[0])
    deck = float(rest[0, 1])
    touchable = [link for link in plan.links if link.radius > 0.0]
    bars = [
        _bar(rest[link.ends[0]], rest[link.ends[1]], bar_radius) for link in touchable[1 + SPOKES :]
    ]
    post = _bar(rest[0] * [0.0, 0.1, 0.0], rest[1], 2.0 * bar_radius)
    profile = [(0.0, deck + bar_radius), (radius, deck + bar_radius), (radius, deck - bar_radius)]
    plate = _revolved([*profile, (0.3 * radius, deck - 2.0 * bar_radius)])
    base = _revolved([(5.0 * bar_radius, deck), (8.0 * bar_radius, 0.0)])
    return [
        ("", join_solids([*bars, post]), material),
        (".deck", join_solids([plate, base]), DECK_MATERIAL),
    ]


def _bar(a: Array, b: Array, radius: float) -> Solid:
    along = normalized(b - a)
    across = normalized(cross(along, np.array([1.0, 0.3, 0.2])))
    other = cross(along, across)
    angle = 2.0 * np.pi * np.arange(BAR_SIDES) / BAR_SIDES
    ring = np.cos(angle)[:, None] * across + np.sin(angle)[:, None] * other
    steps = [(a, s) for s in (-0.9, -0.5, 0.0)] + [(b, s) for s in (0.0, 0.5, 0.9)]
    rings = [end + radius * (s * along + np.sqrt(1.0 - s * s) * ring) for end, s in steps]
    return loft(np.stack(rings), np.stack([a - radius * along, b + radius * along]))


def _revolved(profile: list[tuple[float, float]]) -> Solid:
    """Return the surface of revolution about Y through radii and heights, from top to bottom."""
    angle = 2.0 * np.pi * np.arange(DECK_SIDES) / DECK_SIDES
    ring = np.stack([np.cos(angle), np.zeros(DECK_SIDES), -np.sin(angle)], axis=1)
    rings = [max(r, 1e-4) * ring + [0.0, y, 0.0] for r, y in reversed(profile)]
    ends = np.array([[0.0, profile[-1][1], 0.0], [0.0, profile[0][1], 0.0]])
    return loft(np.stack(rings), ends)


def _slab(size: tuple[float, float, float], middle: tuple[float, float, float]) -> Solid:
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
