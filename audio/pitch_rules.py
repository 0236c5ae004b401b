"""Pitch rules: pitch by the size of a body, or a scale step for each foot or part."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from math import log2

from audio.config.pitch import first_note_of_rule
from audio.general_midi import usual_range
from audio.harmony import Scale, fold_pitch
from audio.names import normalized_name
from audio.score import ScoreEvent

FOOT_CAUSES = ("footfall", "scuff")
"""Causes whose notes have a scale step for each foot by default."""


@dataclass(frozen=True, slots=True)
class _PitchBySize:
    """Pitch of a body by its size.

    Real strings and bars rise an octave for half the length; two thirds of it keep a brick and a
    beetle on one instrument.

    Attributes:
        size: of the reference body [m].
        pitch: MIDI pitch of that body.
        slope: semitones by which the pitch rises for half the size.
    """

    size: float = 0.1
    pitch: float = 67.0
    slope: float = 8.0


_REFERENCE = _PitchBySize()


@dataclass(frozen=True, slots=True)
class PartRank:
    """Rank of a part among the parts of a performer that sound for the same cause.

    Attributes:
        index: 0 for the first, in the natural order of names.
        count: number of parts.
        size: of the largest part [m]; gives the pitch from which several count their steps.
    """

    index: int
    count: int
    size: float


Ranks = dict[tuple[str, str, str], PartRank]
"""(performer, group of causes, part) -> rank."""


def part_ranks(events: Iterable[ScoreEvent]) -> Ranks:
    """Return the rank of every part."""
    sizes: dict[tuple[str, str], dict[str, float]] = {}
    for event in events:
        own = sizes.setdefault((event.who, _cause_group(event)), {})
        own[event.part] = max(own.get(event.part, 0.0), event.size)
    return {
        (*key, part): PartRank(index, len(own), max(own.values()))
        for key, own in sizes.items()
        for index, part in enumerate(sorted(own, key=_natural_order))
    }


def rank_of(ranks: Ranks, event: ScoreEvent) -> PartRank:
    """Return the rank of an event's part."""
    return ranks[event.who, _cause_group(event), event.part]


def _cause_group(event: ScoreEvent) -> str:
    """Return the name shared by causes that count their parts together."""
    cause = normalized_name(event.cause)
    return FOOT_CAUSES[0] if cause in FOOT_CAUSES else cause


def _natural_order(name: str) -> tuple[list[tuple[int, str]], str]:
    """Return a sort key that places foot_2 before foot_10."""
    pieces = re.findall(r"[0-9]+|[^0-9]+", name)
    return [(int(p), "") if p.isascii() and p.isdigit() else (-1, p) for p in pieces], name


def default_rule(event: ScoreEvent) -> str:
    """Return the pitch rule of an event without a configured pitch."""
    return "by part" if normalized_name(event.cause) in FOOT_CAUSES else "by size"


def pitch_by_rule(rule: str, event: ScoreEvent, rank: PartRank, scale: Scale, program: int) -> int:
    """Return the pitch of an event in a scale.

    Args:
        rule: "by size", "by foot", "by part", or one of the latter two "from C3".
        event: its size is used.
        rank: of its part.
        scale: of the result.
        program: General MIDI program, whose usual range limits pitches by size.
    """
    first = first_note_of_rule(rule)
    if first is not None:
        return fold_pitch(scale.pitch(scale.degree(first) + rank.index))
    lowest, highest = usual_range(program)
    if normalized_name(rule) == "by size":
        degree = _degree_of_size(event.size, scale, lowest, highest)
        return fold_pitch(scale.pitch(degree), lowest, highest)
    # After two octaves the steps repeat: a centipede stays within an audible range.
    steps = min(rank.count, 2 * len(scale.intervals))
    size = rank.size if rank.count > 1 else event.size
    degree = _degree_of_size(size, scale, lowest, highest)
    while degree > 0 and scale.pitch(degree + steps - 1) > highest:
        degree -= 1
    return fold_pitch(scale.pitch(degree + rank.index % steps), lowest, highest)


@lru_cache(maxsize=4096)
def _degree_of_size(size: float, scale: Scale, lowest: int, highest: int) -> int:
    pitch = _REFERENCE.pitch - _REFERENCE.slope * log2(size / _REFERENCE.size)
    return scale.degree(min(max(pitch, lowest), highest))
