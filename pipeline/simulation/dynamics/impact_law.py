"""Impact law: springs between MuJoCo bodies in contact that give the bounciness asked for.

While two bodies approach, the spring separates them with ω² d at depth d; once they part, with
b² ω² d. The spring returns b² of the energy it took, so they part at b times the speed at which
they met, whatever that speed and their masses. A damper, as contacts usually have, gives a ratio
that depends on the speed and on the depth at which the contact was found; b = 0.2 was off by
0.05, see `MEASURED_BOUNCINESS`.

Within the step of length h in which they turn, v < 0 < v + ω² d h, the approach is stopped and
b² of the rest of the push remains: a = -v (1 - b²)/h + b² ω² d. Without that, b = 0 came out as
up to 0.19.

Contacts that began below the rest speed, or have lasted longer than a bounce, are damped
critically, so that resting bodies do not jitter, however bouncy they are.

Source: Walton and Braun 1986 for springs that are softer on the way back.
"""

from __future__ import annotations

import math

import numpy as np

from pipeline.simulation.dynamics.compiled import Record, Records, compiled
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.impact_arrays import ContactSet, ImpactLaw
from pipeline.simulation.dynamics.vectors import Vector, cross, dot, minus, times, triple

STIFFNESS = 0.25
"""ω h: a larger value is less exact, a smaller one costs more sub-steps."""

REST_SPEED = 0.05
"""Approach speed below which a contact does not bounce [m/s]."""

SLAM_SPEED = 0.2
"""The same for a pair that touches already, at another corner [m/s]."""

MIN_BOUNCINESS = 0.05
"""Bounciness below which nothing is returned."""

ROLLING_DAMPING = 10.0
"""Rate at which friction stops spin and rolling [1/s]."""

SPARE_LOAD = 4.0
"""Load that a contact may carry beyond its own, in weights."""

ROUNDING_FACTOR = 0.999
"""Factor that leaves room for rounding in a sure comparison."""

MAX_BOUNCE_DURATION = 1.5
"""Longest duration of a bounce, in its duration by the formula."""

MEASURED_BOUNCINESS = {
    0.0: (0.000, 0.000),
    0.2: (0.196, 0.214),
    0.4: (0.395, 0.414),
    0.6: (0.598, 0.613),
    0.8: (0.796, 0.816),
    0.95: (0.949, 0.966),
    1.0: (0.992, 1.012),
}
"""Bounciness asked for: least and greatest found, of balls and boxes that fall flat at 0.5 to 6 m/s
and touch anywhere within a step; `benchmarks/bounciness.py` measures it."""


@compiled
def set_springs(t: ContactSet, law: ImpactLaw, time: float) -> None:
    """Sets the springs for a step from `time` [s] on, and records the bounces that begin."""
    now, contacts, speeds = law.now, t.contacts, law.speeds
    known, pairs = law.pairs[now.half], law.pairs[1 - now.half]
    n, end, count, k, ordered = len(contacts), 0, 0, 0, True
    while end < n:
        first, quickest = end, end
        a, b = _things_of(t, first)
        one, other = law.things[a], law.things[b]
        _copy_motion(t, a, one)
        _copy_motion(t, b, other)
        while end < n and _things_of(t, end) == (a, b):
            speeds[end] = _separation_speed(contacts[end], one, other)
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
        bounces = time - begun < _bounce_duration(bounciness, now.h)
        if not bounces and -speeds[quickest] > (SLAM_SPEED if touched else REST_SPEED):
            begun, bounces = time, True
            _record_impact(t, law, time, first, end, quickest)
        pairs[count].key, pairs[count].onset = key, begun
        count += 1
        _set_pair_springs(t, law, first, end, bounces)
    if not ordered:
        sort_pairs(pairs, count)
    now.half, now.known = 1 - now.half, count


@compiled
def _things_of(t: ContactSet, i: int) -> tuple[int, int]:
    """Returns the numbers of the things of a contact."""
    geom = t.contacts[i].geom
    return t.things[geom[0]], t.things[geom[1]]


@compiled
def _set_pair_springs(t: ContactSet, law: ImpactLaw, first: int, end: int, bounces: bool) -> None:
    """Sets the springs of a pair, whose contacts are `first` to `end`."""
    h, speeds, (a, b) = law.now.h, law.speeds, _things_of(t, first)
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
            t.springs[row + k, 1] = sliding if k < 3 else ROLLING_DAMPING


@compiled
def _copy_motion(t: ContactSet, number: int, thing: Record) -> None:
    """Copies the present motion of a thing."""
    for k in range(3):
        thing.centre[k] = t.centre[number, k]
    for k in range(6):
        thing.velocity[k] = t.velocity[number, k]
    for k in range(9):
        thing.attitude[k] = t.attitude[number, k]


@compiled
def _separation_speed(contact: Record, one: Record, other: Record) -> float:
    """Returns the separation speed along the normal at a contact [m/s]."""
    n, place = triple(contact.frame), triple(contact.pos)
    return dot(n, _point_velocity(other, place)) - dot(n, _point_velocity(one, place))


@compiled
def _point_velocity(thing: Record, place: Vector) -> Vector:
    """Returns v + w × r at a point of a thing [m/s]."""
    x, y, z = minus(place, triple(thing.centre))
    w = thing.velocity
    return (w[3] + w[1] * z - w[2] * y, w[4] + w[2] * x - w[0] * z, w[5] + w[0] * y - w[1] * x)


@compiled
def _bounce_duration(b: float, h: float) -> float:
    """Returns the longest duration of a bounce [s]."""
    return MAX_BOUNCE_DURATION * 0.5 * np.pi * h / STIFFNESS * (1.0 + 1.0 / max(b, MIN_BOUNCINESS))


@compiled
def sort_pairs(pairs: Records, count: int) -> None:
    """Sorts pairs, which are nearly sorted, by insertion."""
    for i in range(1, count):
        k, key, onset = i, pairs[i].key, pairs[i].onset
        while k > 0 and pairs[k - 1].key > key:
            pairs[k].key, pairs[k].onset = pairs[k - 1].key, pairs[k - 1].onset
            k -= 1
        pairs[k].key, pairs[k].onset = key, onset


@compiled
def _record_impact(
    t: ContactSet, law: ImpactLaw, time: float, first: int, end: int, i: int
) -> None:
    """Records the bounce that begins at contact `i` of a pair with contacts `first` to `end`.

    A flat landing touches at many corners at once: it is placed at their centre, and the whole mass
    counts.
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
    (a, b), n = _things_of(t, i), triple(t.contacts[i].frame)
    strike = law.strikes[law.now.told]
    law.now.told += 1
    # Bodies come first, in order.
    turned = 0 < b <= law.now.bodies and (b < a or a == 0 or a > law.now.bodies)
    strike.one, strike.other = (b - 1, a - 1) if turned else (a - 1, b - 1)
    side = 1.0 if turned else -1.0
    for k in range(3):
        strike.place[k], strike.normal[k] = place[k], side * n[k]
    # The contact was found a little after it began.
    strike.time = time - max(-t.contacts[i].dist, 0.0) / -speed
    strike.speed = -speed
    strike.energy = 0.5 * speed**2 / _pair_compliance(law.things[a], law.things[b], place, n)


@compiled
def _spring(depth: float, v: float, h: float, b: float, bounces: bool) -> tuple[float, float]:
    """Returns stiffness [1/s²] and damping [1/s] of a contact that separates at `v` [m/s]."""
    w = STIFFNESS / h
    stiffness, damping = w * w, 2.0 * w
    if bounces and b >= MIN_BOUNCINESS:
        damping = 0.0
        if v < 0.0 and v + w * w * depth * h > 0.0:
            stiffness, damping = b * b * stiffness, (1.0 - b * b) / h
        elif v >= 0.0:
            stiffness = b * b * stiffness
    elif bounces and v < -REST_SPEED:
        stiffness, damping = 0.0, 1.0 / h
    elif w * depth > 2.0 * REST_SPEED:
        # A spring cannot pull: a faster separation would hop.
        stiffness *= 2.0 * REST_SPEED / (w * depth)
    return stiffness, damping


@compiled
def _friction(contact: Record, one: Record, other: Record, pushed: float, w: float) -> float:
    """Returns the damping of sliding at a contact with normal acceleration `pushed` [m/s²].

    MuJoCo solves friction and normal force together and trades them against each other: a contact
    that must stop sliding faster than Coulomb's friction can lifts it off instead. A ball of
    bounciness 0.5 that came at 6 m/s aslant left with 0.74 of its speed. So no more than Coulomb's
    friction is asked for.
    """
    n, place, damping = triple(contact.frame), triple(contact.pos), 2.0 * w
    slides = minus(_point_velocity(other, place), _point_velocity(one, place))
    slides = minus(slides, times(dot(slides, n), n))
    speed = math.sqrt(dot(slides, slides))
    least = contact.friction[0] * (max(pushed, 0.0) + SPARE_LOAD * GRAVITY)
    # Most contacts hardly slide, and need no exact answer.
    eases = one.inverse_mass + other.inverse_mass
    if damping * speed * (one.gives + other.gives) <= ROUNDING_FACTOR * least * eases:
        return damping
    ratio = _pair_compliance(one, other, place, times(1.0 / speed, slides))
    ratio /= max(_pair_compliance(one, other, place, n), 1e-12)
    return min(damping, least * ratio / speed)


@compiled
def _pair_compliance(one: Record, other: Record, place: Vector, n: Vector) -> float:
    """Returns the speed that a unit impulse along `n` gives two things at a point [1/kg]."""
    return _compliance(one, place, n) + _compliance(other, place, n)


@compiled
def _compliance(thing: Record, place: Vector, n: Vector) -> float:
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
    return total
