"""Motion marks: contacts, sound events and notes of a motion, and those that differ in another."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import zip_longest
from math import dist

from pipeline.production.goldens import motion_tolerance
from pipeline.production.goldens.motion_verdict import Difference, millimetres
from pipeline.simulation.take import Contact, SoundEvent, Take

CONTACT_VERBS = {
    "touch": "touches",
    "lift": "leaves",
    "scuff": "scuffs",
    "hit": "hits",
    "roll": "rolls",
    "slide": "slides",
}
"""Verb of a part for each kind of contact."""


@dataclass(frozen=True, slots=True)
class Mark:
    """A contact, a sound event or a note.

    Attributes:
        kind: "contact", "event" or "note".
        who: performer or part, such as "bug.l1".
        what: event, such as "touches terrain".
        moment: in steps, rounded.
        frame: first that shows it, 0 where it is not kept.
        place: [m], rounded; may be empty.
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
    """Return the contacts, sound events and notes of a take, each in order of time."""
    return (
        *(_contact(contact) for contact in take.contacts),
        *(_event(event) for event in take.events),
        *(Mark("note", note.part, note.kind, float(note.step)) for note in take.notes),
    )


def _contact(contact: Contact) -> Mark:
    return Mark(
        "contact",
        _part(contact.performer, contact.part),
        f"{CONTACT_VERBS[contact.kind]} {contact.other}",
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


def _part(performer: str, part: str) -> str:
    return part if part.startswith(performer) else f"{performer}.{part}"


ROUNDING = 1e-3
"""Bound of the rounding of moments [steps] and speeds [m/s]."""


def mark_differences(then: Iterable[Mark], now: Iterable[Mark], steps: int) -> Iterator[Difference]:
    """Yield marks that are missing, new, or beyond tolerance.

    Marks of one kind, part and event are matched in the order of time.

    Args:
        then: marks of the golden.
        now: marks of the take.
        steps: world steps per frame.
    """
    for old_mark, new_mark in _matched(then, now):
        text = _mark_difference(old_mark, new_mark, steps)
        mark = old_mark or new_mark
        if text and mark is not None:
            moment = min(mark.moment for mark in (old_mark, new_mark) if mark)
            yield Difference(int(moment), mark.kind, mark.who, text)


def frames_differ(then: Iterable[Mark], now: Iterable[Mark]) -> bool:
    """Return whether a sound event stands on another frame: its moment was next to a boundary."""
    return any(
        old_mark is not None and new_mark is not None and old_mark.frame != new_mark.frame
        for old_mark, new_mark in _matched(then, now)
    )


def _matched(
    then: Iterable[Mark], now: Iterable[Mark]
) -> Iterator[tuple[Mark | None, Mark | None]]:
    groups: dict[tuple[str, str, str], tuple[list[Mark], list[Mark]]]
    groups = defaultdict(lambda: ([], []))
    for side, marks in enumerate((then, now)):
        for mark in marks:
            groups[mark.kind, mark.who, mark.what][side].append(mark)
    for old, new in groups.values():
        yield from _pairs(old, new)


def _pairs(old: list[Mark], new: list[Mark]) -> Iterator[tuple[Mark | None, Mark | None]]:
    """Yield pairs in the order of time; equal numbers are matched one by one."""
    old, new = (sorted(marks, key=lambda mark: mark.moment) for marks in (old, new))
    if len(old) == len(new):
        yield from zip_longest(old, new)
        return
    n = 0
    for old_mark in old:
        while n < len(new) and new[n].moment < old_mark.moment - motion_tolerance.MOMENT:
            yield None, new[n]
            n += 1
        if n < len(new) and new[n].moment <= old_mark.moment + motion_tolerance.MOMENT:
            yield old_mark, new[n]
            n += 1
        else:
            yield old_mark, None
    yield from ((None, new_mark) for new_mark in new[n:])


def _mark_difference(old_mark: Mark | None, new_mark: Mark | None, steps: int) -> str:
    """Return the difference of a mark from its golden as text, empty if within tolerance."""
    if old_mark is None or new_mark is None:
        mark = old_mark or new_mark
        fate = "is missing" if old_mark else "is new"
        return f"{mark.what} at step {mark.moment:g}: this {mark.kind} {fate}" if mark else ""
    late = new_mark.moment - old_mark.moment
    what = f"{old_mark.what} at step {old_mark.moment:g}"
    if abs(late) > motion_tolerance.MOMENT + ROUNDING:
        same = new_mark.frame == old_mark.frame
        frames = "" if same else f", frame {new_mark.frame} instead of {old_mark.frame}"
        return f"{what}: {old_mark.kind} moved to step {new_mark.moment:g}{frames}"
    if old_mark.frame != new_mark.frame and not _boundary_between(old_mark, new_mark, steps):
        return f"{what}: {old_mark.kind} moved from frame {old_mark.frame} to {new_mark.frame}"
    if old_mark.place and (apart := dist(old_mark.place, new_mark.place)) > motion_tolerance.PLACE:
        return f"{what}: {old_mark.kind} lies {millimetres(apart)} off"
    bound = motion_tolerance.strength_tolerance(old_mark.strength) + ROUNDING
    if abs(new_mark.strength - old_mark.strength) > bound:
        speeds = f"{new_mark.strength:g} m/s instead of {old_mark.strength:g} m/s"
        return f"{what}: {old_mark.kind} of {speeds}"
    return ""


def _boundary_between(old_mark: Mark, new_mark: Mark, steps: int) -> bool:
    """Return whether a frame boundary between the moments explains different frames."""
    if abs(old_mark.frame - new_mark.frame) != 1:
        return False
    edge = (min(old_mark.frame, new_mark.frame) - 1) * steps
    early, late = sorted((old_mark.moment, new_mark.moment))
    return early - ROUNDING <= edge <= late + ROUNDING
