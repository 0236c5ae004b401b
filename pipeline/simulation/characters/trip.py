"""Trip: a foot that is caught by a hurdle that its owner has not seen.

The foot stays before the hurdle, and what is above it goes on: the body turns about the caught
foot. From a slow walk that is a stumble, which the next steps catch; from a run it is a fall.

Source: Eng, Winter and Patla 1994 (reactions to trips: the trunk pitches forward, the other leg
lands early); Pavol, Owings, Foley and Grabiner 1999 (the faster the walk, the more falls).
"""

from __future__ import annotations

import math

from pipeline.simulation.characters.body_arrays import NOBODY, SOLID, CharacterArrays
from pipeline.simulation.characters.gait_timing import froude, ground_speed, leg_length
from pipeline.simulation.characters.hurdles import hurdle_gap
from pipeline.simulation.characters.person_record import FOOT, KNEE, NODE_COUNT, STANCE, SWING
from pipeline.simulation.characters.solid_arrays import Solids
from pipeline.simulation.dynamics.compiled import Record, compiled
from pipeline.simulation.dynamics.vectors import minus, put, row

LEAST_FROUDE, FALLING_FROUDE = 0.15, 0.6  # speeds of a trip without effect, and of a certain fall
HIGH_HURDLE = 0.12  # rise that catches a foot for certain, in leg lengths
FULL_MASS = 0.06  # of a hurdle that holds a foot for certain, in the person's mass
LEAST_STRENGTH = 0.1  # of a trip, below which the thing is kicked away
STUMBLE_SLACKNESS, FALL_SLACKNESS = 0.3, 1.0  # of the muscles
FALL_STRENGTH = 0.75  # of a trip from which a person falls
TURN_RATE = 3.6  # at which a certain fall turns the body about the foot [rad/s]
LEAN_RATE = 1.6  # at which a stumble leans the trunk [1/s]
SPEED_KEPT = 0.5  # of the led place after a fall
YIELD = 0.05  # by which a caught foot comes to rest [m]
FOOT_SPEED = 1.5  # of a foot that is caught, in that of the person
TOE = 0.6  # ahead of the ankle, in foot lengths


@compiled
def catch_feet(person: Record, arrays: CharacterArrays, solids: Solids, h: float) -> None:
    """Catch a swinging foot of a person in a hurdle that it has not seen, in a sub-step `h` [s]."""
    if person.hurdle == NOBODY or person.hurdle_seen:
        return
    for k in range(2):
        if person.foot_state[k] != SWING:
            continue
        ahead = TOE * person.foot
        x = person.ankles[k, 0] + ahead * math.cos(person.yaw[k])
        z = person.ankles[k, 2] - ahead * math.sin(person.yaw[k])
        sole = person.ankles[k, 1] - person.ankle - person.floor
        if sole < person.hurdle_rise and hurdle_gap(person, x, z) < YIELD:
            _trip(person, k, arrays, solids, h)
            return


@compiled
def _strength(person: Record, arrays: CharacterArrays, solids: Solids) -> float:
    """Return how much a hurdle upsets a person, from 0 to 1 for a certain fall."""
    leg = leg_length(person)
    speed = froude(ground_speed(person), leg)
    by_speed = (speed - LEAST_FROUDE) / (FALLING_FROUDE - LEAST_FROUDE)
    by_rise = person.hurdle_rise / (HIGH_HURDLE * leg)
    own, share = arrays.owners[person.owner].mass, 1.0
    if person.hurdle >= 0:
        share = arrays.owners[person.hurdle].mass / (FULL_MASS * own)
    else:
        inverse_mass = solids.bodies[SOLID - person.hurdle].inverse_mass
        if inverse_mass > 0.0:
            share = 1.0 / (inverse_mass * FULL_MASS * own)
    return min(max(by_speed, 0.0), 1.0) * min(by_rise, 1.0) * min(share, 1.0)


@compiled
def _trip(person: Record, k: int, arrays: CharacterArrays, solids: Solids, h: float) -> None:
    strength = _strength(person, arrays, solids)
    # Now it knows what is there.
    person.hurdle_seen = True
    if strength < LEAST_STRENGTH:
        return
    person.foot_state[k] = STANCE
    caught = row(person.ankles, k)
    speed = max(ground_speed(person), 1e-6)
    x, z = person.velocity[0] / speed, person.velocity[1] / speed
    person.stance_place[k, 0] = person.ankles[k, 0] + YIELD * x
    person.stance_place[k, 2] = person.ankles[k, 2] + YIELD * z
    person.stance_place[k, 1] = person.floor + person.ankle
    person.stance_on_deck[k] = 0
    put(person.settling, k, minus(caught, row(person.stance_place, k)))
    swing = FOOT_SPEED * speed
    put(person.settling_rate, k, (swing * x, 0.0, swing * z))
    person.trips += 1
    falls = strength >= FALL_STRENGTH
    slackness = FALL_SLACKNESS if falls else STUMBLE_SLACKNESS + 0.3 * strength
    person.stun = max(person.stun, slackness)
    person.lean_rate[0] += LEAN_RATE * strength * x
    person.lean_rate[1] += LEAN_RATE * strength * z
    if falls:
        # Until it rises, it neither walks on nor holds itself up.
        person.down_time = h
        nodes, foot = arrays.nodes, person.ankles[k, 1]
        for n in range(NODE_COUNT):
            if KNEE <= n < KNEE + 2 or n >= FOOT:
                continue
            node = nodes[person.node + n]
            v = TURN_RATE * strength * max(node.p[1] - foot, 0.0) * 0.6
            node.previous[0] -= h * v * x
            node.previous[2] -= h * v * z
        for c in range(2):
            person.velocity[c] *= SPEED_KEPT
