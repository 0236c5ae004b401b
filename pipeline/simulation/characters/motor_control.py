"""Motor control."""

from __future__ import annotations

import math

from pipeline.simulation.characters.biped_gait import tread
from pipeline.simulation.characters.body_arrays import FREE, LOCKED, SOLID, Crowd
from pipeline.simulation.characters.collision_avoidance import avoid, hold_back, slide
from pipeline.simulation.characters.gait_timing import sprung, wrapped
from pipeline.simulation.characters.limb_posture import hold_arms, hold_legs, stoop
from pipeline.simulation.characters.pelvis_motion import halt, lead, sit
from pipeline.simulation.characters.person_record import (
    COUNT,
    ELBOW,
    FOOT,
    HAND,
    HEAD,
    PELVIS,
    STANCE,
)
from pipeline.simulation.characters.solid_arrays import Solids
from pipeline.simulation.characters.trunk_posture import hold_trunk, stretch
from pipeline.simulation.dynamics.compiled import Record, Records, compiled
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.grid import Grid

STUNS = 0.5
"""Energy of a blow after which muscles are quite slack, for each kilogram of the body [J/kg]."""

LEAST = 0.25
"""Of that, what a body takes without a change."""

RECOVERS = 2.2
"""How quickly they are not any more [1/s]."""

KNOCK, KNOCKED = 0.5, 1.5
"""Speed of the pelvis against where it is led: what nobody minds, and what leaves nobody upright
[m/s]."""


@compiled
def feel(person: Record, nodes: Records, links: Records, owners: Records, dt: float) -> None:
    """Take in what others strike, and what throws somebody off, and recover from it."""
    person.dazed *= max(1.0 - RECOVERS * dt, 0.0)
    pelvis = nodes[person.node + PELVIS]
    x = (pelvis.p[0] - pelvis.before[0]) / dt - person.going[0]
    z = (pelvis.p[2] - pelvis.before[2]) / dt - person.going[1]
    if person.seated == 0.0 and not person.frozen:
        off = (math.hypot(x, z) - KNOCK) / (KNOCKED - KNOCK)
        person.dazed = max(person.dazed, min(off, 1.0))
    owner = owners[person.owner]
    first, count = owner.links[0], owner.links[1]
    for link in range(first, first + count):
        other = links[link].touched_owner
        if (other >= 0 and other != person.owner) or links[link].touched <= SOLID:
            blow = links[link].energy / (STUNS * owner.mass)
            if blow > LEAST:
                person.dazed = max(person.dazed, min(blow, 1.0))


GAZE_RATE = 8.0
"""[rad/s]"""

ASIDE, UP, DOWN = math.radians(72.0), math.radians(45.0), math.radians(50.0)
"""How far a head turns against the shoulders, and up and down."""


@compiled
def look(person: Record, dt: float) -> None:
    """Turn the head by one sub-step."""
    yaw, pitch = person.heading + 0.25 * person.turning, 0.0
    if person.looks:
        x = person.look_at[0] - person.wanted[HEAD, 0]
        y = person.look_at[1] - person.wanted[HEAD, 1]
        z = person.look_at[2] - person.wanted[HEAD, 2]
        if math.hypot(x, z) > 1e-6:
            yaw = math.atan2(-z, x)
        pitch = math.atan2(y, math.hypot(x, z))
    chest = person.heading + person.twist
    off = wrapped(yaw - person.heading)
    # Beyond what neck and shoulders turn together: straight over the shoulder.
    off = min(max(off, -2.2), 2.2)
    most = ASIDE + abs(person.twist)
    off = min(max(off, -most), most)
    yaw = person.heading + off
    pitch = min(max(pitch, -DOWN), UP)
    now, rate = wrapped(person.gaze[0] - person.heading), person.gaze_rate[0]
    now, person.gaze_rate[0] = sprung(now, rate, wrapped(yaw - person.heading), GAZE_RATE, dt)
    middle = wrapped(chest - person.heading)
    person.gaze[0] = person.heading + min(max(now, middle - ASIDE), middle + ASIDE)
    person.gaze[1], person.gaze_rate[1] = sprung(
        person.gaze[1], person.gaze_rate[1], pitch, GAZE_RATE, dt
    )


TRUNK, LIMBS = 30.0, 24.0
"""How quickly muscles bring nodes where they should be [rad/s]."""

FARTHEST = 0.08
"""That a muscle pulls, however far it has to [m]: no stronger than at this distance."""

CATCHES_UP = 1.5
"""How fast a foot that was stopped on its way goes after where it should be [m/s]."""

LEAPS = 15.0
"""How fast no foot goes, so that what is asked of it is no motion but another place: who runs has
feet of ten [m/s]."""

STUCK = 0.04
"""How far from where it should stand a foot is that was, and does not yet stand [m]."""

WEAKEST = 0.12
"""What a blow leaves of the muscles' quickness."""


@compiled
def firm(k: int) -> float:
    """Return how quickly a node of a person is brought where it should be [rad/s]."""
    limb = k == ELBOW or k == ELBOW + 1 or k == HAND or k == HAND + 1 or k == HEAD
    return LIMBS if limb else TRUNK


@compiled
def pull(person: Record, nodes: Records, dt: float) -> None:
    """Act on all nodes of a person for a sub-step."""
    for k in range(COUNT):
        node = nodes[person.node + k]
        if k >= FOOT:
            _step(person, nodes, k - FOOT, dt)
        else:
            quick = firm(k) * (1.0 - (1.0 - WEAKEST) * person.dazed)
            for c in range(3):
                v = (node.p[c] - node.before[c]) / dt
                along = (person.wanted[k, c] - person.before[k, c]) / dt
                off = min(max(person.wanted[k, c] - node.p[c], -FARTHEST), FARTHEST)
                node.acceleration[c] += quick * (quick * off + 2.0 * (along - v))
            node.acceleration[1] += GRAVITY
        for c in range(3):
            person.before[k, c] = person.wanted[k, c]


@compiled
def _is_there(person: Record, node: Record, k: int) -> bool:
    """Tell whether a foot that came down is about where it should stand."""
    squared = 0.0
    for c in range(3):
        squared += (node.p[c] - person.ankles[k, c]) ** 2
    there: bool = squared < STUCK * STUCK
    return there


@compiled
def _step(person: Record, nodes: Records, k: int, dt: float) -> None:
    """Lock a foot that stands, and send one that swings along its line."""
    node = nodes[person.node + FOOT + k]
    if person.doing[k] == STANCE and (node.lock == LOCKED or _is_there(person, node, k)):
        node.lock = LOCKED
        for c in range(3):
            node.place[c] = person.ankles[k, c]
        return
    node.lock = FREE
    squared = 0.0
    for c in range(3):
        squared += (person.wanted[FOOT + k, c] - person.before[FOOT + k, c]) ** 2
    goes = 1.0 if squared < (LEAPS * dt) ** 2 else 0.0
    for c in range(3):
        along = goes * (person.wanted[FOOT + k, c] - person.before[FOOT + k, c])
        after = person.wanted[FOOT + k, c] - along - node.p[c]
        after = min(max(after, -CATCHES_UP * dt), CATCHES_UP * dt)
        node.before[c] = node.p[c] - along - after
    node.acceleration[1] += GRAVITY


@compiled
def steer(crowd: Crowd, persons: Records, ground: Grid, solids: Solids, h: float) -> None:
    """Let everybody act for a sub-step of `h` [s], see `layout`."""
    nodes, links, _, _, _, _, owners = crowd
    if len(persons) > 0 and persons[0].since == 0.0:
        avoid(persons)
    for i in range(len(persons)):
        person = persons[i]
        feel(person, nodes, links, owners, h)
        if person.frozen:
            halt(person)
        else:
            lead(person, nodes, ground, h)
            hold_back(person, owners[person.owner].mass, solids, h)
            slide(person, nodes, h)
            tread(person, ground.frame, ground.vertices, h)
            sit(person, h)
            look(person, h)
            stoop(person, h)
            hold_trunk(person, nodes, h)
            hold_legs(person)
            hold_arms(person, h)
        person.since += h
        stretch(person, links, owners)
        pull(person, nodes, h)
