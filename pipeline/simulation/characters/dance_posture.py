"""Dance posture: targets of trunk and arms that a guided dance takes over from a standing body.

Pelvis and legs stay those of the person, who shifts its weight as ever. The guide gives joints once
a step in the frame of the pelvis; sub-steps go straight from the last to the next.
"""

from __future__ import annotations

from pipeline.simulation.characters.gait_timing import smoothstep, spring_step
from pipeline.simulation.characters.person_record import HAND, PELVIS, SPINE
from pipeline.simulation.characters.trunk_posture import place_in_world, trunk_frame
from pipeline.simulation.dynamics.compiled import Record, Records, compiled
from pipeline.simulation.dynamics.vectors import plus, put, row, times

DANCE_RATE = 7.0
"""At which a dance takes over trunk and arms, and gives them back [rad/s]."""

LEAST_BLEND = 1e-4
"""Blend below which a dance that is over has no effect."""

GUIDED_ARMS = 0.5
"""Blend from which arms pass through their own body: the guide keeps them out of it."""


@compiled
def hold_dance(person: Record, owners: Records, dt: float) -> None:
    """Blend the targets of trunk and arms over to those of a dance."""
    if not person.dances and person.dance_blend < LEAST_BLEND:
        person.dance_blend = person.dance_blend_rate = 0.0
        owners[person.owner].is_guided = False
        return
    person.dance_blend, person.dance_blend_rate = spring_step(
        person.dance_blend, person.dance_blend_rate, 1.0 if person.dances else 0.0, DANCE_RATE, dt
    )
    blend = smoothstep(person.dance_blend)
    owners[person.owner].is_guided = blend > GUIDED_ARMS
    share = min((person.report_time + dt) / person.dance_step, 1.0)
    pelvis = row(person.targets, PELVIS)
    frame = trunk_frame(person.heading, 0.0, 0.0, 0.0)
    for k in range(SPINE, HAND + 2):
        start, end = row(person.dance_start, k - SPINE), row(person.dance_end, k - SPINE)
        local = plus(times(1.0 - share, start), times(share, end))
        place = place_in_world(pelvis, frame, local[0], local[1], local[2])
        own = row(person.targets, k)
        put(person.targets, k, plus(times(1.0 - blend, own), times(blend, place)))
