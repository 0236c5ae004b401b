"""Potential field: walking to a place around what stands in the way.

Where the straight way is not free, the target that pulls is the next place of a `Route`.

Source: Horswill 2008, "Object approach"; Arkin 1998. d_min there is compared with a squared
    distance; here gaps are between surfaces, and so is it. The curl there always goes the same
    way round; here it goes round the side on which an obstacle is not, and a walker that gets no
    farther tries the other way for a while.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cache
from typing import NamedTuple

import numpy as np

from pipeline.simulation.characters.body_arrays import IntArray
from pipeline.simulation.characters.mind.mind import Mind
from pipeline.simulation.characters.mind.motor_command import MotorCommand
from pipeline.simulation.characters.mind.sight import MOST_KNOWN, WALK, Sight, StraightWalk
from pipeline.simulation.characters.visibility_route import (
    CLEARANCES,
    SHRINK_FACTOR,
    are_free,
    straight_way,
)
from pipeline.simulation.dynamics.compiled import (
    Record,
    Records,
    allocating,
    bound,
    compiled,
    entry,
)
from pipeline.simulation.dynamics.record_array import zero_records
from pipeline.simulation.dynamics.vectors import hypotenuse
from pipeline.simulation.spatial import Array

BALANCE_GAP = 0.26  # at which an obstacle pushes as hard as the target pulls, the constant c [m]
MIN_GAP = 0.16  # below which it pushes no harder, d_min [m]
MAX_GAP = 2.6  # above which obstacles are ignored [m]


@entry
def walk_vector(
    offset_x: float,
    offset_z: float,
    away: Array,
    gaps: Array,
    senses: Array,
    pace: float,
) -> tuple[float, float]:
    """Return the walking velocity along x and z [m/s].

    Args:
        offset_x: to the target, without the stop distance [m].
        offset_z: likewise [m].
        away: (n, 2) unit vectors from obstacles to the walker.
        gaps: (n,) between them [m].
        senses: (n,) way round each, 1 or -1: the sign of the curl.
        pace: of the walk [m/s].
    """
    size = hypotenuse(offset_x, offset_z)
    if size < 1e-9:
        return 0.0, 0.0
    pull = pace / max(size, 1e-9) * min(size / 0.3, 1.0)
    x = z = 0.0
    for n in range(len(gaps)):
        # Only obstacles ahead push.
        towards = (away[n, 0] * offset_x + away[n, 1] * offset_z) / size
        ahead = min(max(0.35 - towards, 0.0), 1.0)
        push = pace * BALANCE_GAP * ahead / max(gaps[n], MIN_GAP)
        x += push * (away[n, 0] - senses[n] * away[n, 1])
        z += push * (away[n, 1] + senses[n] * away[n, 0])
    return offset_x * pull + x, offset_z * pull + z


def steer(
    mind: Mind,
    place: Sequence[float] | Array,
    stop_distance: float = 0.0,
    pace: float | None = None,
    target: int = -1,
    touching: bool = False,
) -> MotorCommand:
    """Return the motor command of a walk to a place.

    Args:
        mind: of the walker.
        place: x and z [m].
        stop_distance: from the place [m].
        pace: of the walk, the usual one if left out [m/s].
        target: number of the character there.
        touching: whether the target is approached closely and not stepped aside for.
    """
    pace = mind.pace if pace is None else pace
    x, z = mind.nearest_on_terrain(float(place[0]), float(place[1]))
    at_x, at_z = mind.at.tolist()
    left = max(math.hypot(x - at_x, z - at_z) - stop_distance, 0.0)
    if left < 0.1:
        return MotorCommand(facing=mind.heading_to((x, z)), target=target)
    detour = mind.detour
    forced = detour.forced if mind.now < detour.forced_until else 0.0
    is_free, speed, goal_x, goal_z, left = _straight_walker()(
        *(mind.sight, mind.at, mind.walks), *(target, x, z, stop_distance, pace, forced)
    )
    if is_free:
        detour.route.leave()
    else:
        obstacles, goal = _obstacles(mind, target), np.array([x, z])
        first, length = detour.route.next(
            mind.at, goal, obstacles.middles, obstacles.reaches, mind.walking_bounds
        )
        _walk_to(obstacles, mind.at, mind.walks, first, max(length - stop_distance, 0.0))
        walk = mind.walk
        speed, goal_x, goal_z, left = walk.speed, walk.goal_x, walk.goal_z, walk.left
    detour.update_progress(left, mind.now)
    if speed < 1e-6:
        return MotorCommand(facing=mind.heading_to((x, z)), target=target)
    goal_pace = min(max(speed, 0.35 * pace), pace)
    return MotorCommand((goal_x, goal_z), goal_pace, target, touching)


class _Obstacles(NamedTuple):
    """Circles to walk around.

    Attributes:
        keys: (n,) numbers: of characters, and after these of circles of other rooms.
        middles: (n, 2) [m].
        reaches: (n,) distances to which the middle of the walker can come [m].
        distances: (n,) from the walker [m].
        things: (n,) numbers of their things.
    """

    keys: IntArray
    middles: Array
    reaches: Array
    distances: Array
    things: IntArray


def _obstacles(mind: Mind, target: int) -> _Obstacles:
    """Return all obstacles on the way to a target."""
    return _find_obstacles(mind.sight, target, mind.at, mind.body_radius)


@entry
def _find_obstacles(sight: Sight, target: int, at: Array, body_radius: float) -> _Obstacles:
    """Return all obstacles of a walker at x and z, other than its target [m]."""
    places, distances = sight.places, sight.distances
    circle_middles, circle_radii = sight.circle_middles, sight.circle_radii
    most = len(places) + len(circle_radii)
    keys, things = np.empty(most, np.int64), np.empty(most, np.int64)
    middles, reaches, found = np.empty((most, 2)), np.empty(most), np.empty(most)
    n = 0
    for c in range(len(places)):
        if sight.is_obstacle[c] and c != target and distances[c] > 1e-6:
            keys[n] = things[n] = c
            middles[n, 0], middles[n, 1] = places[c, 0], places[c, 2]
            reaches[n], found[n] = sight.radius[c] + body_radius, distances[c]
            n += 1
    for s in range(len(circle_radii)):
        keys[n] = len(places) + sight.circle_keys[s]
        things[n] = len(places) + sight.circle_things[s]
        x, z = circle_middles[s, 0] - at[0], circle_middles[s, 1] - at[1]
        middles[n, 0], middles[n, 1] = circle_middles[s, 0], circle_middles[s, 1]
        reaches[n] = circle_radii[s] + body_radius
        found[n] = max(math.sqrt(x * x + z * z), 1e-6)
        n += 1
    return _Obstacles(keys[:n], middles[:n], reaches[:n], found[:n], things[:n])


def has_room(mind: Mind, place: Array) -> bool:
    """Tell whether a person has room at a place (2,), as far as the mind remembers."""
    obstacles = _obstacles(mind, -1)
    offset = obstacles.middles - place
    return bool(((offset * offset).sum(axis=1) > obstacles.reaches**2).all())


def is_way_free(mind: Mind, place: Array) -> bool:
    """Tell whether the straight way to a place (2,) is free.

    Inside a circle around something only the way out of it is.
    """
    obstacles = _obstacles(mind, -1)
    reaches = np.minimum(obstacles.reaches, SHRINK_FACTOR * obstacles.distances)
    return bool(are_free(mind.at, place[None], obstacles.middles, reaches)[0])


@entry
def _walk_straight(
    sight: Sight,
    at: Array,
    walks: Records,
    target: int,
    x: float,
    z: float,
    stop_distance: float,
    pace: float,
    forced: float,
) -> StraightWalk:
    """Tell whether the straight way to its goal is free for a walker, and write its walk there.

    Args:
        sight: of the walker.
        at: (2,) its place [m].
        walks: (1,) its `WALK`; changed.
        target: number of the character at the goal or NOBODY.
        x: of the goal [m].
        z: of the same.
        stop_distance: from the goal [m].
        pace: of the walk [m/s].
        forced: way round all obstacles, 0 where each has its own.
    """
    walk = walks[0]
    walk.target, walk.place_x, walk.place_z = target, x, z
    walk.stop_distance, walk.pace, walk.forced = stop_distance, pace, forced
    obstacles = _find_obstacles(sight, walk.target, at, walk.body_radius)
    place = np.array((walk.place_x, walk.place_z))
    is_straight, _ = straight_way(at, place, obstacles.middles, obstacles.reaches, CLEARANCES[0])
    if is_straight:
        x, z = place[0] - at[0], place[1] - at[1]
        left = max(math.sqrt(x * x + z * z) - walk.stop_distance, 0.0)
        _write_walk(obstacles, at, walk, place, left)
    return is_straight, walk.speed, walk.goal_x, walk.goal_z, walk.left


@cache
def _straight_walker() -> Callable[..., StraightWalk]:
    """Return `_walk_straight` for arguments of the types that it always has."""
    numbers, places = np.zeros(1, dtype=np.int64), np.zeros((1, 3))
    seen = Sight(
        *(places, np.zeros(1), np.zeros(1), np.zeros(1, dtype=np.bool_)),
        *(np.zeros((1, 2)), np.zeros(1), numbers, numbers),
    )
    examples = seen, np.zeros(2), zero_records(1, WALK), 0, 0.0, 0.0, 0.0, 0.0, 0.0
    return bound(_walk_straight, examples=examples)


@entry
def _walk_to(obstacles: _Obstacles, at: Array, walks: Records, first: Array, left: float) -> None:
    """Write the walk of a walker whose next place is another than its goal.

    Args:
        obstacles: on the way.
        at: (2,) its place [m].
        walks: (1,) its `WALK`; changed.
        first: (2,) the next place on the way [m].
        left: length of the way [m].
    """
    _write_walk(obstacles, at, walks[0], first, left)


@allocating
def _write_walk(obstacles: _Obstacles, at: Array, walk: Record, first: Array, left: float) -> None:
    """Write a walk that keeps off obstacles and stays on the terrain.

    Args:
        obstacles: on the way.
        at: (2,) the place of the walker [m].
        walk: `WALK` record; changed.
        first: (2,) the next place on the way [m].
        left: length of the way [m].
    """
    forced = walk.forced
    offset_x, offset_z = first[0] - at[0], first[1] - at[1]
    size = max(hypotenuse(offset_x, offset_z), 1e-9)
    near = _near(obstacles, size, walk.body_radius)
    away, gaps, senses = np.empty((len(near), 2)), np.empty(len(near)), np.empty(len(near))
    keys, kept, count = np.empty(len(near), np.int64), np.empty(len(near)), 0
    for n in range(len(near)):
        i = near[n]
        gaps[n] = obstacles.distances[i] - obstacles.reaches[i]
        x, z = obstacles.middles[i, 0] - at[0], obstacles.middles[i, 1] - at[1]
        away[n, 0], away[n, 1] = -x / obstacles.distances[i], -z / obstacles.distances[i]
        sense = 0.0
        for k in range(walk.known):
            if walk.known_keys[k] == obstacles.keys[i]:
                sense = walk.known_senses[k]
        if sense == 0.0 and forced == 0.0:
            # On the side on which the obstacle is not.
            sense = 1.0 if offset_x * z - offset_z * x >= 0.0 else -1.0
        if sense != 0.0:
            keys[count], kept[count] = obstacles.keys[i], sense
            count += 1
        senses[n] = forced if forced != 0.0 else sense
    walk.known = min(count, MOST_KNOWN)
    for k in range(walk.known):
        walk.known_keys[k], walk.known_senses[k] = keys[k], kept[k]
    scale = left / size
    x, z = walk_vector(offset_x * scale, offset_z * scale, away, gaps, senses, walk.pace)
    x = _inward(at[0], x, walk.low_x, walk.high_x)
    z = _inward(at[1], z, walk.low_z, walk.high_z)
    speed = hypotenuse(x, z)
    reach, size = max(left, 0.35) if len(near) else left, max(speed, 1e-9)
    walk.speed, walk.left = speed, left
    walk.goal_x, walk.goal_z = at[0] + x * reach / size, at[1] + z * reach / size


@compiled
def _inward(at: float, v: float, low: float, high: float) -> float:
    """Return a velocity along an axis that does not lead off the terrain."""
    if at < low and v < 0.0:
        v = 0.2
    if at > high and v > 0.0:
        v = -0.2
    return v


@allocating
def _near(obstacles: _Obstacles, size: float, body_radius: float) -> IntArray:
    """Return the indices of obstacles that are near, and not behind a place at a distance [m].

    A long thing pushes once, from where it is nearest.
    """
    near, count = np.empty(len(obstacles.keys), np.int64), 0
    gaps = np.empty(len(near))
    for i in range(len(near)):
        gaps[i] = obstacles.distances[i] - obstacles.reaches[i]
        if gaps[i] < MAX_GAP and gaps[i] + body_radius < size + 0.1:
            near[count] = i
            count += 1
    nearest, kept = np.empty(count, np.int64), 0
    for i in near[:count]:
        is_nearest = True
        for j in near[:count]:
            if obstacles.things[i] == obstacles.things[j]:
                is_nearest &= not (gaps[j] < gaps[i] or (gaps[j] == gaps[i] and j < i))
        if is_nearest:
            nearest[kept] = i
            kept += 1
    return nearest[:kept]
