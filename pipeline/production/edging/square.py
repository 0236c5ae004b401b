"""Square: what stands on the paving before houses: a fountain, trees in rings, stalls, pots."""

from __future__ import annotations

import numpy as np

from pipeline.production.edging.border import Border, turns
from pipeline.production.edging.plot import Plot
from pipeline.production.edging.stall import Stall
from pipeline.production.edging.turned import fountain, pot
from pipeline.production.scenery.expansion import Copies
from pipeline.production.scenery.prototype import UP
from pipeline.simulation.spatial import Array

SPACING = 4.6
"""Distance between the things along the sides of a square, about [m]."""

INWARD = 1.75
"""Distance of their row from the edge of the paving [m]."""

FOUNTAIN_RADIUS, RING, STALL = 1.55, 0.95, 1.5
"""Radii of a fountain, of the ring around a tree and of a stall [m]."""

TREE_SIZE, CROWN = 0.62, 2.7
"""Factor on the sizes of trees in a town, and the radius of their crowns [m]."""


def furnish(border: Border, level: float) -> None:
    """Add things along the sides of a square whose paving has a height [m]."""
    rng = np.random.default_rng([border.seed, 491])
    rows = border.rows(-INWARD, SPACING, 2.4, 1.2)
    if not len(rows.places):
        return
    places, heading, outward = rows.places, rows.heading, rows.outward
    order = np.argsort(_aside(border, places))
    has_fountain = False
    for turn, k in enumerate(order.tolist()):
        place = places[k]
        if not border.is_free(place[None], 2.4, 1.0)[0]:
            continue
        if not has_fountain and turn < 4 and border.is_free(place[None], 1.9, 1.7)[0]:
            _fountain(border, place, level)
            has_fountain = True
        elif turn % 2 and _is_apart(border, place):
            back = np.array([outward[k][0], 0.0, outward[k][1]])
            foot = np.array([place[0], level, place[1]])
            Stall(border, foot, float(heading[k]), back, rng).build()
            _plot(border, place, STALL)
        else:
            _ringed_tree(border, place, level, rng)


def _aside(border: Border, places: Array) -> Array:
    """Return the least angles (N,) between the middle of a frame and places (N, 2) [rad]."""
    way = border.points(places)[:, None] - border.view.eyes
    way /= np.linalg.norm(way, axis=-1, keepdims=True)
    cosine = (way * border.view.ahead).sum(axis=-1)
    # A little beside the middle, where the cast does not hide it.
    return np.abs(np.median(np.arccos(np.clip(cosine, -1.0, 1.0)), axis=1) - 0.16)


def _is_apart(border: Border, place: Array) -> bool:
    return bool(border.is_free(place[None], 2.6, STALL)[0])


def _plot(border: Border, place: Array, radius: float) -> None:
    border.plots.append(Plot(place, np.array([1.0, 0.0]), np.array([radius, radius])))


def _fountain(border: Border, place: Array, level: float) -> None:
    """Add a fountain of stone."""
    foot = np.array([[place[0], level - 0.02, place[1]]])
    one = np.ones((1, 3))
    border.stones.append(Copies(fountain(), foot, np.eye(3)[None], one, one))
    for up, wide in ((0.44, 1.78), (1.31, 0.86)):
        for k in range(3):
            # Turned squares make a round; none lies in the plane of another.
            border.carpentry.add(
                *("edging water", foot[0] + (up - 0.001 * k) * UP, (wide, 0.004, wide)),
                k * np.pi / 6,
            )
    _plot(border, place, FOUNTAIN_RADIUS + 0.2)


def _ringed_tree(border: Border, place: Array, level: float, rng: np.random.Generator) -> None:
    """Add a tree in earth within a ring of stones, where it does not shade the cast."""
    tall = 8.5 * TREE_SIZE
    has_tree = not border.shades_the_cast(place[None], tall, 2.2 * TREE_SIZE)[0]
    has_tree &= bool(border.is_free(place[None], tall, CROWN)[0])
    foot = np.array([place[0], level, place[1]])
    count = 12
    angle = 2.0 * np.pi * np.arange(count) / count
    ring = foot + RING * np.stack([np.cos(angle), 0.0 * angle, np.sin(angle)], axis=-1)
    sizes = np.tile([0.46, 0.3, 0.2], (count, 1)) * rng.uniform(0.95, 1.05, (count, 3))
    border.carpentry.add("edging hewn stone", ring + 0.04 * UP, sizes, 0.5 * np.pi - angle)
    for k in range(2):
        border.carpentry.add(
            *("edging dark soil", foot + (0.1 + 0.002 * k) * UP, (1.3, 0.06, 1.3)), k * np.pi / 4
        )
    if has_tree:
        border.add_plants("oak", foot[None] + 0.06 * UP, TREE_SIZE, rng)
    for kind, n, size in (("meadow grass", 16, 0.7), ("daisy", 12, 1.0), ("poppy", 7, 0.8)):
        far, turn = rng.uniform(0.1, 0.72, n), rng.uniform(0.0, 2.0 * np.pi, n)
        spots = np.stack([far * np.cos(turn), np.full(n, 0.12), far * np.sin(turn)], axis=-1)
        spots = spots + foot
        border.add_plants(kind, spots, size, rng)
    if not has_tree:
        border.add_plants("bush", foot[None] + 0.1 * UP, 0.85, rng)
    _plot(border, place, RING + 0.1)


def pots(border: Border, points: Array, rng: np.random.Generator) -> None:
    """Add pots with shrubs and flowers at points (N, 3) [m]."""
    n = len(points)
    scales = rng.uniform(0.85, 1.25, (n, 1)) * np.ones(3)
    tints = rng.uniform(0.75, 1.15, (n, 1)) * np.ones(3)
    headings = turns(rng.uniform(0.0, 2.0 * np.pi, n))
    border.leaves.append(Copies(pot(), points, headings, scales, tints))
    border.add_plants("bush", points + 0.3 * UP, 0.3, rng)
    for kind in ("poppy", "daisy"):
        spots = np.repeat(points, 4, axis=0) + 0.32 * UP
        spots[:, [0, 2]] += rng.normal(0.0, 0.09, (len(spots), 2))
        border.add_plants(kind, spots, 0.7, rng)
