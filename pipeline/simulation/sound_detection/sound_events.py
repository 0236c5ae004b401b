"""Sound events of contacts and of active intervals of motion."""

from __future__ import annotations

from pipeline.simulation.clock import Clock
from pipeline.simulation.sound_detection.active_intervals import ActiveInterval
from pipeline.simulation.sound_detection.sound_sources import SoundingPart
from pipeline.simulation.take import Contact, Place, SoundEvent

STEP_TOLERANCE = 1e-6
"""Fractions of a step below this are zero: rounding must not shift an event by a frame."""

DECIMALS = 6
"""Of strengths and places over time: a micrometre is inaudible."""


def contact_event(contact: Contact, cause: str, clock: Clock) -> SoundEvent:
    """Return the event of a contact: its onset, and its course if it is sustained."""
    # The last row that is not after it.
    first = contact.step * clock.samples // clock.steps
    last = first if contact.until < 0 else contact.until * clock.samples // clock.steps
    fraction = _snapped(contact.fraction)
    return SoundEvent(
        step=contact.step,
        fraction=fraction,
        frame=clock.frame_of(contact.step, fraction),
        cause=cause,
        who=contact.performer,
        part=contact.part,
        other=contact.other,
        place=contact.place,
        strength=contact.speed,
        energy=contact.energy,
        size=contact.size,
        material=contact.material,
        surface=contact.surface,
        track=(first, last),
        strengths=tuple(round(v, DECIMALS) for v in contact.speeds),
        places=tuple(_rounded(place) for place in contact.places),
    )


def interval_event(
    interval: ActiveInterval, cause: str, part: SoundingPart, clock: Clock
) -> SoundEvent:
    """Return the event of an interval whose values are a strength [m/s] and a place [m]."""
    steps = interval.start * (clock.steps // clock.samples)
    step, fraction = int(steps), _snapped(steps - int(steps))
    places = [(x, y, z) for _, x, y, z in interval.values]
    strengths = [row[0] for row in interval.values]
    return SoundEvent(
        step=step,
        fraction=fraction,
        frame=clock.frame_of(step, fraction),
        cause=cause,
        who=part.performer,
        part=part.part,
        other="",
        place=places[0],
        strength=max(strengths),
        energy=0.0,
        size=part.size,
        material=part.material,
        surface="",
        track=(interval.first, interval.last),
        strengths=tuple(round(v, DECIMALS) for v in strengths),
        places=tuple(_rounded(place) for place in places),
    )


def _snapped(fraction: float) -> float:
    return 0.0 if fraction < STEP_TOLERANCE else fraction


def _rounded(place: Place) -> Place:
    x, y, z = place
    return round(x, DECIMALS), round(y, DECIMALS), round(z, DECIMALS)
