"""Chord symbols: named chords, and numerals that stand for chords of a scale."""

from __future__ import annotations

import re
from dataclasses import dataclass

from audio.harmony import Chord, Scale, parse_chord

_NUMERALS = ("i", "ii", "iii", "iv", "v", "vi", "vii")
_NUMERAL = re.compile(r"(VII|VI|V|IV|III|II|I|vii|vi|v|iv|iii|ii|i)(7?)")
_MINOR_THIRD, _MAJOR_THIRD = 3, 4


@dataclass(frozen=True, slots=True)
class Numeral:
    """A chord by its step of the scale.

    Attributes:
        step: of its root, from 0.
        is_major: whether it is written in capitals.
        has_seventh: whether a seventh is added.
    """

    step: int
    is_major: bool
    has_seventh: bool

    def chord(self, scale: Scale) -> Chord:
        """Return the chord in a scale: thirds piled up, the first as the letters say.

        Raises:
            ValueError: the scale has not seven steps.
        """
        steps = scale.intervals
        if len(steps) != len(_NUMERALS):
            raise ValueError("a numeral needs a scale of seven steps, such as A minor")
        root = scale.pitch(self.step)
        tones = [scale.pitch(self.step + up) - root for up in (0, 2, 4, 6)[: 3 + self.has_seventh]]
        if tones[1] in (_MINOR_THIRD, _MAJOR_THIRD):
            tones[1] = _MAJOR_THIRD if self.is_major else _MINOR_THIRD
        return Chord(root % 12, tuple(tones))


def parse_symbol(text: str) -> Chord | Numeral:
    """Parse a chord such as "Am7", or a numeral such as "iv" or "V7".

    Raises:
        ValueError: the text is neither; the message names the nearest.
    """
    match = _NUMERAL.fullmatch(text)
    if match is not None:
        step = _NUMERALS.index(match[1].lower())
        return Numeral(step, match[1].isupper(), bool(match[2]))
    try:
        return parse_chord(text)
    except ValueError as error:
        raise ValueError(f"{error}, or a numeral of the scale: I to VII, i to vii, V7") from None
