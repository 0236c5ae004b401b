"""Potential field: walking to a place around what stands in the way.

Where the straight way is not free, the target that pulls is the next place of a `Route`.

Source: Horswill 2008, "Object approach"; Arkin 1998. d_min there is compared with a squared
    distance; here gaps are between surfaces, and so is it. The curl there always goes the same
    way round; here it goes round the side on which an obstacle is not, and a walker that gets no
    farther tries the other way for a while.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.characters.body_arrays import IntArray
from pipeline.simulation.characters.mind.mind import Mind
from pipeline.simulation.characters.mind.motor_command import MotorCommand
from pipeline.simulation.characters.terrain_edge import EDGE_MARGIN
from pipeline.simulation.characters.visibility_route import SHRINK_FACTOR, are_free
from pipeline.simulation.spatial import Array

BALANCE_GAP = 0.26  # at which an obstacle pushes as hard as the target pulls, the constant c [m]
MIN_GAP = 0.16  # below which it pushes no harder, d_min [m]
MAX_GAP = 2.6  # above which obstacles are ignored [m]


def walk_vector(offset: Array, away: Array, gaps: Array, senses: Array, pace: float) -> Array:
    """Return the walking velocity (2,) along x and z [m/s].

    Args:
        offset: (2,) to the target, without the stop distance [m].
        away: (n, 2) unit vectors from obstacles to the walker.
        gaps: (n,) between them [m].
        senses: (n,) way round each, 1 or -1: the sign of the curl.
        pace: of the walk [m/s].
    """
    size = math.hypot(offset[0], offset[1])
    if size < 1e-9:
        return np.zeros(2)
    pull = offset * (pace / max(size, 1e-9) * min(size / 0.3, 1.0))
    # Only obstacles ahead push.
    ahead = np.clip(0.35 - (away @ offset) / size, 0.0, 1.0)
    push = pace * BALANCE_GAP * ahead / np.maximum(gaps, MIN_GAP)
    curl = np.stack([-away[:, 1], away[:, 0]], axis=1)
    return pull + (push[:, None] * (away + senses[:, None] * curl)).sum(axis=0)


def steer(
    mind: Mind,
    place: Array,
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
    at, low, high = mind.at, mind.surroundings.low, mind.surroundings.high
    place = np.clip(place, low + EDGE_MARGIN, high - EDGE_MARGIN)
    offset = place - at
    size = math.hypot(offset[0], offset[1])
    left = max(size - stop_distance, 0.0)
    if left < 0.1:
        return MotorCommand(facing=mind.heading_to(place), target=target)
    obstacles = _obstacles(mind, target)
    bounds = np.stack([low + 0.5 * EDGE_MARGIN, high - 0.5 * EDGE_MARGIN])
    detour = mind.detour
    first, length = detour.route.next(at, place, obstacles.middles, obstacles.reaches, bounds)
    offset = first - at
    size = max(math.hypot(offset[0], offset[1]), 1e-9)
    left = max(length - stop_distance, 0.0)
    away, gaps, senses = _near_obstacles(mind, obstacles, offset, size)
    detour.update_progress(left, mind.now)
    w = walk_vector(offset * (left / size), away, gaps, senses, pace)
    # Nothing leads off the terrain.
    w = np.where((at < bounds[0]) & (w < 0.0), 0.2, w)
    w = np.where((at > bounds[1]) & (w > 0.0), -0.2, w)
    speed = math.hypot(w[0], w[1])
    if speed < 1e-6:
        return MotorCommand(facing=mind.heading_to(place), target=target)
    goal = at + w * (max(left, 0.35) if len(gaps) else left) / speed
    return MotorCommand(
        goal=(float(goal[0]), float(goal[1])),
        pace=min(max(speed, 0.35 * pace), pace),
        target=target,
        touching=touching,
    )


@dataclass(frozen=True, slots=True)
class _Obstacles:
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
    surroundings, memory = mind.surroundings, mind.memory
    # Walkers step aside for people before they come near.
    walking = surroundings.people & mind.acting
    mask = ~walking & (memory.distances > 1e-6) & mind.is_obstacle
    mask[mind.number_of_self] = False
    if target >= 0:
        mask[target] = False
    keys = np.flatnonzero(mask)
    middles, distances = memory.places[keys][:, [0, 2]], memory.distances[keys]
    reaches = surroundings.radius[keys] + mind.body_radius
    circles = surroundings.view.obstacle_circles
    if not circles.update():
        return _Obstacles(keys, middles, reaches, distances, keys)
    offset = circles.middles - mind.at
    circle_distances = np.sqrt((offset * offset).sum(axis=1))
    return _Obstacles(
        np.concatenate([keys, len(mask) + circles.keys]),
        np.concatenate([middles, circles.middles]),
        np.concatenate([reaches, circles.radii + mind.body_radius]),
        np.concatenate([distances, np.maximum(circle_distances, 1e-6)]),
        np.concatenate([keys, len(mask) + circles.things]),
    )


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


def _near_obstacles(
    mind: Mind, obstacles: _Obstacles, offset: Array, size: float
) -> tuple[Array, Array, Array]:
    """Return unit vectors (n, 2) from near obstacles, gaps [m] and ways round."""
    gaps = obstacles.distances - obstacles.reaches
    near = np.flatnonzero((gaps < MAX_GAP) & (gaps + mind.body_radius < size + 0.1))
    if len(np.unique(obstacles.things[near])) < len(near):
        # A long thing pushes once, from where it is nearest.
        order = near[np.argsort(gaps[near], kind="stable")]
        near = np.sort(order[np.unique(obstacles.things[order], return_index=True)[1]])
    keys, gaps = obstacles.keys[near].tolist(), gaps[near]
    to = obstacles.middles[near] - mind.at
    away = -to / obstacles.distances[near][:, None]
    sides = (offset[0] * to[:, 1] - offset[1] * to[:, 0]).tolist()
    detour = mind.detour
    senses = [detour.sense(key, side, mind.now) for key, side in zip(keys, sides, strict=True)]
    for passed in set(detour.senses) - set(keys):
        del detour.senses[passed]
    return away, gaps, np.array(senses)
