"""Carousel places: where the posts of a merry-go-round and the gaps between them are."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from pipeline.simulation.characters.playthings import SPOKES
from pipeline.simulation.spatial import Array

GAP_ANGLE = 2.0 * math.pi / SPOKES
"""Angle between neighbouring posts [rad]."""


class CarouselSurvey(NamedTuple):
    """What measures a merry-go-round.

    Attributes:
        first: number of its first node.
        p: (2 + 2 SPOKES, 3) its nodes, always up to date [m].
        measure_deck: returns the radius of its deck [m], and the angle of its first post [rad].
        measure_rate: returns how fast it turns [rad/s].
    """

    first: int
    p: Array
    measure_deck: Callable[[], tuple[float, float]]
    measure_rate: Callable[[], float]


@dataclass(eq=False)
class CarouselPose:
    """A merry-go-round as it stands now. Angles are positive about +Y.

    Attributes:
        first: number of its first node.
        hub: (3,) the middle of its deck [m].
        radius: of the deck [m].
        angle: of its first post [rad].
        feet, tops: (SPOKES, 3) ends of its posts [m].
        measure_rate: returns how fast it turns [rad/s].
    """

    first: int
    hub: Array
    radius: float
    angle: float
    feet: Array
    tops: Array
    measure_rate: Callable[[], float]

    @cached_property
    def rate(self) -> float:
        """Rate at which it turned when first asked [rad/s]."""
        return self.measure_rate()

    def without_rate(self) -> CarouselPose:
        """Return the same pose, whose rate is asked anew."""
        made = object.__new__(CarouselPose)
        made.__dict__.update(self.__dict__)
        made.__dict__.pop("rate", None)
        return made

    def angle_of(self, x: float, z: float) -> float:
        """Return the angle of a position about the hub [rad]."""
        return math.atan2(-(z - self.hub.item(2)), x - self.hub.item(0))

    def post_angle(self, number: int) -> float:
        """Return the angle of a post [rad]."""
        return self.angle + number * GAP_ANGLE

    def gap_angle(self, near: float) -> float:
        """Return the angle of the middle between two posts that is nearest to an angle [rad]."""
        gaps = (near - self.angle) / GAP_ANGLE - 0.5
        return self.angle + (round(gaps) + 0.5) * GAP_ANGLE

    def place(self, angle: float, distance: float) -> Array:
        """Return the place (3,) at an angle and a distance from the hub, on its level [m]."""
        x, y, z = self.hub.tolist()
        return np.array([x + distance * math.cos(angle), y, z - distance * math.sin(angle)])

    def post_nodes(self, number: int) -> tuple[int, int]:
        """Return the numbers of the nodes at the foot and the top of a post."""
        return self.first + 2 + number, self.first + 2 + SPOKES + number
