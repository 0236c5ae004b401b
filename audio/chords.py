"""Chords by name, such as Am7: several pitches at once, or the steps of a scale."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache

from audio.names import nearest
from audio.scales import Scale, parse_scale, pitch_class

# Semitones above the root, in close position.
KINDS: dict[str, tuple[int, ...]] = {
    "": (0, 4, 7),
    "m": (0, 3, 7),
    "5": (0, 7),
    "6": (0, 4, 7, 9),
    "m6": (0, 3, 7, 9),
    "7": (0, 4, 7, 10),
    "maj7": (0, 4, 7, 11),
    "m7": (0, 3, 7, 10),
    "mmaj7": (0, 3, 7, 11),
    "dim": (0, 3, 6),
    "dim7": (0, 3, 6, 9),
    "m7b5": (0, 3, 6, 10),
    "aug": (0, 4, 8),
    "sus2": (0, 2, 7),
    "sus4": (0, 5, 7),
    "7sus4": (0, 5, 7, 10),
    "9": (0, 4, 7, 10, 14),
    "m9": (0, 3, 7, 10, 14),
    "maj9": (0, 4, 7, 11, 14),
    "add9": (0, 4, 7, 14),
    "madd9": (0, 3, 7, 14),
}
_ALSO = {"maj": "", "M": "", "min": "m", "-": "m", "min7": "m7", "M7": "maj7", "+": "aug"}
_CHORD = re.compile(r"([A-G])([#♯b♭]?)(\S*)")


@dataclass(frozen=True, slots=True)
class Chord:
    """A root and what sounds above it.

    Attributes:
        root: pitch class, 0 for C to 11 for B.
        intervals: ascending semitones above the root, the first 0.
    """

    root: int
    intervals: tuple[int, ...]

    def near(self, pitch: int) -> tuple[int, ...]:
        """Return its MIDI pitches with the root that is nearest to a pitch; the lower of two."""
        above = (self.root - pitch) % 12
        root = pitch + (above if above < 6 else above - 12)
        pitches = [root + interval for interval in self.intervals]
        while pitches[0] < 0:
            pitches = [each + 12 for each in pitches]
        while pitches[-1] > 127:
            pitches = [each - 12 for each in pitches]
        return tuple(pitches)

    def scale(self) -> Scale:
        """Return its pitch classes as a scale."""
        return Scale(self.root, tuple(sorted({interval % 12 for interval in self.intervals})))


def parse_chord(text: str) -> Chord:
    """Read a chord such as "Am7", "F#maj7" or "Bb".

    Raises:
        ValueError: the text names no root or no known kind; says what is allowed.
    """
    match = _CHORD.fullmatch(text.strip())
    if match is None:
        raise ValueError(
            f"a chord is a root and a kind without a space, such as Am7, C or Bbsus4; got {text!r} "
            f"({_allowed()})"
        )
    letter, sign, kind = match.groups()
    kind = _ALSO.get(kind, kind)
    if kind not in KINDS:
        near = nearest(kind, [each for each in KINDS if each])
        hint = f"; did you mean '{letter}{sign}{near}'?" if near else ""
        raise ValueError(f"unknown chord {text!r}{hint} ({_allowed()})")
    return Chord(pitch_class(letter, sign), KINDS[kind])


def _allowed() -> str:
    kinds = ", ".join(kind for kind in KINDS if kind)
    return f"roots: C, C#, Db ... B; kinds: none for major, {kinds}"


@cache
def parse_steps(text: str) -> Scale:
    """Read a scale, or a chord whose notes are to be the steps of one.

    Raises:
        ValueError: the text is neither; says what is allowed.
    """
    if _CHORD.fullmatch(text.strip()) is not None:
        return parse_chord(text).scale()
    return parse_scale(text)
