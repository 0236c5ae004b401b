"""Sight: what a mind knows of things in its way, as arrays for compiled code."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.characters.body_arrays import IntArray
from pipeline.simulation.spatial import Array


class Sight(NamedTuple):
    """What a walker knows of things in its way.

    Attributes:
        places: (C, 3) of characters as remembered [m].
        distances: (C,) of these [m].
        radius: (C,) of the circles around them [m].
        is_obstacle: (C,) which are walked around.
        circle_middles: (S, 2) of circles of other rooms [m].
        circle_radii: (S,) [m].
        circle_keys: (S,) their numbers.
        circle_things: (S,) numbers of their things.
    """

    places: Array
    distances: Array
    radius: Array
    is_obstacle: NDArray[np.bool_]
    circle_middles: Array
    circle_radii: Array
    circle_keys: IntArray
    circle_things: IntArray


StraightWalk = tuple[bool, float, float, float, float]
"""Whether the straight way is free, and only then speed [m/s], x and z to walk to, way left [m]."""

MOST_KNOWN = 32
"""Obstacles whose way round a walker keeps in mind."""

WALK = np.dtype(
    [
        # The walker: radius of the circle on the ground around it [m], least and greatest x and z
        # of places on the way [m].
        ("body_radius", "f8"),
        *((name, "f8") for name in ("low_x", "low_z", "high_x", "high_z")),
        # What it wants: number of the character at the goal or NOBODY, x and z of the goal, the
        # distance from it at which to stop [m], the pace [m/s], and the way round all obstacles,
        # 0 where each has its own.
        ("target", "i8"),
        ("place_x", "f8"),
        ("place_z", "f8"),
        ("stop_distance", "f8"),
        ("pace", "f8"),
        ("forced", "f8"),
        # How many near obstacles it goes round, their numbers, and the way round each, 1 or -1.
        ("known", "i8"),
        ("known_keys", "i8", MOST_KNOWN),
        ("known_senses", "f8", MOST_KNOWN),
        # What it does next: speed [m/s], where to walk to, and the length of the way [m].
        ("speed", "f8"),
        ("goal_x", "f8"),
        ("goal_z", "f8"),
        ("left", "f8"),
    ],
    align=True,
)
"""The walk of a mind to a place."""
