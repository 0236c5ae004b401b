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

from pipeline.simulation.dynamics.compiled import Record, Records, compiled
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.vectors import Vector, cross, dot, minus, times, triple
from pipeline.simulation.spatial import Array

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

EXACTLY = 0.999
"""What rounding leaves of what is sure."""

LONGER = 1.5
"""How long a bounce may last, in its own length by the formula."""

ALIKE = 0.999
"""Cosine between normals of one plane."""

RIM = 0.02
"""Height above a plane that is none, in radii of the ball."""

YIELDING = 1e6
"""Acceleration towards one another that is asked of what is not to push [m/s²]."""

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


THING = np.dtype(
    [
        # Of two the lower one holds.
        ("bounciness", "f8"),
        # 0 of what does not give way [1/kg]; in its own frame, likewise [1/(kg m²)].
        ("inverse_mass", "f8"),
        ("inverse_inertia", "f8", (3, 3)),
        # The most that a unit of impulse gives any place of it [1/kg].
        ("gives", "f8"),
        # Of balls, 0 of what is none [m].
        ("radius", "f8"),
        # Just now, of what touches: angular and linear velocity in the world at its centre
        # [rad/s, m/s], centre [m], rotation matrix.
        ("velocity", "f8", 6),
        ("centre", "f8", 3),
        ("attitude", "f8", 9),
    ],
    align=True,
)
"""A thing: the terrain, a body, or who pushes, in this order."""

PAIR = np.dtype([("key", "i8"), ("onset", "f8")])
"""Two things that touch, by number, and when their last bounce began [s]."""

STRIKE = np.dtype(
    [
        # Numbers of a body and of the other thing; the time in the world [s]; see `Strike`.
        ("one", "i8"),
        ("other", "i8"),
        ("time", "f8"),
        ("place", "f8", 3),
        ("normal", "f8", 3),
        ("speed", "f8"),
        ("energy", "f8"),
    ],
    align=True,
)
"""The begin of an impact."""

NOW = np.dtype(
    [
        # Length of the step [s]; how many bodies there are.
        ("h", "f8"),
        ("bodies", "i8"),
        # Whether the ground is a height field.
        ("uneven", "?"),
        # Which half of the pairs is known, how many these are, how many strikes are told.
        ("half", "i8"),
        ("known", "i8"),
        ("told", "i8"),
    ],
    align=True,
)
"""How it stands with a world."""


class Touching(NamedTuple):
    """All n places at which things touch at one moment, those of one pair in a row.

    Attributes:
        contacts: (n,) of MuJoCo: where, `dist` negative where one is in the other [m]; the
            first three of `frame` are the normal from the first to the second; `dim` rows
            from `efc_address`, negative for none: normal, two of sliding, spin and rolling.
        things: (g,) to which thing each of MuJoCo's geoms belongs.
        springs: (k, 4) of rows; the first two become stiffness [1/s²] and damping [1/s].
        depths: (k,) of rows: distances that the springs see [m].
        velocity: (m, 6) angular and linear velocities of all things in the world, at their
            centres [rad/s, m/s].
        centre: (m, 3) of all things [m].
        attitude: (m, 9) rotation matrices of all things.
    """

    contacts: Records
    things: NDArray[np.int32]
    springs: Array
    depths: Array
    velocity: Array
    centre: Array
    attitude: Array


class Law(NamedTuple):
    """Which pairs bounce at the moment, which rest, and what is known of things.

    Attributes:
        now: a `NOW`.
        things: (m,) `THING`.
        pairs: (2, room) `PAIR` of this step and of the one before, in order.
        speeds: (room,) at which places part [m/s].
        strikes: `STRIKE`, as many as there is room for.
    """

    now: Record
    things: Records
    pairs: Records
    speeds: Array
    strikes: Records


@compiled
def press(t: Touching, law: Law, time: float) -> None:
    """Set the springs for a step from `time` [s] on, and keep the bounces that begin."""
    now, contacts, speeds = law.now, t.contacts, law.speeds
    known, pairs = law.pairs[now.half], law.pairs[1 - now.half]
    n, end, count, k, ordered = len(contacts), 0, 0, 0, True
    while end < n:
        first, quickest = end, end
        a, b = _two(t, first)
        one, other = law.things[a], law.things[b]
        _look(t, a, one)
        _look(t, b, other)
        while end < n and _two(t, end) == (a, b):
            speeds[end] = _parting(contacts[end], one, other)
            if speeds[end] < speeds[quickest]:
                quickest = end
            end += 1
        key = a * len(law.things) + b
        if count > 0 and key < pairs[count - 1].key:
            k, ordered = 0, False
        while k < now.known and known[k].key < key:
            k += 1
        touched = k < now.known and known[k].key == key
        begun = known[k].onset if touched else -np.inf
        bounciness = min(one.bounciness, other.bounciness)
        bounces = time - begun < _lasts(bounciness, now.h)
        if not bounces and -speeds[quickest] > (SLAM_SPEED if touched else REST_SPEED):
            begun, bounces = time, True
            _tell(t, law, time, first, end, quickest)
        pairs[count].key, pairs[count].onset = key, begun
        count += 1
        _set_springs(t, law, first, end, bounces)
        if now.uneven and a == 0 and other.radius > 0.0 and end - first > 1:
            _let_in_beside(t, first, end, other.radius)
    if not ordered:
        _sort(pairs, count)
    now.half, now.known = 1 - now.half, count


@compiled
def _two(t: Touching, i: int) -> tuple[int, int]:
    """Return the numbers of the things that touch at a place."""
    geom = t.contacts[i].geom
    return t.things[geom[0]], t.things[geom[1]]


@compiled
def _set_springs(t: Touching, law: Law, first: int, end: int, bounces: bool) -> None:
    """Set the springs of a pair, which touches from place `first` to `end`."""
    h, speeds, (a, b) = law.now.h, law.speeds, _two(t, first)
    one, other = law.things[a], law.things[b]
    bounciness = min(one.bounciness, other.bounciness)
    for i in range(first, end):
        contact = t.contacts[i]
        row, depth = contact.efc_address, max(-contact.dist, 0.0)
        if row < 0:
            continue
        stiffness, damping = _spring(depth, speeds[i], h, bounciness, bounces)
        t.springs[row, 0], t.springs[row, 1] = stiffness, damping
        pushed = stiffness * depth - damping * speeds[i]
        sliding = _friction(contact, one, other, pushed, STIFFNESS / h)
        for k in range(1, contact.dim):
            t.springs[row + k, 1] = sliding if k < 3 else ROLLING


@compiled
def _look(t: Touching, number: int, thing: Record) -> None:
    """Note how a thing is just now."""
    for k in range(3):
        thing.centre[k] = t.centre[number, k]
    for k in range(6):
        thing.velocity[k] = t.velocity[number, k]
    for k in range(9):
        thing.attitude[k] = t.attitude[number, k]


@compiled
def _parting(contact: Record, one: Record, other: Record) -> float:
    """Return the speed along the normal at which two part at a place [m/s]."""
    n, place = triple(contact.frame), triple(contact.pos)
    return dot(n, _velocity(other, place)) - dot(n, _velocity(one, place))


@compiled
def _velocity(thing: Record, place: Vector) -> Vector:
    """Return v + w × r of a place of a thing [m/s]."""
    x, y, z = minus(place, triple(thing.centre))
    w = thing.velocity
    return (w[3] + w[1] * z - w[2] * y, w[4] + w[2] * x - w[0] * z, w[5] + w[0] * y - w[1] * x)


@compiled
def _lasts(b: float, h: float) -> float:
    """Return how long a bounce may last [s]."""
    return LONGER * 0.5 * np.pi * h / STIFFNESS * (1.0 + 1.0 / max(b, DULL))


@compiled
def _sort(pairs: Records, count: int) -> None:
    """Bring pairs in order; they nearly are."""
    for i in range(1, count):
        k, key, onset = i, pairs[i].key, pairs[i].onset
        while k > 0 and pairs[k - 1].key > key:
            pairs[k].key, pairs[k].onset = pairs[k - 1].key, pairs[k - 1].onset
            k -= 1
        pairs[k].key, pairs[k].onset = key, onset


@compiled
def _tell(t: Touching, law: Law, time: float, first: int, end: int, i: int) -> None:
    """Keep the bounce that begins at place `i`, of a pair that touches from `first` to `end`.

    What lands flat touches at many corners at once: it is in their middle, and its whole
    mass counts.
    """
    if law.now.told == len(law.strikes):
        return
    speed, place, count = law.speeds[i], (0.0, 0.0, 0.0), 0
    for j in range(first, end):
        if law.speeds[j] < 0.5 * speed:
            x, y, z = triple(t.contacts[j].pos)
            place = (place[0] + x, place[1] + y, place[2] + z)
            count += 1
    place = times(1.0 / count, place)
    (a, b), n = _two(t, i), triple(t.contacts[i].frame)
    strike = law.strikes[law.now.told]
    law.now.told += 1
    # Bodies come first, in order.
    turned = 0 < b <= law.now.bodies and (b < a or a == 0 or a > law.now.bodies)
    strike.one, strike.other = (b - 1, a - 1) if turned else (a - 1, b - 1)
    side = 1.0 if turned else -1.0
    for k in range(3):
        strike.place[k], strike.normal[k] = place[k], side * n[k]
    # It was found a little after it began.
    strike.time = time - max(-t.contacts[i].dist, 0.0) / -speed
    strike.speed = -speed
    strike.energy = 0.5 * speed**2 / _yields(law.things[a], law.things[b], place, n)


@compiled
def _spring(depth: float, v: float, h: float, b: float, bounces: bool) -> tuple[float, float]:
    """Return stiffness [1/s²] and damping [1/s] at a place that parts at `v` [m/s]."""
    w = STIFFNESS / h
    stiffness, damping = w * w, 2.0 * w
    if bounces and b >= DULL:
        damping = 0.0
        if v < 0.0 and v + w * w * depth * h > 0.0:
            stiffness, damping = b * b * stiffness, (1.0 - b * b) / h
        elif v >= 0.0:
            stiffness = b * b * stiffness
    elif bounces and v < -REST_SPEED:
        stiffness, damping = 0.0, 1.0 / h
    elif w * depth > 2.0 * REST_SPEED:
        # A spring cannot pull: what it pushed out faster would hop.
        stiffness *= 2.0 * REST_SPEED / (w * depth)
    return stiffness, damping


@compiled
def _friction(contact: Record, one: Record, other: Record, pushed: float, w: float) -> float:
    """Return the damping of what slides at a place, which is `pushed` apart [m/s²].

    MuJoCo solves for friction and for the push together and weighs one against the other: a
    contact that is asked to stop what slides, faster than Coulomb's friction can, lifts it
    off instead. A ball of bounciness 0.5 that came at 6 m/s aslant left with 0.74 of its
    speed. So it is asked for no more than Coulomb gives.
    """
    n, place, damping = triple(contact.frame), triple(contact.pos), 2.0 * w
    slides = minus(_velocity(other, place), _velocity(one, place))
    slides = minus(slides, times(dot(slides, n), n))
    speed = math.sqrt(dot(slides, slides))
    least = contact.friction[0] * (max(pushed, 0.0) + SPARE * GRAVITY)
    # Most places hardly slide, and need no exact answer.
    eases = one.inverse_mass + other.inverse_mass
    if damping * speed * (one.gives + other.gives) <= EXACTLY * least * eases:
        return damping
    ratio = _yields(one, other, place, times(1.0 / speed, slides))
    ratio /= max(_yields(one, other, place, n), 1e-12)
    result: float = min(damping, least * ratio / speed)
    return result


@compiled
def _yields(one: Record, other: Record, place: Vector, n: Vector) -> float:
    """Return the speed that a unit of impulse along `n` gives two things at a place [1/kg]."""
    return _gives(one, place, n) + _gives(other, place, n)


@compiled
def _gives(thing: Record, place: Vector, n: Vector) -> float:
    if thing.inverse_mass == 0.0:
        return 0.0
    R, J = thing.attitude, thing.inverse_inertia
    a, b, c = cross(minus(place, triple(thing.centre)), n)
    # In the frame of the body.
    u = R[0] * a + R[3] * b + R[6] * c
    v = R[1] * a + R[4] * b + R[7] * c
    w = R[2] * a + R[5] * b + R[8] * c
    total = thing.inverse_mass
    total += u * (J[0, 0] * u + J[0, 1] * v + J[0, 2] * w)
    total += v * (J[1, 0] * u + J[1, 1] * v + J[1, 2] * w)
    total += w * (J[2, 0] * u + J[2, 1] * v + J[2, 2] * w)
    result: float = total
    return result


@compiled
def _let_in_beside(t: Touching, first: int, end: int, radius: float) -> None:
    """Let a ball fall into the rim of triangles that it is not over.

    MuJoCo looks at each prism of a height field alone, so a ball that has sunk into one is
    pushed aside by its neighbours, though their surfaces lie in one plane: 0.95 m/s after an
    impact at 6 m/s. A place counts if it lies above the plane of the deepest one, or has the
    same normal; at others so much is asked to fall in that nothing pushes.

    Args:
        t: see there; the terrain comes first, normals are upward, and places are in the
            middle between both surfaces.
        first: of the places of ball and ground.
        end: of them.
        radius: of the ball [m].
    """
    deepest = first
    for i in range(first, end):
        if t.contacts[i].dist < t.contacts[deepest].dist:
            deepest = i
    up = triple(t.contacts[deepest].frame)
    ground = _ground(t, deepest)
    for i in range(first, end):
        at = t.contacts[i].efc_address
        alike = dot(up, triple(t.contacts[i].frame))
        above = dot(up, minus(_ground(t, i), ground))
        if at >= 0 and alike < ALIKE and above < RIM * radius:
            t.springs[at, 0], t.springs[at, 1], t.depths[at] = -YIELDING, 0.0, -1.0


@compiled
def _ground(t: Touching, i: int) -> Vector:
    """Return where on the ground place `i` is [m]."""
    down = times(0.5 * t.contacts[i].dist, triple(t.contacts[i].frame))
    return minus(triple(t.contacts[i].pos), down)
