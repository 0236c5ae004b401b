"""Biped gait."""

from __future__ import annotations

import math

from pipeline.simulation.characters.gait_timing import (
    cycle_of,
    eased,
    leg_of,
    pace_of,
    running,
    speed_of,
    wrapped,
)
from pipeline.simulation.characters.person_record import HIP, STANCE, SWING
from pipeline.simulation.dynamics.compiled import Record, compiled
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.grid import surface
from pipeline.simulation.dynamics.vectors import Vector, plus, put, row
from pipeline.simulation.spatial import Array

GAIN = 3.5
"""How quickly the velocity of one who walks becomes the walk vector [1/s]."""

TOLERANCE = 0.16
"""How far from below its hip a foot may stand before it steps, in legs."""

CLOSED = 0.05
"""How near it has to come, in legs, before somebody who stops stands."""

EVEN = 0.6
"""How far from below its hip, of what it may, a foot stands at most of one whose feet are side by
side: the weight shifts over them."""

AWRY = math.radians(28.0)
"""How much a foot may be turned away from the pelvis before it steps."""

MOVING = 0.03
"""Below this speed nobody walks, as a part of √(g l) [m/s at 1 m]."""

ROLL = 0.55
"""Of a stance: when the heel comes off the ground, at the earliest."""

HEEL = math.radians(48.0)
"""How far a foot turns about its ball until it leaves the ground, at most."""

BESIDE = 1.16
"""How far beside the other foot one comes down at least, on its own side, and passes it, in halves
of hips: who set one before the other, stepping aside, would catch one leg with the other. That is
as near as the shins can be, and as the feet of those who walk are."""

PASSES = 3.0
"""How far ahead of the other foot, and behind it, a foot begins to keep to its own side, in what
it keeps off."""

CLOSE = 2.5
"""How near another foot is, in what feet keep off one another, towards which no heel rises."""

GOES_ROUND = 0.25
"""Of a swing: within which a foot goes to its own side, from wherever it stood. The way ahead has
hardly begun by then: a leg that leans over the other has to be out of its way first."""

SETTLES = 16.0
"""How quickly a foot in the air goes by a change of mind [1/s]."""

TOES = math.radians(16.0)
"""How far the toes point up when the heel comes down."""


@compiled
def home(person: Record, k: int, x: float, z: float, heading: float) -> tuple[float, float]:
    """Return the place below hip k of one whose pelvis is at x, z."""
    narrow = person.hips * (1.0 - 0.42 * person.walking)
    aside = narrow if k == 1 else -narrow
    return x + aside * math.sin(heading), z + aside * math.cos(heading)


@compiled
def astray(person: Record, k: int) -> float:
    """Return how far from below its hip a foot stands; 1 is as far as it may."""
    x, z = home(person, k, person.at[0], person.at[1], person.heading)
    away = math.hypot(person.stood[k, 0] - x, person.stood[k, 2] - z)
    turned = abs(wrapped(person.yaw[k] - person.heading))
    return max(away / (TOLERANCE * leg_of(person)), turned / AWRY)


@compiled
def tread(person: Record, frame: Record, vertices: Array, dt: float) -> None:
    """Go on with both feet by one sub-step.

    Args:
        person: whose.
        frame: of the terrain's grid.
        vertices: of it.
        dt: the sub-step [s].
    """
    leg = leg_of(person)
    speed = speed_of(person)
    rate, stance = pace_of(person)
    walks = speed > MOVING * math.sqrt(GRAVITY * leg)
    if not person.stepping:
        _begin(person, walks)
    if person.stepping:
        before = person.phase
        person.phase = (before + rate * dt) % 1.0
    for k in range(2):
        if person.doing[k] == SWING:
            _swing(person, k, (rate, stance, dt), frame, vertices)
        elif person.stepping and _is_due(person, k, rate * dt, walks):
            _lift(person, k, frame, vertices)
        if person.doing[k] == STANCE:
            _stand(person, k, stance, frame, vertices)
    still = person.doing[0] == STANCE and person.doing[1] == STANCE and not walks
    if person.stepping and still:
        person.stepping = not _is_closed(person)


@compiled
def _is_closed(person: Record) -> bool:
    """Tell whether both feet stand well enough for one who has stopped.

    Side by side is enough: who waited until the pelvis had come to rest over them would mark
    time after it.
    """
    leg, near = leg_of(person), CLOSED / TOLERANCE
    x = 0.5 * (person.stood[0, 0] + person.stood[1, 0])
    z = 0.5 * (person.stood[0, 2] + person.stood[1, 2])
    for k in range(2):
        to_x, to_z = home(person, k, x, z, person.heading)
        away = math.hypot(person.stood[k, 0] - to_x, person.stood[k, 2] - to_z)
        turned = abs(wrapped(person.yaw[k] - person.heading))
        if away > CLOSED * leg or turned > near * AWRY or astray(person, k) > EVEN:
            return False
    return True


@compiled
def _begin(person: Record, walks: bool) -> None:
    """Let the clock go on where that foot is due which stands worse."""
    worse = [astray(person, 0), astray(person, 1)]
    if walks or max(worse[0], worse[1]) > 1.0:
        first = 0 if worse[0] >= worse[1] else 1
        person.stepping = True
        # Due when the clock has gone on.
        person.phase = (1.0 - 1e-9 - 0.5 * first) % 1.0


@compiled
def _is_due(person: Record, k: int, gone: float, walks: bool) -> bool:
    """Tell whether a foot leaves the ground: its turn has come, and it stands too far off."""
    turn = cycle_of(person, k) < gone + 1e-12
    return turn and (walks or astray(person, k) > CLOSED / TOLERANCE)


@compiled
def _lift(person: Record, k: int, frame: Record, vertices: Array) -> None:
    """Let a foot leave the ground."""
    person.doing[k] = SWING
    person.left[k] = person.ankles[k]
    person.yaw_left[k] = person.yaw[k]
    person.pitch_left[k] = person.pitch[k]
    person.way_left[k] = person.heading
    other = _other(person, k)
    person.pivot[k, 0], person.pivot[k, 1] = other[0], other[2]
    person.arch[k] = 0.0
    _aim(person, k, 1.0, 1.0, frame, vertices)


@compiled
def _aim(person: Record, k: int, left: float, share: float, frame: Record, vertices: Array) -> None:
    """Choose where a foot is to land.

    Args:
        person: whose.
        k: which foot.
        left: of its swing, 1 to 0.
        share: of a change of mind that is taken over now: a foot in the air that went there at
            once would strike what is beside it.
        frame: of the terrain's grid.
        vertices: of it.
    """
    rate, stance = pace_of(person)
    time = left * (1.0 - stance) / rate
    # For the weight is not on it alone before the other one leaves the ground.
    shared = max(stance - 0.5, 0.0) / rate
    heading = person.heading + person.turning * (time + shared)
    while_gaining = (1.0 - math.exp(-GAIN * time)) / GAIN
    vx = person.going[0] + person.gaining[0] * while_gaining
    vz = person.going[1] + person.gaining[1] * while_gaining
    x = person.at[0] + 0.5 * (person.going[0] + vx) * time
    z = person.at[1] + 0.5 * (person.going[1] + vz) * time
    x, z = home(person, k, x, z, heading)
    # Weight goes from heel to toes, so the ankle is behind the middle of the stance.
    back = (0.35 + 0.25 * running(speed_of(person), leg_of(person))) * person.foot * person.walking
    ahead = 0.5 * stance / rate
    x += vx * ahead - back * math.cos(heading)
    z += vz * ahead + back * math.sin(heading)
    x, z = _beside(person, k, x, z, heading)
    x = person.land[k, 0] + share * (x - person.land[k, 0])
    z = person.land[k, 2] + share * (z - person.land[k, 2])
    y, _ = surface(frame, vertices, x, z)
    person.land[k, 0], person.land[k, 1], person.land[k, 2] = x, y + person.ankle, z
    person.yaw_land[k] += share * wrapped(heading - person.yaw_land[k])
    _arch(person, k, frame, vertices)


@compiled
def _other(person: Record, k: int) -> Vector:
    """Return where the ankle of the foot that is not k stands, or is to stand."""
    return row(person.stood, 1 - k) if person.doing[1 - k] == STANCE else row(person.land, 1 - k)


@compiled
def _beside(person: Record, k: int, x: float, z: float, heading: float) -> tuple[float, float]:
    """Return a place for foot k that is on its own side of the other one."""
    other = _other(person, k)
    right_x, right_z = math.sin(heading), math.cos(heading)
    side = 1.0 if k == 1 else -1.0
    beside = side * ((x - other[0]) * right_x + (z - other[2]) * right_z)
    more = side * max(BESIDE * person.hips - beside, 0.0)
    return x + more * right_x, z + more * right_z


@compiled
def _arch(person: Record, k: int, frame: Record, vertices: Array) -> None:
    """Raise the arch of a swing until the foot clears the ground on its way."""
    a, b = row(person.left, k), row(person.land, k)
    run = running(speed_of(person), leg_of(person))
    clear = (0.035 + 0.02 * person.walking + 0.13 * run) * leg_of(person)
    for i in range(1, 6):
        u = i / 6.0
        x, y, z = a[0] + u * (b[0] - a[0]), a[1] + u * (b[1] - a[1]), a[2] + u * (b[2] - a[2])
        ground, _ = surface(frame, vertices, x, z)
        need = (ground + person.ankle + 0.5 * clear - y) / (4.0 * u * (1.0 - u))
        clear = max(clear, need)
    person.arch[k] = max(person.arch[k], min(clear, 0.6 * leg_of(person)))


@compiled
def reached(u: float) -> float:
    """Return how far along its line a foot is, going as smoothly as it can.

    Source: Flash and Hogan 1985.
    """
    return u * u * u * (10.0 + u * (6.0 * u - 15.0))


@compiled
def _round(person: Record, k: int, end: Vector, u: float, s: float) -> tuple[float, float]:
    """Return where a foot is on its way round the other leg.

    Seen by the pelvis, which turns over the other foot meanwhile, its way is straight; where it
    would lead through that leg, or past it on the wrong side, it bends outward.

    Args:
        person: whose.
        k: which foot.
        end: where its ankle comes down.
        u: of its time that is over, 0 to 1.
        s: of its way that is done, 0 to 1.
    """
    at_x, at_z, from_heading = person.pivot[k, 0], person.pivot[k, 1], person.way_left[k]
    turn = wrapped(person.yaw_land[k] - from_heading)
    a, b = _seen(person.left[k, 0] - at_x, person.left[k, 2] - at_z, from_heading)
    c, d = _seen(end[0] - at_x, end[2] - at_z, from_heading + turn)
    x, z = a + s * (c - a), b + s * (d - b)
    side = 1.0 if k == 1 else -1.0
    heading = from_heading + s * turn
    room = BESIDE * person.hips
    near = max(1.0 - (x / (PASSES * room)) ** 2, 0.0)
    keeps = room + max(side * _leans(person, 1 - k, heading), 0.0) * eased((1.0 - u) / GOES_ROUND)
    # At its begin it may be anywhere.
    more = max(keeps * near * near - side * z, 0.0) * eased(u / GOES_ROUND)
    z += side * more
    cos, sin = math.cos(heading), math.sin(heading)
    return at_x + x * cos + z * sin, at_z - x * sin + z * cos


@compiled
def _leans(person: Record, k: int, heading: float) -> float:
    """Return how far a leg is to the right of its foot where the other foot passes it [m]."""
    foot, hip = row(person.ankles, k), row(person.wanted, HIP + k)
    up: float = max(person.ankles[1 - k, 1] - foot[1], 0.0) / leg_of(person)
    _, right = _seen(hip[0] - foot[0], hip[2] - foot[2], heading)
    return up * right


@compiled
def _seen(x: float, z: float, heading: float) -> tuple[float, float]:
    """Return how far ahead and to the right a place is for one who looks along a heading."""
    cos, sin = math.cos(heading), math.sin(heading)
    return x * cos - z * sin, x * sin + z * cos


@compiled
def _swing(
    person: Record, k: int, pace: tuple[float, float, float], frame: Record, vertices: Array
) -> None:
    """Move a foot through the air, and put it down at the end.

    Args:
        person: whose.
        k: which foot.
        pace: cycles a second, the part of a cycle for which a foot stands, the sub-step [s].
        frame: of the terrain's grid.
        vertices: of it.
    """
    rate, stance, dt = pace
    u = cycle_of(person, k) / (1.0 - stance)
    if u >= 1.0:
        person.doing[k] = STANCE
        person.landed[k] += 1
        person.landed_at[k] = person.since
        person.landing[k] = 3.0 * person.arch[k] * rate / (1.0 - stance)
        person.stood[k] = person.land[k]
        person.yaw[k] = person.yaw_land[k]
        return
    if u < 0.75:
        _aim(person, k, 1.0 - u, 1.0 - math.exp(-SETTLES * dt), frame, vertices)
    s = reached(u)
    toes = TOES * person.walking * (1.0 - running(speed_of(person), leg_of(person)))
    land = row(person.land, k)
    slope = incline(frame, vertices, land, person.yaw_land[k])
    end = plus(land, on_ground(person, person.yaw_land[k], toes, slope))
    person.ankles[k, 0], person.ankles[k, 2] = _round(person, k, end, u, s)
    person.ankles[k, 1] = (1.0 - s) * person.left[k, 1] + s * end[1]
    # Level at both ends: a foot that falls to the ground bumps, and one that is torn off it jerks.
    person.ankles[k, 1] += 16.0 * person.arch[k] * (u * (1.0 - u)) ** 2
    person.yaw[k] = person.yaw_left[k] + s * wrapped(person.yaw_land[k] - person.yaw_left[k])
    turn = eased(u / 0.8)
    person.pitch[k] = (1.0 - turn) * person.pitch_left[k] + turn * toes


@compiled
def _stand(person: Record, k: int, stance: float, frame: Record, vertices: Array) -> None:
    """Keep a foot where it is, and turn it about its heel or its ball."""
    done = (cycle_of(person, k) - (1.0 - stance)) / stance if person.stepping else 0.3
    done = min(max(done, 0.0), 1.0)
    rise = HEEL * min(person.walking, 1.0) * eased((done - ROLL) / (1.0 - ROLL) * 0.5) * 2.0
    rise *= 1.0 - _bars(person, k)
    wanted = -rise if person.stepping else 0.0
    if done < ROLL:
        wanted = 0.0
        down = 0.06 if person.stepping else 1.0
        person.pitch[k] *= 1.0 - eased(min(done / down, 1.0)) * 0.25
    else:
        person.pitch[k] = wanted
    stood = row(person.stood, k)
    slope = incline(frame, vertices, stood, person.yaw[k])
    moved = on_ground(person, person.yaw[k], person.pitch[k], slope)
    put(person.ankles, k, plus(stood, moved))


@compiled
def _bars(person: Record, k: int) -> float:
    """Return how much the other leg is where the heel of a foot would bring its own, 0 to 1.

    An ankle goes ahead as its heel rises. Over a foot from which its owner has turned away that is
    across, and towards the other leg.
    """
    other = _other(person, k)
    x, z = other[0] - person.stood[k, 0], other[2] - person.stood[k, 2]
    away = max(math.hypot(x, z), 1e-9)
    ahead, _ = _seen(x, z, person.yaw[k])
    near = (CLOSE - away / (BESIDE * person.hips)) / (CLOSE - 1.0)
    return max(ahead / away, 0.0) * eased(near)


@compiled
def incline(frame: Record, vertices: Array, place: Vector, yaw: float) -> float:
    """Return how steep the ground is along a foot, upward [rad]."""
    _, n = surface(frame, vertices, place[0], place[2])
    return math.atan2(n[2] * math.sin(yaw) - n[0] * math.cos(yaw), n[1])


@compiled
def on_ground(person: Record, yaw: float, pitch: float, slope: float) -> Vector:
    """Return how an ankle moves when its foot turns about its ball or its heel.

    Args:
        person: whose.
        yaw: of the foot [rad].
        pitch: by which it is turned from lying flat, toes up [rad].
        slope: of the ground that it lies on, see `incline`.
    """
    c, s = math.cos(pitch), math.sin(pitch)
    ahead = person.ball if pitch < 0.0 else person.ball - 0.72 * person.foot
    # The ankle from the pivot is (-ahead, ankle); toes up is positive.
    x = -ahead * c - person.ankle * s + ahead
    y = -ahead * s + person.ankle * c - person.ankle
    c, s = math.cos(slope), math.sin(slope)
    x, y = c * x - s * y, s * x + c * y
    return (x * math.cos(yaw), y, -x * math.sin(yaw))
