"""Visibility route: the shortest way around obstacles, as straight lines from place to place.

A potential field alone pulls a walker into corners between things, and through gaps that are
hardly wider than a body. So where the straight way is not free, places around the things are
searched for the shortest way, and the field leads to the first of them.

Solids of other rooms are circles on the ground, from their bounding boxes. A long solid is a row
of circles, so that a wall is not walked around like a tower of the wall's length.

Source: Lozano-Pérez and Wesley 1979 (visibility graphs); Hart, Nilsson and Raphael 1968 (A*).
"""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.characters.body_arrays import IntArray, RecordArray
from pipeline.simulation.characters.solid_arrays import SOLID
from pipeline.simulation.dynamics.compiled import entry
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground

STEP_OVER_HEIGHT, HEADROOM = 0.07, 1.9  # of solids that are no obstacle [m]
LIGHT_MASS = 15.0  # of movable solids that are walked into: a quarter of a person [kg]
LIFTED = 0.15  # of the lowest point of a solid, up to which it lies on the ground [m]
MAX_CIRCLES = 32  # of one solid


class ObstacleCircles:
    """The circles around the solids of other rooms.

    Args:
        ground: the terrain.

    Attributes:
        middles: (n, 2) x and z [m].
        radii: (n,) [m].
        keys: (n,) numbers that a circle keeps while its solid stays as it lies.
        things: (n,) numbers of their things: limbs of one creature are one thing.
        rises: (n,) heights of their tops above the ground; ∞ of what is not above it [m].
        depths: (n,) least extents on the ground of their solids [m].
    """

    def __init__(self, ground: Ground) -> None:
        self._ground = ground
        self.set_solids(np.zeros(0, dtype=SOLID))

    def set_solids(self, solids: RecordArray) -> None:
        """Set the solids (S,) `SOLID` to follow."""
        self._solids = solids
        self._indices: IntArray = np.flatnonzero(solids["inverse_mass"] <= 1.0 / LIGHT_MASS)
        self._state = b""
        self.middles, self.radii = np.zeros((0, 2)), np.zeros(0)
        self.keys: IntArray = np.zeros(0, dtype=np.int64)
        self.things: IntArray = np.zeros(0, dtype=np.int64)
        self.rises, self.depths = np.zeros(0), np.zeros(0)

    def update(self) -> bool:
        """Update the circles from the solids; tell whether there are any."""
        solids = self._solids
        if not len(self._indices):
            return False
        state = solids["p"].tobytes() + solids["R"].tobytes() + solids["is_present"].tobytes()
        if state != self._state:
            self._state = state
            self._update()
        return bool(len(self.radii))

    def _update(self) -> None:
        indices = self._indices
        indices = indices[self._solids["is_present"][indices]]
        solids = self._solids[indices]
        R, half = solids["R"], solids["half"]
        middle = solids["p"] + (R @ solids["middle"][:, :, None])[:, :, 0]
        # Axes in the world, as long as the half extents (S, axis, 3).
        half_axes = np.swapaxes(R, 1, 2) * half[:, :, None]
        half_height = np.abs(half_axes[:, :, 1]).sum(axis=1)
        floor = self._ground.height(middle[:, 0], middle[:, 2])
        is_obstacle = (middle[:, 1] + half_height > floor + STEP_OVER_HEIGHT) & (
            middle[:, 1] - half_height < floor + HEADROOM
        )
        rises = np.where(middle[:, 1] - half_height > floor + LIFTED, np.inf, middle[:, 1] - floor)
        self._rises = (rises + half_height)[is_obstacle]
        self._place_circles(
            indices[is_obstacle],
            middle[is_obstacle][:, [0, 2]],
            half_axes[is_obstacle][:, :, [0, 2]],
        )

    def _place_circles(self, indices: IntArray, middle: Array, half_axes: Array) -> None:
        """Place rows of circles along the shadows of boxes.

        Args:
            indices: (S,) of the solids.
            middle: (S, 2) [m].
            half_axes: (S, 3, 2) of the boxes seen from above, as long as their half extents [m].
        """
        longest = np.argmax((half_axes * half_axes).sum(axis=2), axis=1)
        ahead = half_axes[np.arange(len(half_axes)), longest]
        ahead = ahead / np.maximum(np.hypot(*ahead.T), 1e-9)[:, None]
        across = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1)
        half_length = np.abs((half_axes * ahead[:, None]).sum(axis=2)).sum(axis=1)
        half_width = np.abs((half_axes * across[:, None]).sum(axis=2)).sum(axis=1)
        ball_radii = self._solids["radius"][indices]
        counts = np.clip(
            np.ceil(half_length / np.maximum(half_width, 1e-3) - 1e-6), 1, MAX_CIRCLES
        ).astype(np.int64)
        counts[ball_radii > 0.0] = 1
        radii = np.where(ball_radii > 0.0, ball_radii, np.hypot(half_length / counts, half_width))
        row = np.repeat(np.arange(len(indices)), counts)
        number = np.arange(len(row)) - np.repeat(np.cumsum(counts) - counts, counts)
        along = (2.0 * number + 1.0) / counts[row] - 1.0
        self.middles = middle[row] + (along * half_length[row])[:, None] * ahead[row]
        self.radii = radii[row]
        self.keys = indices[row] * MAX_CIRCLES + number
        self.things = self._solids["thing"][indices[row]]
        self.rises, self.depths = self._rises[row], 2.0 * half_width[row]


CLEARANCES = (0.32, 0.16, 0.04)  # to obstacles; the widest that leaves a path is used [m]

RING_PLACES = 8  # around each thing

RING_ANGLES = 2.0 * math.pi * np.arange(RING_PLACES) / RING_PLACES
RING = np.stack([np.cos(RING_ANGLES), np.sin(RING_ANGLES)], axis=1) / math.cos(
    math.pi / RING_PLACES
)
"""(RING_PLACES, 2) places around a unit circle that lies within the lines between them."""

ENCLOSURE_CHECK = 16  # places searched from, after which it is asked whether the goal is enclosed
SHRINK_FACTOR = 0.98  # of the distance to which circles around start or goal shrink
REACHED_DISTANCE = 0.25  # to a place on the way before the next one is headed for [m]
WAY_BACK = 0.2  # by which the way to the next place is longer than one past it [m]
REPLAN_DISTANCE = 0.6  # moved by a goal or a thing [m]
VAIN_DISTANCE = 0.3  # from where no way was found, within which none is searched again [m]

NO_PLACES: Array = np.zeros((0, 2))
"""A way without places."""


@entry
def are_free(start: Array, ends: Array, middles: Array, reaches: Array) -> NDArray[np.bool_]:
    """Return (m,) whether straight lines lead past all circles.

    Args:
        start: (2,) [m].
        ends: (m, 2) [m].
        middles: (n, 2) of circles [m].
        reaches: (n,) radii [m].
    """
    found = np.ones(len(ends), dtype=np.bool_)
    for m in range(len(ends)):
        way_x, way_z = ends[m, 0] - start[0], ends[m, 1] - start[1]
        squared = max(way_x * way_x + way_z * way_z, 1e-12)
        for n in range(len(middles)):
            x, z = middles[n, 0] - start[0], middles[n, 1] - start[1]
            along = min(max((way_x * x + way_z * z) / squared, 0.0), 1.0)
            x, z = along * way_x - x, along * way_z - z
            if x * x + z * z < (reaches[n] - 1e-6) ** 2:
                found[m] = False
                break
    return found


@entry
def straight_way(
    at: Array, goal: Array, middles: Array, reaches: Array, clearance: float
) -> tuple[bool, Array]:
    """Tell whether the straight way to a goal is free.

    Circles around start and goal shrink, so that these are outside.

    Args:
        at: (2,) start [m].
        goal: (2,) [m].
        middles: (n, 2) of circles [m].
        reaches: (n,) radii [m].
        clearance: from the circles [m].

    Returns:
        Whether it is free, and the (n,) greatest radii that do not contain start or goal [m].
    """
    limits, radii = np.empty(len(middles)), np.empty(len(middles))
    for n in range(len(middles)):
        x, z = middles[n, 0] - at[0], middles[n, 1] - at[1]
        there_x, there_z = middles[n, 0] - goal[0], middles[n, 1] - goal[1]
        here, there = math.sqrt(x * x + z * z), math.sqrt(there_x * there_x + there_z * there_z)
        limits[n] = SHRINK_FACTOR * min(here, there)
        radii[n] = min(reaches[n] + clearance, limits[n])
    return are_free(at, goal.reshape(1, 2), middles, radii)[0], limits


@entry
def is_way_barred(
    at: Array, places: Array, known: Array, middles: Array, reaches: Array, limits: Array
) -> bool:
    """Tell whether a circle has moved, or bars the straight way to a place.

    Args:
        at: (2,) start [m].
        places: (m, 2) [m].
        known: (n, 2) middles of the circles when the way was found [m].
        middles: (n, 2) of the circles now [m].
        reaches: (n,) radii [m].
        limits: (n,) greatest radii [m].
    """
    radii = np.empty(len(middles))
    for n in range(len(middles)):
        x, z = middles[n, 0] - known[n, 0], middles[n, 1] - known[n, 1]
        if x * x + z * z > REPLAN_DISTANCE**2:
            return True
        radii[n] = min(reaches[n], limits[n])
    return not are_free(at, places, middles, radii).all()


@entry
def way_length(at: Array, places: Array) -> float:
    """Return the length of the way from a place (2,) along places (m, 2) [m]."""
    length, from_x, from_z = 0.0, at[0], at[1]
    for m in range(len(places)):
        x, z = places[m, 0] - from_x, places[m, 1] - from_z
        length += math.sqrt(x * x + z * z)
        from_x, from_z = places[m, 0], places[m, 1]
    return length


def shortest_way(start: Array, goal: Array, middles: Array, reaches: Array, bounds: Array) -> Array:
    """Return (m, 2) the places on the shortest way, the goal last; none if there is no way.

    Args:
        start: (2,) [m].
        goal: (2,) [m].
        middles: (n, 2) of circles that nothing leads through [m].
        reaches: (n,) radii [m].
        bounds: (2, 2) least and greatest x and z of places on the way [m].
    """
    ring = (middles[:, None] + reaches[:, None, None] * RING).reshape(-1, 2)
    ring = ring[((ring > bounds[0]) & (ring < bounds[1])).all(axis=1)]
    places = np.concatenate([start[None], goal[None], ring])
    heuristic = np.sqrt(((places - goal) ** 2).sum(axis=1))
    cost, parents = np.full(len(places), np.inf), np.full(len(places), -1)
    cost[0] = 0.0
    closed = np.zeros(len(places), dtype=bool)
    queue, searched = [(float(heuristic[0]), 0)], 0
    while queue:
        _, here = heapq.heappop(queue)
        if closed[here]:
            continue
        searched += 1
        if searched == ENCLOSURE_CHECK and _is_enclosed(
            places, np.isfinite(cost), middles, reaches
        ):
            break
        if here == 1:
            way, at = list[int](), 1
            while at > 0:
                way.append(at)
                at = int(parents[at])
            return places[way[::-1]]
        closed[here] = True
        new_cost = cost[here] + np.sqrt(((places - places[here]) ** 2).sum(axis=1))
        better = np.flatnonzero(~closed & (new_cost < cost - 1e-9))
        free = better[are_free(places[here], places[better], middles, reaches)]
        cost[free], parents[free] = new_cost[free], here
        for k in free.tolist():
            heapq.heappush(queue, (float(cost[k] + heuristic[k]), k))
    return np.zeros((0, 2))


def _is_enclosed(places: Array, reached: NDArray[np.bool_], middles: Array, reaches: Array) -> bool:
    """Tell whether no way leads from the goal to any place that was reached from the start.

    What is around the goal is soon searched; all that is outside is not.

    Args:
        places: (n, 2) start, goal and places between them [m].
        reached: (n,) whether a place was reached from the start.
        middles: (m, 2) of circles [m].
        reaches: (m,) radii [m].
    """
    found = np.zeros(len(places), dtype=bool)
    found[1] = True
    stack = [1]
    while stack:
        here = stack.pop()
        if reached[here]:
            return False
        others = np.flatnonzero(~found)
        free = others[are_free(places[here], places[others], middles, reaches)]
        if reached[free].any():
            return False
        found[free] = True
        stack += free.tolist()
    return True


@dataclass
class Route:
    """A way to a goal, searched again when the goal or a thing has moved.

    Attributes:
        places: (m, 2) still to come, the goal last [m].
        goal: (2,) of the search [m].
        middles: (n, 2) of the things in the search [m].
        vain_from: (2,) where the last search found no way; None if it found one [m].
    """

    places: Array = field(default_factory=lambda: np.zeros((0, 2)))
    goal: Array = field(default_factory=lambda: np.full(2, np.inf))
    middles: Array = field(default_factory=lambda: np.zeros((0, 2)))
    vain_from: Array | None = None

    def next(
        self,
        at: Array,
        goal: Array,
        middles: Array,
        reaches: Array,
        bounds: Array,
        clearance: float = CLEARANCES[0],
    ) -> tuple[Array, float]:
        """Return the place (2,) to walk straight to, and the length of the whole way [m].

        Args:
            at: (2,) present place [m].
            goal: (2,) [m].
            middles: (n, 2) of things [m].
            reaches: (n,) distances that the middle of the walker can come to them [m].
            bounds: (2, 2) least and greatest x and z of places on the way [m].
            clearance: from things on a straight way [m].
        """
        is_straight, limits = straight_way(at, goal, middles, reaches, clearance)
        if is_straight:
            self.go_straight(goal)
        elif self._needs_search(at, goal, middles, reaches, limits):
            self._search(at, goal, middles, reaches, limits, bounds)
        elif len(self.places) > 1 and (
            math.dist(self.places[0], at) < REACHED_DISTANCE
            or self._is_way_back(at, middles, reaches, limits)
        ):
            self.places = self.places[1:]
        self.places[-1] = goal
        return self.places[0], way_length(at, self.places)

    def go_straight(self, goal: Array) -> None:
        """Take the straight way to a goal (2,) [m]."""
        self.places, self.vain_from = goal[None], None

    def leave(self) -> None:
        """Forget the way, as long as the straight one is free."""
        self.places, self.vain_from = NO_PLACES, None

    def _is_way_back(self, at: Array, middles: Array, reaches: Array, limits: Array) -> bool:
        """Tell whether one that was pushed off the way gets on it again without the next place."""
        first, second = self.places[0], self.places[1]
        way = math.dist(at, first) + math.dist(first, second)
        if way - math.dist(at, second) < WAY_BACK:
            return False
        radii = np.minimum(reaches + CLEARANCES[-1], limits)
        return bool(are_free(at, second[None], middles, radii)[0])

    def _needs_search(
        self, at: Array, goal: Array, middles: Array, reaches: Array, limits: Array
    ) -> bool:
        is_vain = self.vain_from is not None and math.dist(at, self.vain_from) < VAIN_DISTANCE
        if len(self.places) < 2 and not is_vain:
            return True
        if math.dist(goal, self.goal) > REPLAN_DISTANCE:
            return True
        if len(middles) != len(self.middles):
            return True
        ahead = self.places[: 0 if is_vain else 1]
        return is_way_barred(at, ahead, self.middles, middles, reaches, limits)

    def _search(
        self, at: Array, goal: Array, middles: Array, reaches: Array, limits: Array, bounds: Array
    ) -> None:
        self.goal, self.middles, self.vain_from = goal.copy(), middles.copy(), None
        for clearance in CLEARANCES:
            radii = np.minimum(reaches + clearance, limits)
            self.places = shortest_way(at, goal, middles, radii, bounds)
            if len(self.places):
                return
        self.places, self.vain_from = goal[None].copy(), at.copy()
