"""Marks: what happened at a moment, as a golden keeps it."""

from __future__ import annotations

from dataclasses import dataclass

from pipeline.simulation.take import Contact, Note, SoundEvent, Take

DOES = {
    "touch": "touches",
    "lift": "leaves",
    "scuff": "scuffs",
    "hit": "hits",
    "roll": "rolls",
    "slide": "slides",
}
"""What a part does in each kind of contact."""


@dataclass(frozen=True, slots=True)
class Mark:
    """A contact, a sound event or a note.

    Attributes:
        kind: "contact", "event" or "note".
        who: who or what it happened to, such as "bug.l1".
        what: what happened, such as "touches terrain".
        moment: in steps, rounded.
        frame: that shows it, 0 where that is not kept.
        place: where [m], rounded; empty if it has none.
        strength: speed [m/s], rounded.
    """

    kind: str
    who: str
    what: str
    moment: float
    frame: int = 0
    place: tuple[float, ...] = ()
    strength: float = 0.0


def marks_of(take: Take) -> tuple[Mark, ...]:
    """Return all marks of a take: contacts, sound events, notes, each in order of time."""
    return (
        *(_contact(contact) for contact in take.contacts),
        *(_event(event) for event in take.events),
        *(_note(note) for note in take.notes),
    )


def _contact(contact: Contact) -> Mark:
    return Mark(
        "contact",
        _part(contact.performer, contact.part),
        f"{DOES[contact.kind]} {contact.other}",
        round(contact.step + contact.fraction, 4),
        place=tuple(round(x, 4) for x in contact.place),
        strength=round(contact.speed, 3),
    )


def _event(event: SoundEvent) -> Mark:
    return Mark(
        "event",
        _part(event.who, event.part),
        f"{event.cause} with {event.other}" if event.other else event.cause,
        round(event.step + event.fraction, 4),
        event.frame,
        tuple(round(x, 4) for x in event.place),
        round(event.strength, 3),
    )


def _note(note: Note) -> Mark:
    return Mark("note", note.part, note.kind, float(note.step))


def _part(performer: str, part: str) -> str:
    return part if part.startswith(performer) else f"{performer}.{part}"
