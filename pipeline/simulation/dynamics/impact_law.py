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

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.compiled import compiled, entry
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.spatial import Array

Triple = tuple[float, float, float]

STIFFNESS = 0.25
"""ω h: more is less exact, less costs more steps."""

REST_SPEED = 0.05
"""What comes nearer more slowly does not bounce [m/s]."""

SLAM_SPEED = 0.2
"""Likewise where the two touch already, at another corner [m/s]."""

DULL = 0.05
"""Bounciness below which nothing is given back."""

ROLLING = 10.0
"""Rate at which spin and rolling come to rest where friction can do it [1/s]."""

SPARE = 4.0
"""Weights that a contact may carry beyond its own."""

LONGER = 1.5
"""How long a bounce may last, in its own length by the formula."""

ALIKE = 0.999
"""Cosine between normals of one plane."""

RIM = 0.02
"""Height above a plane that is none, in radii of the ball."""

MEASURED = {
    0.0: (0.000, 0.000),
    0.2: (0.196, 0.214),
    0.4: (0.395, 0.414),
    0.6: (0.598, 0.613),
    0.8: (0.796, 0.816),
    0.95: (0.949, 0.966),
    1.0: (0.992, 1.012),
}
"""Bounciness asked for: least and greatest found, of balls and boxes that fall flat at 0.5
to 6 m/s and touch anywhere within a step; `benchmarks/bounciness.py` measures it."""


class Touching(NamedTuple):
    """All n places at which things touch at one moment, those of one pair in a row.

    Attributes:
        things: (n, 2) numbers of the two.
        normal: (n, 9) the first three from the first to the second.
        place: (n, 3) [m].
        distance: (n,) negative where one is in the other [m].
        friction: (n, 5) the first is Coulomb's coefficient.
        size: (n,) rows of each: normal, two of sliding, more of spin and rolling.
        velocity: (m, 6) angular and linear velocities of all things in the world, at their
            centres [rad/s, m/s].
        centre: (m, 3) of all things [m].
        attitude: (m, 9) rotation matrices of all things.
    """

    things: NDArray[np.int32]
    normal: Array
    place: Array
    distance: Array
    friction: Array
    size: NDArray[np.int32]
    velocity: Array
    centre: Array
    attitude: Array


class Things(NamedTuple):
    """What stays of m things.

    Attributes:
        bounciness: (m,); of two the lower one holds.
        inverse_mass: (m,) 0 of what does not give way [1/kg].
        inverse_inertia: (m, 3, 3) in their own frames, likewise [1/(kg m²)].
        radius: (m,) of balls, 0 of what is none [m].
    """

    bounciness: Array
    inverse_mass: Array
    inverse_inertia: Array
    radius: Array


class ImpactLaw:
    """Which pairs bounce at the moment, and which rest."""

    def __init__(self, things: Things) -> None:
        self.things = things
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
            springs: (k, 4) whose first two columns become stiffness [1/s²] and damping [1/s].

        Returns:
            The places (s,) at which a bounce begins, one a pair, and the speeds (n,) at which
            all part, negative while they approach [m/s].
        """
        t, bounciness = touching, self.things.bounciness
        speed = _parting(t.things, t.normal, t.place, t.velocity, t.centre)
        self._pairs, self._onset, bounces, struck = _bouncing(
            t.things, bounciness, speed, time, h, self._pairs, self._onset
        )
        _set_springs(t, self.things, speed, bounces, h, rows, springs)
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
    """Return how fast a place of a thing goes along `n` [m/s]."""
    x, y, z = _velocity(velocity, centre, place)
    result: float = n[0] * x + n[1] * y + n[2] * z
    return result


@compiled
def _velocity(velocity: Array, centre: Array, place: Array) -> tuple[float, float, float]:
    """Return v + w × r of a place of a thing [m/s]."""
    x, y, z = place[0] - centre[0], place[1] - centre[1], place[2] - centre[2]
    return (
        velocity[3] + velocity[1] * z - velocity[2] * y,
        velocity[4] + velocity[2] * x - velocity[0] * z,
        velocity[5] + velocity[0] * y - velocity[1] * x,
    )


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
    t: Touching,
    things: Things,
    speed: Array,
    bounces: NDArray[np.bool_],
    h: float,
    rows: NDArray[np.int32],
    springs: Array,
) -> None:
    """Set stiffness and damping of all places and of all friction; see `ImpactLaw.press`."""
    w, distance, bounciness = STIFFNESS / h, t.distance, things.bounciness
    for i in range(len(rows)):
        if rows[i] < 0:
            continue
        b = min(bounciness[t.things[i, 0]], bounciness[t.things[i, 1]])
        stiffness, damping, v = w * w, 2.0 * w, speed[i]
        depth = max(-distance[i], 0.0)
        if bounces[i] and b >= DULL:
            damping = 0.0
            if v < 0.0 and v + w * w * depth * h > 0.0:
                stiffness, damping = b * b * stiffness, (1.0 - b * b) / h
            elif v >= 0.0:
                stiffness = b * b * stiffness
        elif bounces[i] and v < -REST_SPEED:
            stiffness, damping = 0.0, 1.0 / h
        elif w * depth > 2.0 * REST_SPEED:
            # A spring cannot pull: what it pushed out faster would hop.
            stiffness *= 2.0 * REST_SPEED / (w * depth)
        springs[rows[i], 0], springs[rows[i], 1] = stiffness, damping
        _set_friction(t, things, i, stiffness * depth - damping * v, w, rows[i], springs)


@entry
def impact(t: Touching, things: Things, i: int, speed: Array) -> tuple[float, float, float, float]:
    """Return where a bounce that begins at place `i` is [m], and with what energy [J].

    What lands flat touches at many corners at once: it is in their middle, and its whole
    mass counts.
    """
    x, y, z, count = 0.0, 0.0, 0.0, 0
    for j in range(len(speed)):
        same = t.things[j, 0] == t.things[i, 0] and t.things[j, 1] == t.things[i, 1]
        if same and speed[j] < 0.5 * speed[i]:
            x, y, z = x + t.place[j, 0], y + t.place[j, 1], z + t.place[j, 2]
            count += 1
    x, y, z = x / count, y / count, z / count
    n = (t.normal[i, 0], t.normal[i, 1], t.normal[i, 2])
    yields = _yields(t, things, (t.things[i, 0], t.things[i, 1]), (x, y, z), n)
    return x, y, z, 0.5 * speed[i] ** 2 / yields


@compiled
def _set_friction(
    t: Touching, things: Things, i: int, pushed: float, w: float, row: int, springs: Array
) -> None:
    """Set the damping of what slides and rolls at place `i`, which is `pushed` apart [m/s²].

    MuJoCo solves for friction and for the push together and weighs one against the other: a
    contact that is asked to stop what slides, faster than Coulomb's friction can, lifts it
    off instead. A ball of bounciness 0.5 that came at 6 m/s aslant left with 0.74 of its
    speed. So it is asked for no more than Coulomb gives.
    """
    slides = _sliding(t, i)
    speed = math.sqrt(slides[0] ** 2 + slides[1] ** 2 + slides[2] ** 2)
    damping = 2.0 * w
    if speed > 0.0:
        pair = (t.things[i, 0], t.things[i, 1])
        place = (t.place[i, 0], t.place[i, 1], t.place[i, 2])
        n = (t.normal[i, 0], t.normal[i, 1], t.normal[i, 2])
        along = (slides[0] / speed, slides[1] / speed, slides[2] / speed)
        ratio = _yields(t, things, pair, place, along)
        ratio /= max(_yields(t, things, pair, place, n), 1e-12)
        most = t.friction[i, 0] * ratio * (max(pushed, 0.0) + SPARE * GRAVITY)
        damping = min(damping, most / speed)
    for k in range(1, t.size[i]):
        springs[row + k, 1] = damping if k < 3 else ROLLING


@compiled
def _sliding(t: Touching, i: int) -> tuple[float, float, float]:
    """Return the velocity at which the second slides over the first at place `i` [m/s]."""
    a, b, n = t.things[i, 0], t.things[i, 1], t.normal[i]
    x, y, z = _velocity(t.velocity[b], t.centre[b], t.place[i])
    u, v, w = _velocity(t.velocity[a], t.centre[a], t.place[i])
    x, y, z = x - u, y - v, z - w
    along = x * n[0] + y * n[1] + z * n[2]
    return x - along * n[0], y - along * n[1], z - along * n[2]


@compiled
def _yields(t: Touching, things: Things, pair: tuple[int, int], place: Triple, n: Triple) -> float:
    """Return the speed that a unit of impulse along `n` gives two things at a place [1/kg]."""
    total = 0.0
    for side in range(2):
        g = pair[side]
        if things.inverse_mass[g] == 0.0:
            continue
        R, J = t.attitude[g], things.inverse_inertia[g]
        x, y, z = (
            place[0] - t.centre[g, 0],
            place[1] - t.centre[g, 1],
            place[2] - t.centre[g, 2],
        )
        a, b, c = y * n[2] - z * n[1], z * n[0] - x * n[2], x * n[1] - y * n[0]
        # In the frame of the body.
        u = R[0] * a + R[3] * b + R[6] * c
        v = R[1] * a + R[4] * b + R[7] * c
        w = R[2] * a + R[5] * b + R[8] * c
        total += things.inverse_mass[g]
        total += u * (J[0, 0] * u + J[0, 1] * v + J[0, 2] * w)
        total += v * (J[1, 0] * u + J[1, 1] * v + J[1, 2] * w)
        total += w * (J[2, 0] * u + J[2, 1] * v + J[2, 2] * w)
    return total


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
