"""Swing: the second of two steps comes later than half-way."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from audio.music.piece import Bar


@dataclass(frozen=True, slots=True)
class Swing:
    """How beats of bars are moved.

    Attributes:
        share: of the first of two steps, 1/2 for none.
        step: [beats].
    """

    share: Fraction = Fraction(1, 2)
    step: Fraction = Fraction(1, 2)

    def beat(self, beat: Fraction, bars: Sequence[Bar]) -> Fraction:
        """Return where a beat is moved to.

        Halves and quarters of a step move with it; what is no such part of one, as the notes of a
        triplet, stays, and so does a step that has no second in its bar.

        Args:
            beat: of the score.
            bars: of the section, in the order of time.
        """
        if self.share == Fraction(1, 2) or not bars:
            return beat
        bar = bars[max(bisect_right(bars, beat, key=lambda each: each.beat) - 1, 0)]
        steps = (beat - bar.beat) / self.step
        if (4 * steps).denominator != 1:
            return beat
        pair, place = divmod(steps, 2)
        if (2 * pair + 2) * self.step > bar.beats:
            return beat
        if place <= 1:
            moved = 2 * self.share * place
        else:
            moved = 2 * self.share + 2 * (1 - self.share) * (place - 1)
        return bar.beat + (2 * pair + moved) * self.step
