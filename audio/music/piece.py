"""Piece: the notes of music on the beats of a score."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from audio.beat_clock import MeterChange
from audio.config.meter import bar_length

Bend = tuple[tuple[float, float], ...]
"""(share of the length of a note, semitones), in the order of time."""


@dataclass(frozen=True, slots=True)
class PieceNote:
    """A note of the music.

    Attributes:
        beat: of its onset; beat 0 is the first of bar 1.
        beats: its length.
        part: name of who plays it.
        program: General MIDI program, or `audio.parts.DRUMS`.
        pitch: MIDI pitch, or key of a drum.
        velocity: 1 to 127.
        gain_db: of its part [dB].
        pan: from left (-1) to right (1).
        reverb: share that is reverberated.
        bend: semitones by which it is bent at shares of its length, on lines between them and as at
            the last after it; empty for none.
        pedal: beats from which, and until which, the sustain pedal is down that holds it.
        rings: beats for which it sounds under the pedal, at least its length.
    """

    beat: Fraction
    beats: Fraction
    part: str
    program: int
    pitch: int
    velocity: int
    gain_db: float = 0.0
    pan: float = 0.0
    reverb: float = 0.25
    bend: Bend = ()
    pedal: tuple[Fraction, Fraction] | None = None
    rings: Fraction | None = None


@dataclass(frozen=True, slots=True)
class Bar:
    """A bar of a score.

    Attributes:
        beat: its first.
        beats: its length.
    """

    beat: Fraction
    beats: Fraction


def bars_until(meters: Sequence[MeterChange], first: int, end: Fraction) -> list[Bar]:
    """Return the bars of a score from one of them up to a beat.

    Args:
        meters: in the order of time, the first from beat 0.
        first: number of the first bar that is returned, from 1.
        end: beat before which they begin.
    """
    bars = []
    beat, number = Fraction(0), 1
    while beat < end:
        meter = next(each.meter for each in reversed(meters) if each.beat <= beat)
        beats = bar_length(meter)
        if number >= first:
            bars.append(Bar(beat, beats))
        beat, number = beat + beats, number + 1
    return bars
