"""Harmony: note names, scales and chords."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache

from audio.names import UnknownName, nearest_name, normalized_name

# Semitones above the root.
MODES: dict[str, tuple[int, ...]] = {
    "major": (0, 2, 4, 5, 7, 9, 11),
    "minor": (0, 2, 3, 5, 7, 8, 10),
    "ionian": (0, 2, 4, 5, 7, 9, 11),
    "dorian": (0, 2, 3, 5, 7, 9, 10),
    "phrygian": (0, 1, 3, 5, 7, 8, 10),
    "lydian": (0, 2, 4, 6, 7, 9, 11),
    "mixolydian": (0, 2, 4, 5, 7, 9, 10),
    "aeolian": (0, 2, 3, 5, 7, 8, 10),
    "locrian": (0, 1, 3, 5, 6, 8, 10),
    "harmonic minor": (0, 2, 3, 5, 7, 8, 11),
    "melodic minor": (0, 2, 3, 5, 7, 9, 11),
    "major pentatonic": (0, 2, 4, 7, 9),
    "minor pentatonic": (0, 3, 5, 7, 10),
    "blues": (0, 3, 5, 6, 7, 10),
    "hirajoshi": (0, 2, 3, 7, 8),
    "whole tone": (0, 2, 4, 6, 8, 10),
    "chromatic": tuple(range(12)),
}

# Semitones above the root, in close position.
CHORD_KINDS: dict[str, tuple[int, ...]] = {
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
_ALIASES = {"maj": "", "M": "", "min": "m", "-": "m", "min7": "m7", "M7": "maj7", "+": "aug"}

_LETTERS = {"c": 0, "d": 2, "e": 4, "f": 5, "g": 7, "a": 9, "b": 11}
_ACCIDENTALS = {"": 0, "#": 1, "♯": 1, "b": -1, "♭": -1}
_SCALE = re.compile(r"([A-Ga-g])([#♯b♭]?)\s+(.+)")
_NOTE = re.compile(r"([A-Ga-g])([#♯b♭]?)(-?\d+)")
_CHORD = re.compile(r"([A-G])([#♯b♭]?)(\S*)")


@dataclass(frozen=True, slots=True)
class Scale:
    """A root and the scale steps above it.

    Attributes:
        root: pitch class, 0 for C to 11 for B.
        intervals: ascending semitones above the root, the first 0.
    """

    root: int
    intervals: tuple[int, ...]

    def pitch(self, degree: int) -> int:
        """Return the MIDI pitch of a degree; degree 0 is the root in octave -1 (MIDI 0 to 11)."""
        octave, step = divmod(degree, len(self.intervals))
        return self.root + 12 * octave + self.intervals[step]

    def degree(self, pitch: float) -> int:
        """Return the degree with the nearest pitch; the lower of two equally near."""
        guess = int((pitch - self.root) // 12) * len(self.intervals)
        near = range(guess - 1, guess + len(self.intervals) + 2)
        return min(near, key=lambda degree: abs(self.pitch(degree) - pitch))


@dataclass(frozen=True, slots=True)
class Chord:
    """A root and the intervals above it.

    Attributes:
        root: pitch class, 0 for C to 11 for B.
        intervals: ascending semitones above the root, the first 0.
    """

    root: int
    intervals: tuple[int, ...]

    def near(self, pitch: int) -> tuple[int, ...]:
        """Return its MIDI pitches with the root nearest to a pitch, the lower of two."""
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


def _pitch_class(letter: str, accidental: str) -> int:
    return (_LETTERS[letter.lower()] + _ACCIDENTALS[accidental]) % 12


def fold_pitch(pitch: int, lowest: int = 0, highest: int = 127) -> int:
    """Return a pitch moved by octaves into a range of one octave or more."""
    while pitch > highest:
        pitch -= 12
    while pitch < lowest:
        pitch += 12
    return pitch


def parse_note(text: str) -> int:
    """Parse a note name to a MIDI pitch; C4 is 60, and -1 the lowest octave.

    Raises:
        ValueError: the text is not a note name, or lies outside C-1 to G9.
    """
    match = _NOTE.fullmatch(text.strip())
    if match is None:
        raise ValueError(f"{text!r} is no note name; write C4, F#3, Bb5")
    letter, accidental, octave = match.groups()
    pitch = 12 * (int(octave) + 1) + _LETTERS[letter.lower()] + _ACCIDENTALS[accidental]
    if not 0 <= pitch <= 127:
        raise ValueError(f"note {text!r} lies outside C-1 to G9")
    return pitch


def parse_scale(text: str) -> Scale:
    """Parse a scale such as "C minor pentatonic", "A dorian" or "chromatic".

    Raises:
        ValueError: the text has no root or no known kind; the message lists what is allowed.
    """
    if normalized_name(text) == "chromatic":
        return Scale(0, MODES["chromatic"])
    match = _SCALE.fullmatch(text.strip())
    if match is None:
        raise ValueError(
            f"a scale is a root and a kind, such as 'C minor pentatonic', or 'chromatic'; "
            f"got {text!r} (roots: C, C#, Db ... B; kinds: {', '.join(MODES)})"
        )
    letter, accidental, kind = match.groups()
    if normalized_name(kind) not in MODES:
        raise UnknownName("scale", kind, MODES)
    return Scale(_pitch_class(letter, accidental), MODES[normalized_name(kind)])


def parse_chord(text: str) -> Chord:
    """Parse a chord such as "Am7", "F#maj7" or "Bb".

    Raises:
        ValueError: the text has no root or no known kind; the message lists what is allowed.
    """
    match = _CHORD.fullmatch(text.strip())
    kinds = ", ".join(kind for kind in CHORD_KINDS if kind)
    allowed = f"roots: C, C#, Db ... B; kinds: none for major, {kinds}"
    if match is None:
        raise ValueError(
            f"a chord is a root and a kind without a space, such as Am7, C or Bbsus4; got {text!r} "
            f"({allowed})"
        )
    letter, accidental, kind = match.groups()
    kind = _ALIASES.get(kind, kind)
    if kind not in CHORD_KINDS:
        near = nearest_name(kind, [each for each in CHORD_KINDS if each])
        hint = f"; did you mean '{letter}{accidental}{near}'?" if near else ""
        raise ValueError(f"unknown chord {text!r}{hint} ({allowed})")
    return Chord(_pitch_class(letter, accidental), CHORD_KINDS[kind])


@cache
def parse_steps(text: str) -> Scale:
    """Parse a scale, or a chord whose notes become the steps of a scale.

    Raises:
        ValueError: the text is neither; the message lists what is allowed.
    """
    if _CHORD.fullmatch(text.strip()) is not None:
        return parse_chord(text).scale()
    return parse_scale(text)


MIDDLE_C = 60
"""MIDI pitch of C4."""


def frequency_of(pitch: float) -> float:
    """Return the frequency of a MIDI pitch in equal temperament, A4 at 440 Hz [Hz]."""
    return float(440 * 2 ** ((pitch - 69) / 12))
