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
