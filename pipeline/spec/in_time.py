"""In time: dancers that are locked to a beat of the score."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from audio.config.sound import Sound
from pipeline.spec.cast import Dancer, Member
from pipeline.spec.faults import Fault, Step
from pipeline.spec.script import Instruction, Perform

NEAR = 1e-9
"""Tempos whose ratio is as near to a whole number as this go into one another."""


def in_time(member: Dancer, sound: Sound) -> Dancer:
    """Return a dancer with the tempo and the start that the score gives it.

    Args:
        member: as its author wrote it; one that is locked to no beat stays as it is.
        sound: of the scene.
    """
    if member.beat is None:
        return member
    start, _ = beat_at(member.beat, sound)
    return member.model_copy(
        update={"tempo_bpm": member.tempo_bpm or sound.tempo_bpm, "start": start}
    )


def beat_at(beat: float, sound: Sound) -> tuple[float, float]:
    """Return when a beat of the score is, counted from 1, and how long beats last [s]."""
    lasts = 60.0 / sound.tempo_bpm
    offset = sound.quantise.offset if sound.quantise is not None else 0.0
    return offset + (beat - 1.0) * lasts, lasts


def faults_of_beats(
    cast: Sequence[Member], sound: Sound, script: Sequence[Instruction]
) -> Iterator[Fault]:
    """Find dancers whose tempo does not fit that of the score, and beats before the film."""
    for i, member in enumerate(cast):
        if not isinstance(member, Dancer) or member.beat is None:
            continue
        paths: list[tuple[tuple[Step, ...], float | None]] = [
            (("cast", i, "tempo_bpm"), member.tempo_bpm)
        ]
        for k, one in enumerate(script):
            if isinstance(one.do, Perform) and one.who == member.name:
                paths.append((("script", k, "do", "tempo_bpm"), one.do.tempo_bpm))
        score = sound.tempo_bpm
        for path, own in paths:
            if own is not None and not _go_together(own, score):
                message = (
                    f"it is to be on beat {member.beat:g} of a score at {score:g} beats a minute, "
                    f"and dances at {own:g}; take this away to dance at {score:g}, or make it "
                    f"{0.5 * score:g} or {2 * score:g}"
                )
                yield Fault(path, message)
        start, _ = beat_at(member.beat, sound)
        if start < 0.0:
            message = f"beat {member.beat:g} of the score is at {start:.4g} s, before the film"
            yield Fault(("cast", i, "beat"), message)


def _go_together(one: float, other: float) -> bool:
    """Tell whether beats of the slower fall on beats of the faster."""
    ratio = max(one, other) / min(one, other)
    return math.isclose(ratio, round(ratio), rel_tol=NEAR)
