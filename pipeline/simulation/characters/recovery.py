"""Recovery: a person that has fallen lies for a moment, gathers its feet and rises from a crouch.

Source: VanSant 1988 (adults rise from the floor through a squat, feet and hands below the trunk).
"""

from __future__ import annotations

from pipeline.simulation.characters.gait_timing import leg_length
from pipeline.simulation.characters.person_record import PELVIS
from pipeline.simulation.dynamics.compiled import Record, Records, compiled

FALLEN_HEIGHT, FALLEN_STUN = 0.5, 0.3  # of the pelvis, in leg lengths; slackness in a fall
LYING_TIME = 0.7  # before a person gathers itself [s]
GATHERING_TIME = 0.8  # in which its feet come below it [s]
LYING_SLACKNESS = 0.7  # of the muscles of one that lies
RISING_CROUCH, RISING_BOW = 0.6, 0.8  # from which it rises, of the legs; as a tangent


@compiled
def recover(person: Record, nodes: Records, h: float) -> None:
    """Advance the fall and the recovery of a person by `h` [s]."""
    height = nodes[person.node + PELVIS].p[1] - person.floor
    is_low = height < FALLEN_HEIGHT * leg_length(person)
    if person.down_time == 0.0:
        crouches = person.crouch > 0.2
        if person.stun < FALLEN_STUN or not is_low or crouches or person.sit_blend > 0.0:
            return
    person.down_time += h
    if person.down_time < LYING_TIME:
        person.stun = max(person.stun, LYING_SLACKNESS)
    elif person.down_time > LYING_TIME + GATHERING_TIME:
        person.down_time = 0.0


@compiled
def is_down(person: Record) -> bool:
    """Tell whether a person lies or gathers itself after a fall."""
    return bool(person.down_time > 0.0)
