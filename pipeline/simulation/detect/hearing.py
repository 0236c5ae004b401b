"""Hearing: a contact or a spell of motion -> the sound event that it makes."""

from __future__ import annotations

from fnmatch import fnmatchcase

from pipeline.simulation.clock import Clock
from pipeline.simulation.detect.scenery import Solid
from pipeline.simulation.detect.spells import Spell
from pipeline.simulation.take import Contact, Place, SoundEvent

NOISE = 1e-6
"""Part of a step under which a moment is that of the step: rounding must not cost a frame."""

DIGITS = 6
"""Of strengths and places over time: a micrometre is not heard."""


def fits(name: str, pattern: str) -> bool:
    """Tell whether a name is meant by an author's pattern, where `*` stands for any letters."""
    # Names may hold what fnmatch takes for sets of letters.
    plain = pattern.replace("[", "[[]").replace("?", "[?]")
    return fnmatchcase(name.casefold(), plain.casefold())


def event_of(contact: Contact, cause: str, clock: Clock) -> SoundEvent:
    """Return the sound of a contact: its onset, and of what rubs the whole of it."""
    # The last row that is not after it.
    first = contact.step * clock.samples // clock.steps
    last = first if contact.until < 0 else contact.until * clock.samples // clock.steps
    fraction = _settled(contact.fraction)
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
        strengths=tuple(round(v, DIGITS) for v in contact.speeds),
        places=tuple(_rounded(place) for place in contact.places),
    )


def event_of_spell(spell: Spell, cause: str, solid: Solid, clock: Clock) -> SoundEvent:
    """Return the sound of a spell of motion.

    Its values over time are a strength [m/s] and a place [m].
    """
    step, fraction = moment_of(spell.begin, clock)
    places = [(x, y, z) for _, x, y, z in spell.values]
    strengths = [row[0] for row in spell.values]
    return SoundEvent(
        step=step,
        fraction=fraction,
        frame=clock.frame_of(step, fraction),
        cause=cause,
        who=solid.performer,
        part=solid.part,
        other="",
        place=places[0],
        strength=max(strengths),
        energy=0.0,
        size=solid.size,
        material=solid.material,
        surface="",
        track=(spell.first, spell.last),
        strengths=tuple(round(v, DIGITS) for v in strengths),
        places=tuple(_rounded(place) for place in places),
    )


def moment_of(row: float, clock: Clock) -> tuple[int, float]:
    """Return the step before a moment given in rows, and the fraction of a step after that."""
    steps = row * (clock.steps // clock.samples)
    return int(steps), _settled(steps - int(steps))


def _settled(fraction: float) -> float:
    return 0.0 if fraction < NOISE else fraction


def _rounded(place: Place) -> Place:
    x, y, z = place
    return round(x, DIGITS), round(y, DIGITS), round(z, DIGITS)
