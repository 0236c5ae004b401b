"""Musical scales by name, and note names."""

from __future__ import annotations

import re
from dataclasses import dataclass

from audio.names import folded, unknown

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

_LETTERS = {"c": 0, "d": 2, "e": 4, "f": 5, "g": 7, "a": 9, "b": 11}
_SIGNS = {"": 0, "#": 1, "♯": 1, "b": -1, "♭": -1}
_SCALE = re.compile(r"([A-Ga-g])([#♯b♭]?)\s+(.+)")
_NOTE = re.compile(r"([A-Ga-g])([#♯b♭]?)(-?\d+)")


@dataclass(frozen=True, slots=True)
class Scale:
    """A root and the steps above it.

    Attributes:
        root: pitch class, 0 for C to 11 for B.
        intervals: ascending semitones above the root, the first 0.
    """

    root: int
    intervals: tuple[int, ...]

    def holds(self, pitch: int) -> bool:
        """Say whether a MIDI pitch belongs to the scale."""
        return (pitch - self.root) % 12 in self.intervals

    def pitch(self, degree: int) -> int:
        """Return the MIDI pitch of a degree; degree 0 is the root in octave -1 (MIDI 0 to 11)."""
        octave, step = divmod(degree, len(self.intervals))
        return self.root + 12 * octave + self.intervals[step]

    def degree(self, pitch: float) -> int:
        """Return the degree whose pitch is nearest; the lower one where two are as near."""
        guess = int((pitch - self.root) // 12) * len(self.intervals)
        near = range(guess - 1, guess + len(self.intervals) + 2)
        return min(near, key=lambda degree: abs(self.pitch(degree) - pitch))


def parse_scale(text: str) -> Scale:
    """Read a scale such as "C minor pentatonic", "A dorian" or "chromatic".

    Raises:
        ValueError: the text names no root or no known scale; says what is allowed.
    """
    if folded(text) == "chromatic":
        return Scale(0, MODES["chromatic"])
    match = _SCALE.fullmatch(text.strip())
    if match is None:
        raise ValueError(
            f"a scale is a root and a kind, such as 'C minor pentatonic', or 'chromatic'; "
            f"got {text!r} (roots: C, C#, Db ... B; kinds: {', '.join(MODES)})"
        )
    letter, sign, kind = match.groups()
    if folded(kind) not in MODES:
        raise ValueError(unknown("scale", kind, MODES))
    return Scale(pitch_class(letter, sign), MODES[folded(kind)])


def pitch_class(letter: str, sign: str) -> int:
    """Return the pitch class of a letter and a sharp, a flat or nothing: 0 for C to 11 for B."""
    return (_LETTERS[letter.lower()] + _SIGNS[sign]) % 12


def parse_note(text: str) -> int:
    """Read a note name as a MIDI pitch; C4 is 60, and -1 the lowest octave.

    Raises:
        ValueError: the text is no note name, or lies outside C-1 to G9.
    """
    match = _NOTE.fullmatch(text.strip())
    if match is None:
        raise ValueError(f"{text!r} is no note name; write C4, F#3, Bb5")
    letter, sign, octave = match.groups()
    pitch = 12 * (int(octave) + 1) + _LETTERS[letter.lower()] + _SIGNS[sign]
    if not 0 <= pitch <= 127:
        raise ValueError(f"note {text!r} lies outside C-1 to G9")
    return pitch
