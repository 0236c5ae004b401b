"""Visibility route."""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass, field

import numpy as np

from pipeline.simulation.characters.body_arrays import IntArray, RecordArray
from pipeline.simulation.characters.solid_arrays import SOLID
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground

LOW, HEADROOM = 0.07, 1.9
"""What ends so little above the ground is stepped over; what begins so high is gone under [m]."""

LIGHT = 15.0
"""What gives way and weighs less than this is no barrier, for people walk on into it: about a
quarter of what they weigh [kg]."""

MOST = 32
"""Circles of one solid."""


class ObstacleCircles:
    """The circles around solids, as they are now.

    Args:
        ground: the terrain.

    Attributes:
        middles: (n, 2) x and z [m].
        radii: (n,) [m].
        keys: (n,) numbers that a circle keeps while its solid stays as it lies.
        wholes: (n,) numbers of the things that they are of: limbs of one creature are one thing.
    """

    def __init__(self, ground: Ground) -> None:
        self._ground = ground
        self.put(np.zeros(0, dtype=SOLID))

    def put(self, solids: RecordArray) -> None:
        """Look at these solids (S,) `SOLID` from now on."""
        self._solids = solids
        self._which: IntArray = np.flatnonzero(solids["inverse_mass"] <= 1.0 / LIGHT)
        self._seen = b""
        self.middles, self.radii = np.zeros((0, 2)), np.zeros(0)
        self.keys: IntArray = np.zeros(0, dtype=np.int64)
        self.wholes: IntArray = np.zeros(0, dtype=np.int64)

    def look(self) -> bool:
        """See where the solids are now; tell whether anything is in anybody's way."""
        solids = self._solids
        if not len(self._which):
            return False
        seen = solids["p"].tobytes() + solids["R"].tobytes() + solids["is_present"].tobytes()
        if seen != self._seen:
            self._seen = seen
            self._look()
        return bool(len(self.radii))

    def _look(self) -> None:
        which = self._which
        which = which[self._solids["is_present"][which]]
        solids = self._solids[which]
        R, half = solids["R"], solids["half"]
        middle = solids["p"] + (R @ solids["middle"][:, :, None])[:, :, 0]
        # Of its axes in the world, as long as half of the box (S, axis, 3).
        axes = np.swapaxes(R, 1, 2) * half[:, :, None]
        rise = np.abs(axes[:, :, 1]).sum(axis=1)
        floor = self._ground.height(middle[:, 0], middle[:, 2])
        stands = (middle[:, 1] + rise > floor + LOW) & (middle[:, 1] - rise < floor + HEADROOM)
        self._lay(which[stands], middle[stands][:, [0, 2]], axes[stands][:, :, [0, 2]])

    def _lay(self, which: IntArray, middle: Array, axes: Array) -> None:
        """Lay rows of circles along shadows.

        Args:
            which: (S,) numbers of the solids.
            middle: (S, 2) [m].
            axes: (S, 3, 2) half of each edge of the box, seen from above [m].
        """
        longest = np.argmax((axes * axes).sum(axis=2), axis=1)
        ahead = axes[np.arange(len(axes)), longest]
        ahead = ahead / np.maximum(np.hypot(*ahead.T), 1e-9)[:, None]
        across = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1)
        long = np.abs((axes * ahead[:, None]).sum(axis=2)).sum(axis=1)
        wide = np.abs((axes * across[:, None]).sum(axis=2)).sum(axis=1)
        balls = self._solids["radius"][which]
        counts = np.clip(np.ceil(long / np.maximum(wide, 1e-3) - 1e-6), 1, MOST).astype(np.int64)
        counts[balls > 0.0] = 1
        radii = np.where(balls > 0.0, balls, np.hypot(long / counts, wide))
        row = np.repeat(np.arange(len(which)), counts)
        number = np.arange(len(row)) - np.repeat(np.cumsum(counts) - counts, counts)
        place = (2.0 * number + 1.0) / counts[row] - 1.0
        self.middles = middle[row] + (place * long[row])[:, None] * ahead[row]
        self.radii = radii[row]
        self.keys = which[row] * MOST + number
        self.wholes = self._solids["thing"][which[row]]


CLEARANCES = (0.32, 0.16, 0.04)
"""How wide of things somebody goes: the widest with which there is a way [m]."""

CORNERS = 8
"""Places around each thing."""

TURN = 2.0 * math.pi * np.arange(CORNERS) / CORNERS

RING = np.stack([np.cos(TURN), np.sin(TURN)], axis=1) / math.cos(math.pi / CORNERS)
"""(CORNERS, 2) around a circle of radius 1 that lies within the lines between them."""

WITHIN = 0.98
"""Part of their distance to which circles shrink whose clearance begin or goal lie in."""

REACHED = 0.25
"""How near a place on the way one comes before it goes on to the next [m]."""

MOVED = 0.6
"""How far a goal or a thing moves before the way is searched for anew [m]."""


def are_free(start: Array, ends: Array, middles: Array, reaches: Array) -> Array:
    """Return (m,) whether straight lines lead past all circles.

    Args:
        start: (2,) [m].
        ends: (m, 2) [m].
        middles: (n, 2) of circles [m].
        reaches: (n,) their radii [m].
    """
    way = ends - start
    squared = np.maximum((way * way).sum(axis=1), 1e-12)
    to = middles - start
    along = np.clip((way @ to.T) / squared[:, None], 0.0, 1.0)
    x = along * way[:, :1] - to[:, 0]
    z = along * way[:, 1:] - to[:, 1]
    free: Array = (x * x + z * z >= (reaches - 1e-6) ** 2).all(axis=1)
    return free


def shortest(start: Array, goal: Array, middles: Array, reaches: Array, within: Array) -> Array:
    """Return (m, 2) the places on the shortest way, the goal last; none if there is no way.

    Args:
        start: (2,) [m].
        goal: (2,) [m].
        middles: (n, 2) of circles that nothing leads through [m].
        reaches: (n,) their radii [m].
        within: (2, 2) least and greatest x and z of a place on the way [m].
    """
    ring = (middles[:, None] + reaches[:, None, None] * RING).reshape(-1, 2)
    ring = ring[((ring > within[0]) & (ring < within[1])).all(axis=1)]
    places = np.concatenate([start[None], goal[None], ring])
    left = np.sqrt(((places - goal) ** 2).sum(axis=1))
    gone, came = np.full(len(places), np.inf), np.full(len(places), -1)
    gone[0] = 0.0
    done = np.zeros(len(places), dtype=bool)
    queue = [(float(left[0]), 0)]
    while queue:
        _, here = heapq.heappop(queue)
        if done[here]:
            continue
        if here == 1:
            return _back(places, came)
        done[here] = True
        far = gone[here] + np.sqrt(((places - places[here]) ** 2).sum(axis=1))
        better = np.flatnonzero(~done & (far < gone - 1e-9))
        free = better[are_free(places[here], places[better], middles, reaches)]
        gone[free], came[free] = far[free], here
        for k in free.tolist():
            heapq.heappush(queue, (float(gone[k] + left[k]), k))
    return np.zeros((0, 2))


def _back(places: Array, came: Array) -> Array:
    way, at = list[int](), 1
    while at > 0:
        way.append(at)
        at = int(came[at])
    result: Array = places[way[::-1]]
    return result


@dataclass
class Route:
    """Somebody's way to a goal, searched for again when that or a thing has moved.

    Attributes:
        places: (m, 2) still to come, the goal last [m].
        goal: (2,) for which it was searched [m].
        middles: (n, 2) of things, then [m].
    """

    places: Array = field(default_factory=lambda: np.zeros((0, 2)))
    goal: Array = field(default_factory=lambda: np.full(2, np.inf))
    middles: Array = field(default_factory=lambda: np.zeros((0, 2)))

    def next(
        self,
        me: Array,
        goal: Array,
        middles: Array,
        reaches: Array,
        within: Array,
        clearance: float = CLEARANCES[0],
    ) -> tuple[Array, float]:
        """Return the place (2,) to go straight to, and how long the whole way is [m].

        Args:
            me: (2,) where somebody is [m].
            goal: (2,) where it goes [m].
            middles: (n, 2) of things in between [m].
            reaches: (n,) how near to them its middle can be [m].
            within: (2, 2) least and greatest x and z of a place on the way [m].
            clearance: how far things have to be from a straight way that is gone [m].
        """
        apart = np.sqrt(((middles - me) ** 2).sum(axis=1))
        at_goal = np.sqrt(((middles - goal) ** 2).sum(axis=1))
        room = WITHIN * np.minimum(apart, at_goal)
        wide = np.minimum(reaches + clearance, room)
        if are_free(me, goal[None], middles, wide)[0]:
            self.places = goal[None]
        elif self._is_old(me, goal, middles, np.minimum(reaches, room)):
            self._search(me, goal, middles, reaches, room, within)
        elif len(self.places) > 1 and math.dist(self.places[0], me) < REACHED:
            self.places = self.places[1:]
        self.places[-1] = goal
        ways = np.diff(np.concatenate([me[None], self.places]), axis=0)
        return self.places[0], float(np.sqrt((ways * ways).sum(axis=1)).sum())

    def _is_old(self, me: Array, goal: Array, middles: Array, reaches: Array) -> bool:
        """Tell whether the way is none any more."""
        if len(self.places) < 2 or math.dist(goal, self.goal) > MOVED:
            return True
        if len(middles) != len(self.middles):
            return True
        off = middles - self.middles
        moved = bool((off * off).sum(axis=1).max(initial=0.0) > MOVED**2)
        return moved or not are_free(me, self.places[:1], middles, reaches)[0]

    def _search(
        self, me: Array, goal: Array, middles: Array, reaches: Array, room: Array, within: Array
    ) -> None:
        self.goal, self.middles = goal.copy(), middles.copy()
        for clearance in CLEARANCES:
            wide = np.minimum(reaches + clearance, room)
            self.places = shortest(me, goal, middles, wide, within)
            if len(self.places):
                return
        self.places = goal[None].copy()
