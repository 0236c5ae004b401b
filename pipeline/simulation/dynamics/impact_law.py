"""Impact law: the spring between two bodies in contact that gives the bounciness asked for.

While they approach, the spring pushes them apart with ω² d at depth d; once they part, with
b² ω² d. What the spring took up it gives back times b², so they part at b times the speed
at which they met, however fast that was and whatever they weigh. A damper instead, as
contacts usually have, gives a ratio that changes with the speed and with how deep the two
were when they were found to touch; b = 0.2 was off by 0.05, see `MEASURED`.

Within the step of length h in which they turn, v < 0 < v + ω² d h, the approach is stopped
and b² of the rest of the push stays: a = -v (1 - b²)/h + b² ω² d. Without that, b = 0 came
out as up to 0.19.

Contacts that began at less than the rest speed, or have lasted longer than a bounce, are
damped critically: what rests does not jitter, however bouncy it is.

Source: Walton and Braun 1986 for springs that are softer on the way back.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.compiled import compiled, entry
from pipeline.simulation.spatial import Array

STIFFNESS = 0.25
"""ω h: more is less exact, less costs more steps."""

REST_SPEED = 0.05
"""What comes nearer more slowly does not bounce [m/s]."""

SLAM_SPEED = 0.2
"""Likewise where the two touch already, at another corner [m/s]."""

DULL = 0.05
"""Bounciness below which nothing is given back."""

STOPPED = 0.1
"""Speed that is none, in that which the spring gives in one step."""

LONGER = 1.5
"""How long a bounce may last, in its own length by the formula."""

ALIKE = 0.999
"""Cosine between normals of one plane."""

RIM = 0.02
"""Height above a plane that is none, in radii of the ball."""

MEASURED = {
    0.0: (0.0, 0.0),
    0.2: (0.199, 0.202),
    0.4: (0.398, 0.403),
    0.6: (0.596, 0.605),
    0.8: (0.796, 0.805),
    0.95: (0.947, 0.954),
    1.0: (0.995, 1.007),
}
"""Bounciness asked for: least and greatest found, of balls and boxes that fall flat at 0.5
to 6 m/s and touch anywhere within a step; `benchmarks/bounciness.py` measures it."""


@dataclass(frozen=True, slots=True)
class Touching:
    """All n places at which things touch at one moment, those of one pair in a row.

    Attributes:
        things: (n, 2) numbers of the two.
        normal: (n, 9) the first three from the first to the second.
        place: (n, 3) [m].
        distance: (n,) negative where one is in the other [m].
        velocity: (m, 6) angular and linear velocities of all things in the world, at their
            centres [rad/s, m/s].
        centre: (m, 3) of all things [m].
        bounciness: (m,) of all things; of two the lower one holds.
    """

    things: NDArray[np.int32]
    normal: Array
    place: Array
    distance: Array
    velocity: Array
    centre: Array
    bounciness: Array


class ImpactLaw:
    """Which pairs bounce at the moment, and which rest."""

    def __init__(self) -> None:
        self._pairs = np.zeros(0, dtype=np.int64)
        self._onset = np.zeros(0)

    def press(
        self, touching: Touching, time: float, h: float, rows: NDArray[np.int32], springs: Array
    ) -> tuple[NDArray[np.int64], Array]:
        """Set the springs for a step of `h` [s] from `time` [s] on.

        Args:
            touching: where.
            time: now.
            h: of the step.
            rows: (n,) first row that each place has in `springs`, negative for none.
            springs: (k, 4) whose first two columns become stiffness [1/s²] and damping [1/s];
                rows that are none of the above are friction's.

        Returns:
            The places (s,) at which a bounce begins, one a pair, and the speeds (n,) at which
            all part, negative while they approach [m/s].
        """
        t = touching
        speed = _parting(t.things, t.normal, t.place, t.velocity, t.centre)
        self._pairs, self._onset, bounces, struck = _bouncing(
            t.things, t.bounciness, speed, time, h, self._pairs, self._onset
        )
        _set_springs(t.things, t.bounciness, t.distance, speed, bounces, h, rows, springs)
        return struck, speed


@entry
def _parting(
    things: NDArray[np.int32], normal: Array, place: Array, velocity: Array, centre: Array
) -> Array:
    """Return the speeds (n,) along the normals at which things part [m/s]."""
    speed = np.empty(len(things))
    for i in range(len(things)):
        speed[i] = _along(velocity[things[i, 1]], centre[things[i, 1]], normal[i], place[i])
        speed[i] -= _along(velocity[things[i, 0]], centre[things[i, 0]], normal[i], place[i])
    return speed


@compiled
def _along(velocity: Array, centre: Array, n: Array, place: Array) -> float:
    """Return n · (v + w × r) of one place of one thing."""
    x, y, z = place[0] - centre[0], place[1] - centre[1], place[2] - centre[2]
    v_x = velocity[3] + velocity[1] * z - velocity[2] * y
    v_y = velocity[4] + velocity[2] * x - velocity[0] * z
    v_z = velocity[5] + velocity[0] * y - velocity[1] * x
    result: float = n[0] * v_x + n[1] * v_y + n[2] * v_z
    return result


@compiled
def _lasts(b: float, h: float) -> float:
    """Return how long a bounce may last [s]."""
    return LONGER * 0.5 * np.pi * h / STIFFNESS * (1.0 + 1.0 / max(b, DULL))


@entry
def _bouncing(
    things: NDArray[np.int32],
    bounciness: Array,
    speed: Array,
    time: float,
    h: float,
    known: NDArray[np.int64],
    onset: Array,
) -> tuple[NDArray[np.int64], Array, NDArray[np.bool_], NDArray[np.int64]]:
    """Return pairs, in order, and since when they bounce; which places do; where it began.

    Args:
        things: as in `Touching`, and so on.
        bounciness: of all things.
        speed: (n,) see above.
        time: now [s].
        h: of the step [s].
        known: pairs that touched in the step before, in order.
        onset: when their last bounce began [s].
    """
    n = len(things)
    key = np.empty(n, dtype=np.int64)
    for i in range(n):
        key[i] = things[i, 0] * np.int64(len(bounciness)) + things[i, 1]
    order = np.argsort(key, kind="mergesort")
    pairs, since = np.empty(n, dtype=np.int64), np.empty(n)
    bounces, struck = np.zeros(n, dtype=np.bool_), np.empty(n, dtype=np.int64)
    count, hits, i, k = 0, 0, 0, 0
    while i < n:
        pair, first, quickest = key[order[i]], i, order[i]
        while i < n and key[order[i]] == pair:
            if speed[order[i]] < speed[quickest]:
                quickest = order[i]
            i += 1
        while k < len(known) and known[k] < pair:
            k += 1
        touched = k < len(known) and known[k] == pair
        begun = onset[k] if touched else -np.inf
        b = min(bounciness[things[quickest, 0]], bounciness[things[quickest, 1]])
        lasts = time - begun < _lasts(b, h)
        if not lasts and -speed[quickest] > (SLAM_SPEED if touched else REST_SPEED):
            begun, lasts = time, True
            struck[hits] = quickest
            hits += 1
        for j in range(first, i):
            bounces[order[j]] = lasts
        pairs[count], since[count] = pair, begun
        count += 1
    return pairs[:count], since[:count], bounces, struck[:hits]


@entry
def _set_springs(
    things: NDArray[np.int32],
    bounciness: Array,
    distance: Array,
    speed: Array,
    bounces: NDArray[np.bool_],
    h: float,
    rows: NDArray[np.int32],
    springs: Array,
) -> None:
    """Set stiffness and damping of all places and of all friction; see `ImpactLaw.press`."""
    w = STIFFNESS / h
    for r in range(len(springs)):
        springs[r, 1] = 2.0 * w
    for i in range(len(rows)):
        if rows[i] < 0:
            continue
        b = min(bounciness[things[i, 0]], bounciness[things[i, 1]])
        stiffness, damping, v = w * w, 2.0 * w, speed[i]
        push = w * w * max(-distance[i], 0.0) * h
        # What is not to come back has stopped when little of its approach is left.
        if bounces[i] and (v < -STOPPED * push or b >= DULL):
            damping = 0.0
            if v < 0.0 and v + push > 0.0:
                stiffness, damping = b * b * stiffness, (1.0 - b * b) / h
            elif v >= 0.0:
                stiffness = b * b * stiffness
        springs[rows[i], 0], springs[rows[i], 1] = stiffness, damping


@entry
def beside(
    things: NDArray[np.int32], normal: Array, place: Array, distance: Array, rounds: Array
) -> NDArray[np.bool_]:
    """Return the places (n,) where a ball touches nothing but the rim of a triangle it is not over.

    MuJoCo looks at each prism of a height field alone, so a ball that has sunk into one is
    pushed aside by its neighbours, though their surfaces lie in one plane: 0.95 m/s after an
    impact at 6 m/s. A place counts if it lies above the plane of the deepest one, or has the
    same normal.

    Args:
        things: as in `Touching`, and so on; the terrain is number 0 and comes first.
        normal: upward from the terrain.
        place: in the middle between both surfaces.
        distance: see there.
        rounds: (m,) radii of balls, 0 of what is none [m].
    """
    n = len(things)
    ghosts = np.zeros(n, dtype=np.bool_)
    i = 0
    while i < n:
        first, deepest = i, i
        while i < n and things[i, 0] == things[first, 0] and things[i, 1] == things[first, 1]:
            if distance[i] < distance[deepest]:
                deepest = i
            i += 1
        radius = rounds[things[first, 1]]
        if things[first, 0] != 0 or radius == 0.0 or i - first == 1:
            continue
        for j in range(first, i):
            alike, above = 0.0, 0.0
            for k in range(3):
                m = normal[deepest, k]
                surface = place[j, k] - 0.5 * distance[j] * normal[j, k]
                ground = place[deepest, k] - 0.5 * distance[deepest] * m
                alike += m * normal[j, k]
                above += m * (surface - ground)
            ghosts[j] = alike < ALIKE and above < RIM * radius
    return ghosts
