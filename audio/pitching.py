"""Pitches: of a thing by its size, of feet and other parts each a step of the scale."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from math import log2

from audio.instruments import range_of
from audio.names import folded
from audio.pitch_words import counted_from
from audio.scales import Scale
from audio.score import ScoreEvent

# What feet do: a step of the scale for each of them.
BY_PART = ("footfall", "scuff")

# Middle of the keyboard for a piece of 0.1 m. Real strings and bars climb an octave for half the
# length; two thirds of it keeps a brick and a beetle on one instrument.
_SIZE_PITCH = 67.0
_SEMITONES_PER_HALVING = 8.0


@dataclass(frozen=True, slots=True)
class Rank:
    """Where a part stands among those that sound for the same reason.

    Attributes:
        place: 0 for the first, in the order of names in which foot_2 comes before foot_10.
        parts: how many there are.
        size: of the largest of them [m]; if there are several, all count steps from its pitch.
    """

    place: int
    parts: int
    size: float


Ranks = dict[tuple[str, str, str], Rank]


def ranks_of(events: Iterable[ScoreEvent]) -> Ranks:
    """Return the rank of each (performer, reason, part)."""
    sizes: dict[tuple[str, str], dict[str, float]] = {}
    for event in events:
        own = sizes.setdefault((event.who, _kin(event)), {})
        own[event.part] = max(own.get(event.part, 0.0), event.size)
    return {
        (*of, part): Rank(place, len(own), max(own.values()))
        for of, own in sizes.items()
        for place, part in enumerate(sorted(own, key=_natural))
    }


def rank_of(ranks: Ranks, event: ScoreEvent) -> Rank:
    """Return the rank of the part that sounds."""
    return ranks[event.who, _kin(event), event.part]


def _kin(event: ScoreEvent) -> str:
    """Return what causes count their parts together: a knee that squeaks tunes no foot."""
    cause = folded(event.cause)
    return BY_PART[0] if cause in BY_PART else cause


def _natural(name: str) -> tuple[list[tuple[int, str]], str]:
    """Return the key that sorts foot_2 before foot_10."""
    pieces = re.findall(r"[0-9]+|[^0-9]+", name)
    return [(int(p), "") if p.isascii() and p.isdigit() else (-1, p) for p in pieces], name


def pitch_by(rule: str, event: ScoreEvent, rank: Rank, scale: Scale, program: int) -> int:
    """Return the pitch of an event by a rule, in the scale.

    Args:
        rule: "by size", "by foot", "by part", or one of the latter two "from C3".
        event: what sounds.
        rank: of its part.
        scale: of the notes.
        program: General MIDI program, in whose usual range pitches by size lie.
    """
    first = counted_from(rule)
    if first is not None:
        return _folded(scale.pitch(scale.degree(first) + rank.place), 0, 127)
    lowest, highest = range_of(program)
    if folded(rule) == "by size":
        return _folded(scale.pitch(_degree(event.size, scale, lowest, highest)), lowest, highest)
    # Two octaves of steps, then again from the start: a centipede stays in tune and in hearing.
    steps = min(rank.parts, 2 * len(scale.intervals))
    size = rank.size if rank.parts > 1 else event.size
    degree = _degree(size, scale, lowest, highest)
    while degree > 0 and scale.pitch(degree + steps - 1) > highest:
        degree -= 1
    return _folded(scale.pitch(degree + rank.place % steps), lowest, highest)


def _degree(size: float, scale: Scale, lowest: int, highest: int) -> int:
    by_size = _SIZE_PITCH - _SEMITONES_PER_HALVING * log2(size / 0.1)
    return scale.degree(min(max(by_size, lowest), highest))


def _folded(pitch: int, lowest: int, highest: int) -> int:
    """Return a pitch in the octave that lies within a range of one octave or more."""
    while pitch > highest:
        pitch -= 12
    while pitch < lowest:
        pitch += 12
    return pitch
