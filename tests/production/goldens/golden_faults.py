"""Faults of a film, and the layers of its golden that must find them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from pipeline.production.goldens.cue_facts import Cues
from pipeline.production.goldens.golden_candidate import Candidate
from pipeline.production.goldens.verdict import Layer
from pipeline.simulation.take import Take
from tests.production.goldens.golden_bases import Base, Picture, Sound

Make = Callable[[Base], Candidate]


@dataclass(frozen=True)
class Fault:
    """A fault, and what must be said of it.

    Attributes:
        name: of the fault.
        layer: that must find it.
        make: returns the results with the fault.
        says: part of what the verdict must say.
        base: number of the scene.
    """

    name: str
    layer: Layer
    make: Make
    says: str = ""
    base: int = 0


def sound(name: str, alter: Callable[[Sound], Sound], says: str = "") -> Fault:
    """Return a fault of the sound that is written."""
    return Fault(f"sound: {name}", "film", lambda base: base.altered(sound=alter), says)


def track(name: str, alter: Callable[[Sound], Sound], says: str = "") -> Fault:
    """Return a fault of the track that the film gets."""
    return Fault(f"track: {name}", "film", lambda base: base.altered(track=alter), says)


def word(
    name: str, layer: Layer, old: str, new: str, says: str = "", base: int = 0, again: bool = False
) -> Fault:
    """Return a fault of the scene's words; with `again` the scene is simulated anew."""

    def make(found: Base) -> Candidate:
        return found.simulated(old, new) if again else found.changed(old, new)

    return Fault(name, layer, make, says, base)


def event(name: str, layer: Layer, number: int, says: str = "", **changes: Any) -> Fault:
    """Return a fault of one sound event; values may be functions of the event."""

    def make(base: Base) -> Candidate:
        events = list(base.take.events)
        old = events[number]
        given = {key: v(old) if callable(v) else v for key, v in changes.items()}
        events[number] = replace(old, **given)
        return base.moved(events=tuple(events))

    return Fault(name, layer, make, says)


def picture(name: str, alter: Callable[[Picture], Picture], says: str = "") -> Fault:
    """Return a fault of the rendered pictures."""
    return Fault(name, "frames", lambda base: base.altered(picture=alter), says)


def cues(name: str, alter: Callable[[Cues], Cues], says: str = "") -> Fault:
    """Return a fault of the camera or the notes."""
    return Fault(name, "motion", lambda base: base.altered(cues=alter), says)


def moved(name: str, alter: Callable[[Take], dict[str, Any]], says: str = "") -> Fault:
    """Return a fault of the take."""
    return Fault(name, "motion", lambda base: base.moved(**alter(base.take)), says)
