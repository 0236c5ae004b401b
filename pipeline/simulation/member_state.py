"""Member state: place and extent of a member of the cast in one row."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from pipeline.simulation.convex_distance import box_distance, nearest_points
from pipeline.simulation.spatial import Array


@dataclass(frozen=True, eq=False)
class MemberState:
    """Place and extent of a member, of a part of one, or of a place.

    Attributes:
        centre: (3,) middle of its bounding box [m].
        face: (3,) where others look at it: its head, or else its centre [m].
        v: (3,) velocity of its root [m/s].
        low, high: (3,) corners of its bounding box [m].
        radius: of the vertical cylinder around it [m].
        solids: corners (n, 3) of its convex solids [m].
        loose: (n, 3) nodes without solids, such as the hands of people [m].
        is_present: whether it exists now.
    """

    centre: Array
    face: Array
    v: Array
    low: Array
    high: Array
    radius: float
    solids: tuple[Array, ...] = ()
    loose: Array = field(default_factory=lambda: np.empty((0, 3)))
    is_present: bool = True

    @staticmethod
    def of_place(place: Array) -> MemberState:
        """Returns the state of a point (3,) that never moves [m]."""
        return MemberState(place, place, np.zeros(3), place, place, 0.0)

    @property
    def shapes(self) -> Iterator[Array]:
        """Everything of it that can come near something: solids, nodes, or else its centre."""
        yield from self.solids
        yield from self.loose[:, None]
        if not self.solids and not len(self.loose):
            yield self.centre[None]

    def gap(self, other: MemberState) -> float:
        """Returns the distance between the upright cylinders around two members [m]."""
        dx, _, dz = self.centre - other.centre
        level = max(float(np.hypot(dx, dz)) - self.radius - other.radius, 0.0)
        rise = max(float(other.low[1] - self.high[1]), float(self.low[1] - other.high[1]), 0.0)
        return float(np.hypot(level, rise))

    def nearest(self, place: Array) -> Array:
        """Returns the point (3,) of its solids that is nearest to a place (3,) [m]."""
        point, least = self.centre, np.inf
        nearness = [(box_distance(solid, place[None]), k) for k, solid in enumerate(self.solids)]
        for bound, k in sorted(nearness):
            if bound >= least:
                break
            found, _ = nearest_points(self.solids[k], place[None])
            distance = float(np.linalg.norm(found - place))
            if distance < least:
                point, least = found, distance
        return point
