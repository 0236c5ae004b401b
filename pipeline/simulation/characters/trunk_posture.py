"""Trunk posture."""

from __future__ import annotations

import math

from pipeline.simulation.characters.gait_timing import (
    cycle_of,
    eased,
    leg_of,
    pace_of,
    relative,
    running,
    speed_of,
    sprung,
    wrapped,
)
from pipeline.simulation.characters.person_record import (
    COUNT,
    HEAD,
    HIP,
    PELVIS,
    SHOULDER,
    SHOULDERS,
    SPINE,
    STANCE,
)
from pipeline.simulation.dynamics.compiled import Record, Records, compiled
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.vectors import Vector, length, minus, put, row
from pipeline.simulation.people.proportions import SEGMENTS

STRAIGHT = 0.996
"""Part of its length that a leg has at most; one that is quite straight cannot be bent."""

SWAY, SINK, ROTATE, LIST = 0.022, 0.028, math.radians(5.0), math.radians(4.0)
"""How far the pelvis goes aside and up and down, in legs; how far it turns and tilts."""

RISES = 14.0
"""How quickly somebody rises whom a leg that stood has held down [1/s]."""

SOON = 0.4
"""Left of a swing: from when on the pelvis comes down for a foot that is put far off."""

COUNTER = math.radians(6.0)
"""How far the shoulders turn against the pelvis."""

MOST_TWIST = math.radians(90.0)
"""Of the shoulders against the pelvis."""

MOST_LEAN = 1.6
"""Tangent of the lean of the trunk."""

CHEST = tuple(SEGMENTS).index("chest")
"""Which of a person's links."""

Frame = tuple[Vector, Vector, Vector]
"""Directions ahead, up and to the right."""


@compiled
def frame_of(heading: float, lean_x: float, lean_z: float, tilt: float) -> Frame:
    """Return the frame of one who looks along `heading`.

    Args:
        heading: about +Y [rad].
        lean_x: tangent of its lean in the world along x.
        lean_z: along z.
        tilt: of its right side upward [rad].
    """
    n = 1.0 / math.sqrt(1.0 + lean_x * lean_x + lean_z * lean_z)
    up = (lean_x * n, n, lean_z * n)
    c, s = math.cos(heading), math.sin(heading)
    right = (s, 0.0, c)
    along = right[0] * up[0] + right[2] * up[2]
    right = (right[0] - along * up[0], -along * up[1], right[2] - along * up[2])
    n = 1.0 / math.sqrt(right[0] ** 2 + right[1] ** 2 + right[2] ** 2)
    right = (right[0] * n, right[1] * n, right[2] * n)
    c, s = math.cos(tilt), math.sin(tilt)
    right, up = (
        (c * right[0] + s * up[0], c * right[1] + s * up[1], c * right[2] + s * up[2]),
        (c * up[0] - s * right[0], c * up[1] - s * right[1], c * up[2] - s * right[2]),
    )
    ahead = (
        up[1] * right[2] - up[2] * right[1],
        up[2] * right[0] - up[0] * right[2],
        up[0] * right[1] - up[1] * right[0],
    )
    return ahead, up, right


@compiled
def from_frame(origin: Vector, frame: Frame, x: float, y: float, z: float) -> Vector:
    """Return the place in the world of one in a frame."""
    a, u, r = frame
    return (
        origin[0] + x * a[0] + y * u[0] + z * r[0],
        origin[1] + x * a[1] + y * u[1] + z * r[1],
        origin[2] + x * a[2] + y * u[2] + z * r[2],
    )


@compiled
def turn_of(person: Record, about: float) -> float:
    """Return the cosine of the gait's clock from a phase on, once a cycle."""
    return math.cos(2.0 * math.pi * (person.phase - about))


@compiled
def hold_trunk(person: Record, nodes: Records, dt: float) -> None:
    """Say where the nodes of the trunk should be."""
    _follow_ground(person, dt)
    _, stance = pace_of(person)
    middle = 0.5 * (1.0 - stance)
    some = person.walking
    # While the left foot swings, from phase 0 on, weight is on the right one.
    aside = SWAY * leg_of(person) * some * turn_of(person, middle)
    tilt = LIST * some * turn_of(person, middle)
    rotation = -ROTATE * some * turn_of(person, 1.0 - stance)
    height = _height(person, stance, dt)
    c, s = math.cos(person.heading), math.sin(person.heading)
    back = seat_back(person)
    pelvis = (
        person.at[0] + aside * s - back * c,
        person.floor + height,
        person.at[1] + aside * c + back * s,
    )
    put(person.wanted, PELVIS, pelvis)
    frame = frame_of(person.heading + rotation, 0.0, 0.0, tilt)
    for k in range(2):
        side = person.hips if k == 1 else -person.hips
        put(person.wanted, HIP + k, from_frame(pelvis, frame, 0.0, 0.0, side))
    _lean(person, nodes, dt)
    _hold_chest(person, pelvis, rotation, dt)


@compiled
def _follow_ground(person: Record, dt: float) -> None:
    """Let the ground that somebody goes by follow what the feet stand on."""
    low = 0.5 * (person.stood[0, 1] + person.stood[1, 1]) - person.ankle
    for k in range(2):
        if person.doing[k] != STANCE:
            gone = row(person.land, k)[1] - row(person.stood, k)[1]
            low += 0.5 * gone * 0.5
    person.floor, person.floor_rate = sprung(person.floor, person.floor_rate, low, 9.0, dt)


@compiled
def _height(person: Record, stance: float, dt: float) -> float:
    """Return how high the pelvis is above the ground [m]."""
    leg, some = leg_of(person), person.walking
    bones = STRAIGHT * (person.thigh + person.shin)
    stood = person.ankle + bones
    speed = speed_of(person)
    run = running(speed, leg)
    rate, _ = pace_of(person)
    ahead = min(0.5 * speed * stance / rate - 0.42 * person.foot, 0.6 * bones)
    low = person.ankle + math.sqrt(bones * bones - max(ahead, 0.0) ** 2) + 0.012 * leg
    rise = min(0.5 * max(0.985 * stood - low, 0.0), SINK * leg)
    middle = 0.5 * (1.0 - stance)
    swing = math.cos(4.0 * math.pi * (person.phase - middle))
    walk = low + rise + rise * swing
    bounce = 0.955 * stood - 0.035 * leg * swing
    height = (1.0 - some) * stood + some * ((1.0 - run) * walk + run * bounce)
    sat = eased(person.seated)
    height = (1.0 - sat) * (height - person.crouch * leg) + sat * (person.seat[1] - person.floor)
    return _within_reach(person, height, dt)


@compiled
def _within_reach(person: Record, height: float, dt: float) -> float:
    """Return the height at which no leg that stands has to be longer than it is.

    Who was held down by a leg rises when its foot leaves the ground, and is not thrown up.
    """
    bones = 0.995 * (person.thigh + person.shin)
    most = height
    for k in range(2):
        if person.doing[k] == STANCE:
            x = person.ankles[k, 0] - person.wanted[HIP + k, 0]
            z = person.ankles[k, 2] - person.wanted[HIP + k, 2]
            away = min(x * x + z * z, 0.75 * bones * bones)
            top = person.ankles[k, 1] + math.sqrt(bones * bones - away) - person.floor
            most = min(most, top)
        else:
            most = min(most, height - _soon(person, k, height, bones))
    person.short = max(height - most, person.short * math.exp(-RISES * dt))
    held: float = height - person.short
    return held


@compiled
def _soon(person: Record, k: int, height: float, bones: float) -> float:
    """Return how much lower the pelvis is to be for a foot that is about to come down [m].

    Who sank at the moment it did would be thrown down.

    Args:
        person: whose.
        k: which foot.
        height: that the pelvis has otherwise, above the ground [m].
        bones: how long the leg may be [m].
    """
    rate, stance = pace_of(person)
    left = max(1.0 - cycle_of(person, k) / (1.0 - stance), 0.0)
    if left > SOON:
        return 0.0
    time = left * (1.0 - stance) / rate
    x = person.land[k, 0] - person.wanted[HIP + k, 0] - person.going[0] * time
    z = person.land[k, 2] - person.wanted[HIP + k, 2] - person.going[1] * time
    away = min(x * x + z * z, 0.75 * bones * bones)
    top = person.land[k, 1] + math.sqrt(bones * bones - away) - person.floor
    lower: float = max(height - top, 0.0) * eased(1.0 - left / SOON)
    return lower


@compiled
def seat_back(person: Record) -> float:
    """Return how far the pelvis is behind the feet, of one who sits or bows [m]."""
    # First back, then down: whoever folds straight down falls on their heels.
    back: float = person.seat[0] * math.sin(0.5 * math.pi * eased(person.seated))
    # Who bows or crouches keeps the balance with the hips.
    balance = 0.03 * person.height * person.bow + 0.16 * person.crouch * leg_of(person)
    # Who holds somebody leans on them.
    back += (1.0 - person.leans) * balance
    return back


@compiled
def _lean(person: Record, nodes: Records, dt: float) -> None:
    """Lean so that the centre of mass is over the feet; into a run; and into what gains speed."""
    leg, speed = leg_of(person), speed_of(person)
    run = running(speed, leg)
    per = 0.03 * min(relative(speed, leg), 0.6) + 0.16 * run
    size = max(speed, 1e-6)
    along_x, along_z = per * person.going[0] / size, per * person.going[1] / size
    along_x += 0.45 * person.gaining[0] / GRAVITY
    along_z += 0.45 * person.gaining[1] / GRAVITY
    if person.seated > 0.0:
        # Weight goes over the feet on the way, and back over the seat once there.
        on_way = 4.0 * person.seated * (1.0 - person.seated)
        c, s = math.cos(person.heading), math.sin(person.heading)
        lean = 0.62 * on_way + person.seat[2] * eased(person.seated)
        along_x, along_z = along_x + lean * c, along_z - lean * s
    elif person.bow > 0.02:
        c, s = math.cos(person.heading), math.sin(person.heading)
        along_x, along_z = along_x + person.bow * c, along_z - person.bow * s
    elif not person.stepping:
        x, z = _off_balance(person, nodes)
        along_x -= 1.2 * x / leg
        along_z -= 1.2 * z / leg
    size = max(math.hypot(along_x, along_z) / MOST_LEAN, 1.0)
    for c, wanted in ((0, along_x / size), (1, along_z / size)):
        person.lean[c], person.lean_rate[c] = sprung(
            person.lean[c], person.lean_rate[c], wanted, 5.0, dt
        )


@compiled
def _off_balance(person: Record, nodes: Records) -> tuple[float, float]:
    """Return how far the centre of mass is from over the middle of the feet [m]."""
    x = z = weight = 0.0
    for i in range(person.node, person.node + COUNT):
        node = nodes[i]
        mass = 1.0 / max(node.inverse_mass, 1e-9)
        x, z, weight = x + mass * node.p[0], z + mass * node.p[2], weight + mass
    return (
        x / weight - 0.5 * (person.stood[0, 0] + person.stood[1, 0]),
        z / weight - 0.5 * (person.stood[0, 2] + person.stood[1, 2]),
    )


@compiled
def _hold_chest(person: Record, pelvis: Vector, rotation: float, dt: float) -> None:
    """Say where spine, shoulders and head should be."""
    aside = wrapped(person.gaze[0] - person.heading)
    wanted = min(max(0.4 * aside, -MOST_TWIST), MOST_TWIST)
    person.twist, person.twist_rate = sprung(person.twist, person.twist_rate, wanted, 5.0, dt)
    counter = -rotation / ROTATE * COUNTER
    x, z = person.lean[0], person.lean[1]
    yaw = person.heading + person.twist
    belly = frame_of(person.heading + 0.5 * (rotation + counter), 0.5 * x, 0.5 * z, 0.0)
    spine = from_frame(pelvis, belly, 0.0, person.belly, 0.0)
    chest = frame_of(yaw + counter, x, z, 0.0)
    shoulders = from_frame(spine, chest, 0.0, person.chest + _breathe(person, dt), 0.0)
    put(person.wanted, SPINE, spine)
    put(person.wanted, SHOULDERS, shoulders)
    for k in range(2):
        side = person.shoulders if k == 1 else -person.shoulders
        put(person.wanted, SHOULDER + k, from_frame(shoulders, chest, 0.0, 0.0, side))
    # The neck keeps the head upright, and bends with what is looked at.
    nod = -0.35 * person.gaze[1]
    c, s = math.cos(person.gaze[0]), math.sin(person.gaze[0])
    neck = frame_of(yaw, 0.35 * x + nod * c, 0.35 * z - nod * s, 0.0)
    put(person.wanted, HEAD, from_frame(shoulders, neck, 0.0, person.neck, 0.0))


@compiled
def stretch(person: Record, links: Records, owners: Records) -> None:
    """Let the link between spine and shoulders be as long as breath has it."""
    link = owners[person.owner].links[0] + CHEST
    long = length(minus(row(person.wanted, SHOULDERS), row(person.wanted, SPINE)))
    links[link].reach[0] = links[link].reach[1] = long


@compiled
def chest_frame(person: Record) -> tuple[Vector, Frame]:
    """Return the middle of the shoulders, and the frame of the chest, as they should be."""
    _, stance = pace_of(person)
    yaw = person.heading + person.twist
    yaw += COUNTER * person.walking * turn_of(person, 1.0 - stance)
    return row(person.wanted, SHOULDERS), frame_of(yaw, person.lean[0], person.lean[1], 0.0)


@compiled
def _breathe(person: Record, dt: float) -> float:
    """Return how high the shoulders are lifted by breath [m]; the quicker the walk, the more."""
    effort = min(relative(speed_of(person), leg_of(person)), 1.2)
    person.breath = (person.breath + (0.25 + 0.45 * effort) * dt) % 1.0
    depth = (0.0035 + 0.004 * effort) * person.height
    lift: float = depth * math.sin(2.0 * math.pi * person.breath)
    return lift
