"""Trunk posture: targets of pelvis, spine, shoulders and head, from what the legs do.

- The pelvis stands at standing height over the feet (`pelvis_motion`). In walking it rises over
  each standing leg and sinks between them, sways over the stance foot, and turns its forward hip
  with the forward leg; in running it is lowest where the leg bears most.
- An idly standing person shifts its weight from leg to leg, and a little forwards and back; the
  free hip sinks.
- The shoulders shift until the centre of mass is over the feet; running and
  acceleration lean it forward.
- The pelvis turns with the path, the shoulders towards the gaze target, at most 90 degrees more.

Rotations are yaw about Y, then lean; letters as in `spatial`.

Source: Horswill 2008, "Low-level character control"; Perlin 1995 for breath; Winter 2009, chapter
on kinematics, for how much a pelvis sways and sinks; Duarte and Zatsiorsky 1999, "Patterns of
center of pressure migration during prolonged unconstrained standing", for weight shifts.
"""

from __future__ import annotations

import math

from pipeline.simulation.characters.gait_timing import (
    froude,
    gait_pace,
    ground_speed,
    leg_length,
    leg_phase,
    run_blend,
    smoothstep,
    spring_step,
    wrap_angle,
)
from pipeline.simulation.characters.person_record import (
    FOOT,
    HEAD,
    HIP,
    KNEE,
    NODE_COUNT,
    PELVIS,
    PLACED,
    SHOULDER,
    SHOULDERS,
    SPINE,
    STANCE,
    STANDING,
)
from pipeline.simulation.dynamics.compiled import Record, Records, compiled
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.vectors import Vector, hypotenuse, length, minus, put, row
from pipeline.simulation.people.proportions import SEGMENTS

MAX_LEG_STRETCH = 0.996  # of its length; a quite straight leg cannot be bent
# Less of it in walking, and still less in running: muscles let a pelvis come a little above its
# place, and a knee that straightens quite has no direction.
WALKING_SLACK, RUNNING_SLACK = 0.002, 0.006

# The pelvis in walking: sideways and vertical amplitude in leg lengths, rotation and tilt.
SWAY, BOB = 0.022, 0.028
PELVIS_ROTATION, PELVIS_TILT = math.radians(5.0), math.radians(4.0)
RISE_RATE = 14.0  # at which the pelvis rises once no stance leg holds it down [1/s]
EARLY_LOWERING = 0.4  # remaining swing from which the pelvis comes down for a far landing place

# Weight shifts in standing. Lengths in leg lengths; the rate in √(g / l): 6 s for an adult.
SHIFT_RATE, SHIFT_BLEND_RATE = 0.05, 3.0
SHIFT_ASIDE, SHIFT_AHEAD = 0.04, 0.014
SHIFT_TILT = math.radians(1.5)  # of the pelvis, the free hip down
STEPPING_BLEND = 0.1  # of walking, up to which a person steps in place
SLIGHT_BOW = 0.2  # up to which a person shifts its weight, such as a rider that holds a post
BUSY_SHIFT = 0.7  # of a weight shift with the hands at work, in one with free hands
HUG_SHIFT = 0.5  # the same of one that bends down in a hug: the two rock a little
FEARFUL_SHIFT = 0.6  # the same of one that stands still in fear
DRIFT_PERIODS = 2.44  # of the slow drift that makes no two shifts alike, in shifts

SHOULDER_ROTATION = math.radians(6.0)  # against the pelvis
MAX_TWIST = math.radians(90.0)  # of the shoulders against the pelvis
REACHING_TWIST = math.radians(20.0)  # of them towards one hand that reaches down, at a bow of 1
MAX_LEAN = 1.6  # tangent of the trunk's lean

CHEST_LINK = tuple(SEGMENTS).index("chest")  # among the links of a person

Frame = tuple[Vector, Vector, Vector]
"""Directions ahead, up and to the right."""


@compiled
def trunk_frame(heading: float, lean_x: float, lean_z: float, tilt: float) -> Frame:
    """Return the frame of a trunk that faces a heading.

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
    if tilt != 0.0:
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
def place_in_world(origin: Vector, frame: Frame, x: float, y: float, z: float) -> Vector:
    """Return the place in the world of a place in a frame."""
    a, u, r = frame
    return (
        origin[0] + x * a[0] + y * u[0] + z * r[0],
        origin[1] + x * a[1] + y * u[1] + z * r[1],
        origin[2] + x * a[2] + y * u[2] + z * r[2],
    )


@compiled
def phase_cosine(person: Record, start: float) -> float:
    """Return the cosine of the gait phase after a given phase, once a cycle."""
    return math.cos(2.0 * math.pi * (person.phase - start))


@compiled
def hold_trunk(person: Record, nodes: Records, dt: float) -> None:
    """Set the targets of the trunk's nodes."""
    _follow_ground(person, dt)
    stance = person.duty
    middle = 0.5 * (1.0 - stance)
    walking = person.walk_blend
    # While the left foot swings, from phase 0 on, weight is on the right one.
    leg = leg_length(person)
    sway = SWAY * leg * walking * phase_cosine(person, middle)
    tilt = PELVIS_TILT * walking * phase_cosine(person, middle)
    rotation = -PELVIS_ROTATION * walking * phase_cosine(person, 1.0 - stance)
    aside, ahead = _weight_shift(person, dt)
    sway += SHIFT_ASIDE * leg * aside
    tilt += SHIFT_TILT * aside
    c, s = math.cos(person.heading), math.sin(person.heading)
    backward = backward_shift(person) - SHIFT_AHEAD * leg * ahead
    x, z = person.at[0] + sway * s - backward * c, person.at[1] + sway * c + backward * s
    pelvis = (x, person.targets[PELVIS, 1], z)
    put(person.targets, PELVIS, pelvis)
    frame = trunk_frame(person.heading + rotation, 0.0, 0.0, tilt)
    for k in range(2):
        side = person.hips if k == 1 else -person.hips
        put(person.targets, HIP + k, place_in_world(pelvis, frame, 0.0, 0.0, side))
    # As high as legs reach from where the hips are now.
    rise = person.floor + _pelvis_height(person, stance, dt) - pelvis[1]
    pelvis = (x, pelvis[1] + rise, z)
    put(person.targets, PELVIS, pelvis)
    for k in range(2):
        person.targets[HIP + k, 1] += rise
    _lean(person, nodes, dt)
    _hold_chest(person, pelvis, rotation, dt)


@compiled
def _weight_shift(person: Record, dt: float) -> tuple[float, float]:
    """Return the weight shift of a standing person to the right and ahead, each -1 to 1.

    There is none while the person walks (steps in place are not walking), sits, bows low outside a
    hug or kicks, and less with the hands at work.
    """
    is_idle = (
        person.walk_blend < STEPPING_BLEND
        and person.posture == STANDING
        and person.sit_blend == 0.0
        and person.kick_foot < 0
        and (person.bow < SLIGHT_BOW or person.stoop_depth > 0.0)
    )
    free = person.arm_mode[0] < PLACED and person.arm_mode[1] < PLACED
    share = HUG_SHIFT if person.bow >= SLIGHT_BOW else 1.0 if free else BUSY_SHIFT
    target = share if is_idle else 0.0
    if person.frozen:
        target = FEARFUL_SHIFT
    person.shift_blend, person.shift_blend_rate = spring_step(
        person.shift_blend,
        person.shift_blend_rate,
        target,
        SHIFT_BLEND_RATE,
        dt,
    )
    person.shift_phase += SHIFT_RATE * math.sqrt(GRAVITY / leg_length(person)) * dt
    angle = 2.0 * math.pi * person.shift_phase
    slow = math.sin(angle / DRIFT_PERIODS)
    aside = 0.75 * math.sin(angle) + 0.25 * slow
    ahead = math.sin(0.5 * angle + slow)
    return person.shift_blend * aside, person.shift_blend * ahead


@compiled
def sway_in_place(person: Record, dt: float) -> None:
    """Let a person that stands still in fear sway on its feet.

    Source: Roelofs, Hagenaars and Stins 2010 (freezing reduces body sway, and does not end it).
    """
    is_standing = person.posture == STANDING and person.sit_blend == 0.0 and person.kick_foot < 0
    if not (person.fearful and is_standing):
        return
    before = _shift_in_world(person, 0.0)
    after = _shift_in_world(person, dt)
    for k in range(FOOT):
        share = 0.5 if k == KNEE or k == KNEE + 1 else 1.0
        person.targets[k, 0] += share * (after[0] - before[0])
        person.targets[k, 2] += share * (after[1] - before[1])


@compiled
def _shift_in_world(person: Record, dt: float) -> tuple[float, float]:
    """Return x and z of the weight shift of a standing person after `dt` [s] [m]."""
    aside, ahead = _weight_shift(person, dt)
    aside, ahead = SHIFT_ASIDE * aside, SHIFT_AHEAD * ahead
    leg, c, s = leg_length(person), math.cos(person.heading), math.sin(person.heading)
    return leg * (ahead * c + aside * s), leg * (aside * c - ahead * s)


@compiled
def _follow_ground(person: Record, dt: float) -> None:
    target = 0.5 * (person.stance_place[0, 1] + person.stance_place[1, 1]) - person.ankle
    for k in range(2):
        if person.foot_state[k] != STANCE:
            rise = row(person.landing_place, k)[1] - row(person.stance_place, k)[1]
            target += 0.5 * rise * 0.5
    person.floor, person.floor_rate = spring_step(person.floor, person.floor_rate, target, 9.0, dt)


@compiled
def _pelvis_height(person: Record, stance: float, dt: float) -> float:
    """Return the height of the pelvis above the ground [m]."""
    leg, walking = leg_length(person), person.walk_blend
    leg_bones = MAX_LEG_STRETCH * (person.thigh + person.shin)
    standing = person.ankle + leg_bones
    speed = ground_speed(person)
    running = run_blend(speed, leg)
    rate, _ = gait_pace(person)
    half_stride = min(0.5 * speed * stance / rate - 0.42 * person.foot, 0.6 * leg_bones)
    lowest = (
        person.ankle + math.sqrt(leg_bones * leg_bones - max(half_stride, 0.0) ** 2) + 0.012 * leg
    )
    rise = min(0.5 * max(0.985 * standing - lowest, 0.0), BOB * leg)
    middle = 0.5 * (1.0 - stance)
    bob = math.cos(4.0 * math.pi * (person.phase - middle))
    walk_height = lowest + rise + rise * bob
    run_height = 0.955 * standing - 0.035 * leg * bob
    height = (1.0 - walking) * standing + walking * (
        (1.0 - running) * walk_height + running * run_height
    )
    sitting = smoothstep(person.sit_blend)
    height = (1.0 - sitting) * (height - person.crouch * leg) + sitting * (
        person.seat[1] - person.floor
    )
    return _within_reach(person, height, dt)


@compiled
def _within_reach(person: Record, height: float, dt: float) -> float:
    """Return the height at which no stance leg is longer than it can be.

    When the leg that held the pelvis down swings, the pelvis rises smoothly.
    """
    running = run_blend(ground_speed(person), leg_length(person))
    stretch = MAX_LEG_STRETCH - person.walk_blend * (WALKING_SLACK + RUNNING_SLACK * running)
    leg_bones = stretch * (person.thigh + person.shin)
    highest = height
    for k in range(2):
        if person.foot_state[k] == STANCE:
            x = person.ankles[k, 0] - person.targets[HIP + k, 0]
            z = person.ankles[k, 2] - person.targets[HIP + k, 2]
            away = min(x * x + z * z, 0.75 * leg_bones * leg_bones)
            top = person.ankles[k, 1] + math.sqrt(leg_bones * leg_bones - away) - person.floor
            highest = min(highest, top - _hip_rise(person, k))
        else:
            highest = min(highest, height - _early_lowering(person, k, height, leg_bones))
    person.pelvis_drop = max(height - highest, person.pelvis_drop * math.exp(-RISE_RATE * dt))
    return height - person.pelvis_drop


@compiled
def _hip_rise(person: Record, k: int) -> float:
    """Return the height of a hip above the middle of the tilted pelvis [m]."""
    rise: float = person.targets[HIP + k, 1] - person.targets[PELVIS, 1]
    return rise


@compiled
def _early_lowering(person: Record, k: int, height: float, bones: float) -> float:
    """Return the lowering of a pelvis at a height for a foot that soon lands far off [m].

    Sinking at touchdown would be a drop. Legs are at most as long as their bones.
    """
    if k == person.kick_foot:
        # It has still the landing place of its last step.
        return 0.0
    rate, stance = gait_pace(person)
    left = max(1.0 - leg_phase(person, k) / (1.0 - stance), 0.0)
    if left > EARLY_LOWERING:
        return 0.0
    time = left * (1.0 - stance) / rate
    x = person.landing_place[k, 0] - person.targets[HIP + k, 0] - person.velocity[0] * time
    z = person.landing_place[k, 2] - person.targets[HIP + k, 2] - person.velocity[1] * time
    away = min(x * x + z * z, 0.75 * bones * bones)
    top = person.landing_place[k, 1] + math.sqrt(bones * bones - away) - person.floor
    top -= _hip_rise(person, k)
    return max(height - top, 0.0) * smoothstep(1.0 - left / EARLY_LOWERING)


@compiled
def backward_shift(person: Record) -> float:
    """Return how far behind the feet the pelvis is in sitting and bowing [m]."""
    # First back, then down: folding straight down would fall on the heels.
    backward: float = person.seat[0] * math.sin(0.5 * math.pi * smoothstep(person.sit_blend))
    # The hips balance a bow or a crouch.
    balance = 0.03 * person.height * person.bow + 0.16 * person.crouch * leg_length(person)
    # In an embrace the person leans on the partner instead.
    backward += (1.0 - person.embrace_lean) * balance
    return backward


@compiled
def _lean(person: Record, nodes: Records, dt: float) -> None:
    """Lean to balance over the feet, into a run, and into acceleration."""
    leg, speed = leg_length(person), ground_speed(person)
    speed_lean = 0.03 * min(froude(speed, leg), 0.6) + 0.16 * run_blend(speed, leg)
    size = max(speed, 1e-6)
    along_x, along_z = (
        speed_lean * person.velocity[0] / size,
        speed_lean * person.velocity[1] / size,
    )
    along_x += 0.45 * person.acceleration[0] / GRAVITY
    along_z += 0.45 * person.acceleration[1] / GRAVITY
    # A turning deck carries inward all the time.
    inward = 0.45 * person.carry_turn * person.carry_turn / GRAVITY
    along_x += inward * (person.deck_middle[0] - person.at[0])
    along_z += inward * (person.deck_middle[2] - person.at[1])
    along_x += person.brace * math.cos(person.heading)
    along_z -= person.brace * math.sin(person.heading)
    if person.sit_blend > 0.0:
        # Weight goes over the feet on the way, and back over the seat once there.
        halfway = 4.0 * person.sit_blend * (1.0 - person.sit_blend)
        c, s = math.cos(person.heading), math.sin(person.heading)
        lean = 0.62 * halfway + person.seat[2] * smoothstep(person.sit_blend)
        along_x, along_z = along_x + lean * c, along_z - lean * s
    elif person.bow > 0.02:
        c, s = math.cos(person.heading), math.sin(person.heading)
        along_x, along_z = along_x + person.bow * c, along_z - person.bow * s
    elif not person.stepping:
        x = z = weight = 0.0
        for i in range(person.node, person.node + NODE_COUNT):
            node = nodes[i]
            mass = 1.0 / max(node.inverse_mass, 1e-9)
            x, z, weight = x + mass * node.p[0], z + mass * node.p[2], weight + mass
        x, z = (
            x / weight - 0.5 * (person.stance_place[0, 0] + person.stance_place[1, 0]),
            z / weight - 0.5 * (person.stance_place[0, 2] + person.stance_place[1, 2]),
        )
        along_x -= 1.2 * x / leg
        along_z -= 1.2 * z / leg
    size = max(hypotenuse(along_x, along_z) / MAX_LEAN, 1.0)
    for c, target in ((0, along_x / size), (1, along_z / size)):
        person.lean[c], person.lean_rate[c] = spring_step(
            person.lean[c], person.lean_rate[c], target, 5.0, dt
        )


@compiled
def _hold_chest(person: Record, pelvis: Vector, rotation: float, dt: float) -> None:
    gaze_yaw = wrap_angle(person.gaze[0] - person.heading)
    twist_target = 0.4 * gaze_yaw + _reaching_twist(person)
    twist_target = min(max(twist_target, -MAX_TWIST), MAX_TWIST)
    person.twist, person.twist_rate = spring_step(
        person.twist, person.twist_rate, twist_target, 5.0, dt
    )
    counter_rotation = -rotation / PELVIS_ROTATION * SHOULDER_ROTATION
    x, z = person.lean[0], person.lean[1]
    yaw = person.heading + person.twist
    belly = trunk_frame(person.heading + 0.5 * (rotation + counter_rotation), 0.5 * x, 0.5 * z, 0.0)
    spine = place_in_world(pelvis, belly, 0.0, person.belly, 0.0)
    chest = trunk_frame(yaw + counter_rotation, x, z, 0.0)
    shoulders = place_in_world(spine, chest, 0.0, person.chest + _breath_lift(person, dt), 0.0)
    put(person.targets, SPINE, spine)
    put(person.targets, SHOULDERS, shoulders)
    for k in range(2):
        side = person.shoulders if k == 1 else -person.shoulders
        put(person.targets, SHOULDER + k, place_in_world(shoulders, chest, 0.0, 0.0, side))
    # The neck keeps the head upright, and bends with the gaze.
    nod = -0.35 * person.gaze[1]
    c, s = math.cos(person.gaze[0]), math.sin(person.gaze[0])
    neck = trunk_frame(yaw, 0.35 * x + nod * c, 0.35 * z - nod * s, 0.0)
    put(person.targets, HEAD, place_in_world(shoulders, neck, 0.0, person.neck, 0.0))


@compiled
def _reaching_twist(person: Record) -> float:
    """Return the twist that brings the shoulder of one hand that reaches down ahead and lower."""
    is_left, is_right = person.arm_mode[0] == PLACED, person.arm_mode[1] == PLACED
    if is_left == is_right or person.sit_blend > 0.0:
        return 0.0
    twist: float = REACHING_TWIST * person.bow
    return twist if is_right else -twist


@compiled
def stretch_chest(person: Record, links: Records, owners: Records) -> None:
    """Set the length of the chest link to what breath makes it."""
    link = owners[person.owner].links[0] + CHEST_LINK
    span = length(minus(row(person.targets, SHOULDERS), row(person.targets, SPINE)))
    links[link].length_limits[0] = links[link].length_limits[1] = span


@compiled
def chest_frame(person: Record) -> tuple[Vector, Frame]:
    """Return the target of the middle of the shoulders, and the frame of the chest."""
    stance = person.duty
    yaw = person.heading + person.twist
    yaw += SHOULDER_ROTATION * person.walk_blend * phase_cosine(person, 1.0 - stance)
    return row(person.targets, SHOULDERS), trunk_frame(yaw, person.lean[0], person.lean[1], 0.0)


@compiled
def _breath_lift(person: Record, dt: float) -> float:
    """Return the lift of the shoulders by breath [m]; it grows with the effort of the walk."""
    effort = min(froude(ground_speed(person), leg_length(person)), 1.2)
    person.breath = (person.breath + (0.25 + 0.45 * effort) * dt) % 1.0
    depth = (0.0035 + 0.004 * effort) * person.height
    return depth * math.sin(2.0 * math.pi * person.breath)
