"""Routes: the paths of bodies over the ground plane.

A route is a table along its own length: places and headings, between which it is a cubic with the
headings as tangents. A turn in place has a length too, that of the path of the feet. Beyond its end
a route that stops stays there, so that the last steps are planned for a body that stands; any other
continues straight.

Source: Sims 1987, 10.1 and 3.2.3.
"""

from __future__ import annotations

import bisect
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipeline.simulation.curves import hermite
from pipeline.simulation.spatial import Array
from pipeline.spec.creature import Creature

# Table entries between two waypoints.
ENTRIES = 48

# Corner at a waypoint from which on a creature stops there and turns in place: a spline would come
# to a point.
SHARP_CORNER = math.radians(120.0)

# Angle from the heading at the start to the path from which on a creature first turns in place: a
# spline would bend within a fraction of a leg, at full speed.
SHARP_START = math.radians(75.0)

# Greatest number of laps of a repeated path; no film is longer.
MAX_LAPS = 200


@dataclass(frozen=True, eq=False)
class Route:
    """A path over the plane.

    Attributes:
        s: (n,) distance along it, ascending from 0 [m].
        xz: (n, 2) places [m].
        heading: (n,) continuous, positive about +Y [rad].
        stops: whether it ends with its last entry.
    """

    s: Array
    xz: Array
    heading: Array
    stops: bool

    @property
    def goes_straight(self) -> bool:
        """Whether it never turns and never ends."""
        return len(self.s) == 1 and not self.stops

    @property
    def length(self) -> float:
        """Distance from its first to its last entry [m]; infinite if it does not stop."""
        return float(self.s[-1]) if self.stops else math.inf

    def at(self, s: Array) -> tuple[Array, Array]:
        """Return places (n, 2) [m] and headings (n,) [rad] at distances `s` (n,) [m].

        Before its start the route continues straight back.
        """
        last = len(self.s) - 1
        xz, heading = np.empty((len(s), 2)), np.empty(len(s))
        inside = (s >= 0.0) & (s <= self.s[last])
        if inside.any():
            xz[inside], heading[inside] = self._within(s[inside])
        on = 0.0 if self.stops else 1.0
        for end, out, part in ((0, s < 0.0, 1.0), (last, s > self.s[last], on)):
            heading[out] = self.heading[end]
            beyond = part * (s[out] - self.s[end])[:, None]
            xz[out] = self.xz[end] + beyond * heading_vector(self.heading[end])
        return xz, heading

    def _within(self, s: Array) -> tuple[Array, Array]:
        if len(self.s) == 1:
            return np.repeat(self.xz, len(s), axis=0), np.repeat(self.heading, len(s))
        i = np.clip(np.searchsorted(self.s, s, side="right") - 1, 0, len(self.s) - 2)
        u = ((s - self.s[i]) / (self.s[i + 1] - self.s[i]))[:, None]
        a, b = self.xz[i], self.xz[i + 1]
        # Tangents as long as the chord: nothing moves where it turns in place.
        chord = np.linalg.norm(b - a, axis=-1, keepdims=True)
        t_a, t_b = (chord * heading_vector(self.heading[k]) for k in (i, i + 1))
        xz = hermite(a, b, t_a, t_b, u)
        return xz, self.heading[i] + (self.heading[i + 1] - self.heading[i]) * u[:, 0]

    @cached_property
    def _moves(self) -> Array:
        """(n - 1,) whether the body moves between two entries, or turns in place."""
        return np.linalg.norm(np.diff(self.xz, axis=0), axis=-1) > 0.0

    def turns_at(self, s: float) -> bool:
        """Return whether the body turns in place at a distance [m]."""
        i = int(np.searchsorted(self.s, s, side="right")) - 1
        return 0 <= i < len(self._moves) and not self._moves[i]

    @cached_property
    def _rests(self) -> list[float]:
        """Distances at which a turn in place starts or ends, and the route's end [m]."""
        changes = np.flatnonzero(self._moves[1:] != self._moves[:-1]) + 1
        return [*self.s[changes].tolist(), self.length]

    def distance_to_rest(self, s: float) -> float:
        """Return the distance from `s` to where the body has to rest next [m]."""
        rests = self._rests
        return rests[min(bisect.bisect_left(rests, s + 1e-9), len(rests) - 1)] - s

    @cached_property
    def _curvatures(self) -> tuple[Array, Array]:
        """Middles of the pieces of the table [m], and the curvature there [rad/m]."""
        middles = 0.5 * (self.s[1:] + self.s[:-1])
        bends = np.diff(self.heading) / np.diff(self.s)
        return middles, np.where(self._moves, bends, 0.0)

    def curvature(self, s: Array) -> Array:
        """Return the curvature (n,) at distances (n,) [rad/m]; 0 where it turns in place."""
        if len(self.s) < 2:
            return np.zeros(len(s))
        inside = (s >= 0.0) & (s <= self.s[-1])
        return np.where(inside, np.interp(s, *self._curvatures), 0.0)

    def upto(self, s: float) -> Route:
        """Return the part before `s` [m], ending there."""
        xz, heading = self.at(np.array([s]))
        before = self.s < s - 1e-9
        return Route(
            np.append(self.s[before], s),
            np.concatenate([self.xz[before], xz]),
            np.append(self.heading[before], heading),
            stops=True,
        )

    def beyond(self, s: float) -> Route:
        """Return the part after `s` [m], starting there."""
        xz, heading = self.at(np.array([s]))
        after = self.s > s + 1e-9
        return Route(
            np.append(0.0, self.s[after] - s),
            np.concatenate([xz, self.xz[after]]),
            np.append(heading, self.heading[after]),
            self.stops,
        )

    def then(self, other: Route) -> Route:
        """Return this route followed by another that starts at its last entry."""
        turns = round((self.heading[-1] - other.heading[0]) / (2.0 * math.pi))
        return Route(
            np.concatenate([self.s, self.s[-1] + other.s[1:]]),
            np.concatenate([self.xz, other.xz[1:]]),
            np.concatenate([self.heading, other.heading[1:] + 2.0 * math.pi * turns]),
            other.stops,
        )


def heading_vector(heading: Array | float) -> Array:
    """Return unit vectors (..., 2) along x and z of headings (...,) [rad]."""
    return np.stack([np.cos(heading), -np.sin(heading)], axis=-1)


# --- simple routes ------------------------------------------------------------------


def straight_route(start: Array, heading: float) -> Route:
    """Return the route from `start` (2,) along `heading` [rad] that never ends."""
    return Route(np.zeros(1), np.array([start], dtype=float), np.array([heading]), stops=False)


def standing_route(start: Array, heading: float) -> Route:
    """Return the route that stays at `start` (2,)."""
    return Route(np.zeros(1), np.array([start], dtype=float), np.array([heading]), stops=True)


def turn_in_place(start: Array, heading: float, angle: float, radius: float) -> Route:
    """Return the turn in place by `angle` [rad], as long as the path of feet at `radius` [m]."""
    u = np.linspace(0.0, 1.0, ENTRIES + 1)
    return Route(
        u * max(abs(angle) * radius, 1e-6),
        np.tile(np.asarray(start, dtype=float), (len(u), 1)),
        heading + u * angle,
        stops=True,
    )


def spline_route(points: Sequence[Array], heading: float | None, closed: bool = False) -> Route:
    """Return the spline through waypoints, which stops at the last.

    Args:
        points: two or more (2,) [m], no two neighbours the same.
        heading: at the first [rad]; that of the spline if None.
        closed: whether it comes back to the first, as it left it.

    Source: Catmull and Rom 1974; centripetal after Yuksel, Schaefer and Keyser 2011, which makes
    no loops between near points.
    """
    p = np.array(points, dtype=float)
    if closed:
        p = np.concatenate([p, p[:1]])
    gaps = np.sqrt(np.linalg.norm(np.diff(p, axis=0), axis=-1))
    # Derivatives (n, 2) at the waypoints, by the root of the chord's length.
    slopes = np.diff(p, axis=0) / gaps[:, None]
    a, b = gaps[:-1, None], gaps[1:, None]
    inner = (b * slopes[:-1] + a * slopes[1:]) / (a + b)
    first, last = slopes[0], slopes[-1]
    if closed:
        a, b = gaps[-1], gaps[0]
        first = last = (b * slopes[-1] + a * slopes[0]) / (a + b)
    tangents = np.concatenate([[first], inner, [last]])
    if heading is not None:
        tangents[0] = heading_vector(heading) * gaps[0]
        if closed:
            tangents[-1] = tangents[0] * gaps[-1] / gaps[0]
    u = np.linspace(0.0, 1.0, 8 * ENTRIES + 1)[:, None]
    pieces = [
        hermite(p[i], p[i + 1], gaps[i] * tangents[i], gaps[i] * tangents[i + 1], u)
        for i in range(len(gaps))
    ]
    line = np.concatenate([pieces[0], *(piece[1:] for piece in pieces[1:])])
    return _by_arc_length(line, ENTRIES * len(gaps))


def connecting_route(start: tuple[Array, float], end: tuple[Array, float]) -> Route:
    """Return the curve between two places (2,) [m] that are passed at headings [rad]."""
    (a, heading_a), (b, heading_b) = start, end
    chord = float(np.linalg.norm(b - a))
    u = np.linspace(0.0, 1.0, 8 * ENTRIES + 1)[:, None]
    tangents = chord * heading_vector(heading_a), chord * heading_vector(heading_b)
    return _by_arc_length(hermite(a, b, *tangents, u), ENTRIES)


def _by_arc_length(line: Array, count: int) -> Route:
    """Return the route along a fine line (m, 2), with `count` pieces of equal length."""
    steps = np.diff(line, axis=0)
    lengths = np.linalg.norm(steps, axis=-1)
    along = np.concatenate([[0.0], np.cumsum(lengths)])
    headings = np.unwrap(np.arctan2(-steps[:, 1], steps[:, 0]))
    s = np.linspace(0.0, along[-1], count + 1)
    xz = np.stack([np.interp(s, along, line[:, k]) for k in range(2)], axis=-1)
    return Route(s, xz, np.interp(s, 0.5 * (along[1:] + along[:-1]), headings), stops=True)


# --- routes of configs --------------------------------------------------------------


def plan_route(member: Creature, footprint: Array, farthest: float) -> Route:
    """Return the route of a creature's config.

    Args:
        member: config.
        footprint: (2,) half extent of its feet at rest along x and z [m].
        farthest: bound on the distance that it goes in the film [m].
    """
    start = np.array([member.at[0], member.at[-1]])
    heading = math.radians(member.heading_deg)
    walk = member.walk
    if walk is None:
        return standing_route(start, heading)
    points = [np.array(point) for point in walk.path if tuple(point) != tuple(start)]
    if not points:
        return straight_route(start, heading)
    # Without a given heading a creature starts along its path.
    first = heading if "heading_deg" in member.model_fields_set else None
    radius = float(np.hypot(*footprint))
    if walk.repeat == "once":
        return _through_waypoints([start, *points], first, radius)
    if walk.repeat == "loop" and not sharp_corners([points[-1], start, *points, start]):
        once = spline_route([start, *points], None, closed=True)
        return _repeated(once, once, farthest)
    if walk.repeat == "loop":
        once = _through_waypoints([start, *points, start], first, radius)
        return _repeated(once, _after_turn(once, once, radius), farthest)
    there = _through_waypoints([start, *points], first, radius)
    back = _through_waypoints([*points[::-1], start], None, radius)
    back = _after_turn(there, back, radius)
    return _repeated(there.then(back), _after_turn(back, there, radius).then(back), farthest)


def _through_waypoints(points: Sequence[Array], heading: float | None, radius: float) -> Route:
    """Return the route through waypoints, with turns in place at sharp corners.

    Args:
        points: two or more (2,) [m].
        heading: at the first [rad]; that of the spline if None.
        radius: of the feet, for turns in place [m].
    """
    if heading is not None and _is_behind(points[1] - points[0], heading):
        after = _through_waypoints(points, None, radius)
        angle = math.remainder(float(after.heading[0]) - heading, 2.0 * math.pi)
        return turn_in_place(points[0], heading, angle, radius).then(after)
    cuts = [0, *sharp_corners(points), len(points) - 1]
    route = spline_route(points[: cuts[1] + 1], heading)
    for a, b in itertools.pairwise(cuts[1:]):
        route = route.then(_after_turn(route, spline_route(points[a : b + 1], None), radius))
    return route


def _is_behind(way: Array, heading: float) -> bool:
    """Return whether a way (2,) leads so far back from a heading [rad] that it needs a turn."""
    x, z = way.tolist()
    return abs(math.remainder(math.atan2(-z, x) - heading, 2.0 * math.pi)) > SHARP_START


def sharp_corners(points: Sequence[Array]) -> list[int]:
    """Return the numbers of the inner waypoints that are sharp corners."""
    found = []
    for i in range(1, len(points) - 1):
        a, b = points[i] - points[i - 1], points[i + 1] - points[i]
        angle = math.atan2(a[0] * b[1] - a[1] * b[0], float(a @ b))
        if abs(angle) > SHARP_CORNER:
            found.append(i)
    return found


def _after_turn(before: Route, after: Route, radius: float) -> Route:
    """Return the turn in place from the end of one route into another, and that route."""
    heading = float(before.heading[-1])
    angle = math.remainder(float(after.heading[0]) - heading, 2.0 * math.pi)
    return turn_in_place(before.xz[-1], heading, angle, radius).then(after)


def _repeated(first: Route, lap: Route, farthest: float) -> Route:
    """Return `first` followed by laps until it is longer than `farthest` [m]."""
    result = first
    for _ in range(MAX_LAPS):
        if result.s[-1] > farthest:
            break
        result = result.then(lap)
    return result
