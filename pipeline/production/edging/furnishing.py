"""Furnishing: what stands and hangs along the walls of a room: shelves, chests, pictures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.production.edging.border import Border
from pipeline.production.edging.square import pots
from pipeline.production.edging.turned import lamp, vase
from pipeline.production.scenery.expansion import Copies
from pipeline.production.scenery.prototype import Prototype
from pipeline.simulation.spatial import Array

BOOKS = ("red cloth", "blue cloth", "green cloth", "yellow cloth", "leather", "white cloth")

TOYS = ("red plastic", "blue plastic", "yellow plastic", "pine", "green painted metal")

FURNISHED = (*BOOKS, "pine", "oak", "walnut", "white plaster")
"""Materials of furniture."""

BACK = 0.24
"""Distance of the middle of a piece from the middle of the wall [m]."""


@dataclass(frozen=True, eq=False)
class Spot:
    """Where a piece of furniture stands.

    Attributes:
        border: of the room, to which it is added.
        place: x and z [m].
        heading: along the wall, with the room on its left seen from above [rad].
        level: height of the floor [m].
    """

    border: Border
    place: Array
    heading: float
    level: float

    def at(self, along: float, up: float, inward: float) -> Array:
        """Return a point (3,) along, over and inward of the place [m]."""
        c, s = np.cos(self.heading), np.sin(self.heading)
        x = self.place[0] + c * along + s * inward
        z = self.place[1] - s * along + c * inward
        return np.array([x, self.level + up, z])

    def add(
        self,
        material: str,
        at: tuple[float, float, float],
        size: tuple[float, float, float],
        turn: float = 0.0,
        lean: float = 0.0,
    ) -> None:
        """Add a box by its middle along, over and inward of the place [m]."""
        made = self.border.carpentry
        made.add(f"edging {material}", self.at(*at), size, self.heading + turn, lean)


def furnish_bay(spot: Spot, turn: int, is_free: bool, rng: np.random.Generator) -> None:
    """Add furniture in a bay without a window, a picture where none has room."""
    kind = turn % 4
    if is_free and kind == 0:
        _shelf(spot, rng)
        return
    _picture(spot, rng)
    if not is_free:
        return
    if kind == 1:
        _drawers(spot, rng)
    elif kind == 2:
        _armchair(spot, rng)
    else:
        _chest(spot, rng)


def _shelf(spot: Spot, rng: np.random.Generator) -> None:
    """Add a shelf of books, boxes and a vase."""
    wide, deep, tall, boards = 1.3, 0.3, 1.95, 5
    for side in (-1, 1):
        spot.add("pine", (side * wide / 2, tall / 2, 0), (0.03, tall, deep))
    spot.add("pine", (0, tall / 2, -0.14), (wide, tall, 0.012))
    for k in range(boards + 1):
        up = 0.05 + k * (tall - 0.07) / boards
        spot.add(
            "pine", (0, up, 0), (wide + 0.06 * (k == boards), 0.028, deep + 0.04 * (k == boards))
        )
        at = -wide / 2 + 0.04
        while k < boards and at < wide / 2 - 0.1:
            if rng.uniform() < 0.07:
                size = rng.uniform(0.12, 0.2)
                toy = TOYS[int(rng.integers(0, len(TOYS)))]
                spot.add(toy, (at + size / 2, up + 0.014 + size / 2, 0.02), (size, size, size))
                at += size + 0.03
                continue
            thick = rng.uniform(0.02, 0.05)
            high = rng.uniform(0.2, 0.31)
            book = str(rng.choice(BOOKS))
            place = (at + thick / 2, up + 0.014 + high / 2, rng.uniform(-0.02, 0.04))
            spot.add(book, place, (thick, high, 0.2))
            at += thick + (0.003 if rng.uniform() < 0.9 else rng.uniform(0.05, 0.16))
    _stand(spot, vase(), (-0.35, tall + 0.0, 0.0), (0.30, 0.36, 0.42), 1.0)


def _drawers(spot: Spot, rng: np.random.Generator) -> None:
    """Add a chest of drawers with a lamp and a vase on it."""
    wide, deep, tall = 1.1, 0.44, 0.82
    spot.add("walnut", (0, tall / 2 + 0.04, 0), (wide, tall - 0.08, deep))
    spot.add("walnut", (0, tall + 0.015, 0), (wide + 0.06, 0.03, deep + 0.04))
    for x in (-0.48, 0.48):
        for z in (-0.16, 0.16):
            spot.add("walnut", (x, 0.05, z), (0.06, 0.1, 0.06))
    for k in range(3):
        up = 0.2 + 0.245 * k
        spot.add("oak", (0, up, deep / 2), (wide - 0.08, 0.22, 0.016))
        for x in (-0.27, 0.27):
            spot.add("leather", (x, up, deep / 2 + 0.018), (0.09, 0.02, 0.02))
    _stand(spot, lamp(), (0.32, tall + 0.03, 0.0), (1.0, 1.0, 1.0), 1.0)
    _stand(spot, vase(), (-0.3, tall + 0.03, 0.02), (0.62, 0.2, 0.14), 0.9)
    for k in range(3):
        book = str(rng.choice(BOOKS))
        spot.add(
            book, (0.0, tall + 0.05 + 0.034 * k, 0.02), (0.26, 0.032, 0.19), rng.normal(0, 0.15)
        )


def _armchair(spot: Spot, rng: np.random.Generator) -> None:
    """Add an armchair with a cushion, and a plant beside it."""
    cloth = ("green cloth", "red cloth", "leather")[int(rng.integers(0, 3))]
    spot.add(cloth, (0, 0.28, 0.12), (0.72, 0.2, 0.7))
    spot.add(cloth, (0, 0.43, 0.16), (0.56, 0.13, 0.6))
    spot.add(cloth, (0, 0.68, -0.17), (0.74, 0.62, 0.16), 0.0, -0.14)
    for x in (-0.37, 0.37):
        spot.add(cloth, (x, 0.42, 0.12), (0.14, 0.42, 0.7))
        for z in (-0.16, 0.4):
            spot.add("walnut", (0.9 * x, 0.09, z), (0.05, 0.18, 0.05))
    spot.add("yellow cloth", (0.1, 0.62, -0.02), (0.36, 0.34, 0.1), 0.15, -0.3)
    pots(spot.border, spot.at(0.78, 0.0, 0.0)[None], rng)


def _chest(spot: Spot, rng: np.random.Generator) -> None:
    """Add a toy chest."""
    for k in range(3):
        spot.add("oak", (0, 0.07 + 0.14 * k, 0), (0.9, 0.134, 0.42))
    spot.add("walnut", (0, 0.44, 0), (0.96, 0.035, 0.46))
    for k in range(3):
        size = rng.uniform(0.09, 0.14)
        place = (rng.uniform(-0.35, 0.35), 0.46 + size / 2, rng.uniform(-0.1, 0.1))
        spot.add(TOYS[k], place, (size, size, size), rng.uniform(-0.5, 0.5))


def _picture(spot: Spot, rng: np.random.Generator) -> None:
    """Add pictures in frames: land under a sky, and smaller ones beside it."""
    wall = -BACK - 0.08 + 0.1
    sky = ("rug cream", "blue cloth")[int(rng.integers(0, 2))]
    for x, up, wide, high in (
        (-0.12, 1.55, 0.72, 0.54),
        (0.48, 1.7, 0.28, 0.34),
        (0.48, 1.32, 0.28, 0.28),
    ):
        spot.add("walnut", (x, up, wall), (wide + 0.08, high + 0.08, 0.03))
        spot.add("white plaster", (x, up, wall + 0.012), (wide, high, 0.016))
        inner, tall = wide - 0.1, high - 0.1
        spot.add(sky, (x, up + 0.14 * tall, wall + 0.014), (inner, 0.72 * tall, 0.016))
        spot.add("green cloth", (x, up - 0.33 * tall, wall + 0.0145), (inner, 0.34 * tall, 0.016))
        hill = (x + 0.1 * inner, up - 0.12 * tall, wall + 0.0142)
        made = spot.border.carpentry
        made.add(
            *("edging leather", spot.at(*hill), (0.7 * inner, 0.2 * tall, 0.016), spot.heading),
            *(0.0, (0.2, 1.0)),
        )


def _stand(
    spot: Spot,
    shape: Prototype,
    at: tuple[float, float, float],
    color: tuple[float, float, float],
    size: float,
) -> None:
    """Let a turned thing of a colour stand at a place."""
    point, turn = spot.at(*at)[None], np.eye(3)[None]
    tints, scales = np.array([color]), np.full((1, 3), size)
    spot.border.leaves.append(Copies(shape, point, turn, scales, tints))
