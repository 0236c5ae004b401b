"""Looks: what is seen of balls, boxes, benches and merry-go-rounds."""

from __future__ import annotations

import numpy as np

from pipeline.simulation.characters.layout import Plan
from pipeline.simulation.characters.making import BALL, ROUND, size_of
from pipeline.simulation.characters.things import SPOKES
from pipeline.simulation.dynamics.hull import hull_of
from pipeline.simulation.figures.solids import Solid, ball_solid, loft
from pipeline.simulation.spatial import Array, cross, normalized
from pipeline.spec.cast import Character

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


def looks_of(member: Character, plan: Plan) -> Seen:
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


def _merry_go_round(plan: Plan, radius: float, material: str) -> Seen:
    rest, girth = plan.rest, float(plan.radius[0])
    deck = float(rest[0, 1])
    shown = [link for link in plan.links if link.girth > 0.0]
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
