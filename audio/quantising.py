"""Quantisation: onsets drawn to the grid of a tempo, and how far that moved them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import floor

from audio.quantise_words import QuantiseWords, beats_of
from audio.score import Score


@dataclass(frozen=True, slots=True)
class Shifts:
    """How far onsets were moved.

    Attributes:
        asked: events that the grid is for.
        moved: those that are heard at another time than without it.
        earlier: those of them that are heard before their cause is shown.
        mean: of the sizes of the shifts of all that were moved [s].
        greatest: size of the largest [s].
    """

    asked: int = 0
    moved: int = 0
    earlier: int = 0
    mean: Fraction = Fraction(0)
    greatest: Fraction = Fraction(0)


def shifts_of(shifts: Sequence[Fraction]) -> Shifts:
    """Return what is told of the shifts of all events that the grid is for [s]."""
    sizes = [abs(shift) for shift in shifts if shift]
    return Shifts(
        asked=len(shifts),
        moved=len(sizes),
        earlier=sum(shift < 0 for shift in shifts),
        mean=sum(sizes, Fraction(0)) / max(len(sizes), 1),
        greatest=max(sizes, default=Fraction(0)),
    )


def quantised(onset: Fraction, words: QuantiseWords, score: Score) -> Fraction:
    """Return where an onset is drawn to [s], on a whole frame unless sounds stand below frames.

    An onset stays where no place of the grid lies within the film on the side that is allowed.
    """
    places = _places(onset, words, score)
    if words.mode == "next":
        places = [place for place in places if place >= onset]
    if not places:
        return onset
    # Of two as near the later: what is heard before it is seen is odd, the other way usual.
    place = min(places, key=lambda place: (abs(place - onset), -place))
    drawn = onset + Fraction(str(words.strength)) * (place - onset)
    return drawn if score.subframe else on_frame(drawn, score.rate)


def on_frame(time: Fraction, rate: Fraction) -> Fraction:
    """Return the time of the nearest frame [s], the later of two as near."""
    return floor(time * rate + Fraction(1, 2)) / rate


def _places(onset: Fraction, words: QuantiseWords, score: Score) -> list[Fraction]:
    """Return the places of the grid about an onset, those within the film."""
    beat = 60 / Fraction(str(score.sound.tempo_bpm))
    pair = 2 * beat * beats_of(words.grid)
    offset = Fraction(str(words.offset))
    second = Fraction(str(words.swing)) * pair
    about = floor((onset - offset) / pair)
    near = [offset + (about + k) * pair + part for k in (-1, 0, 1, 2) for part in (0, second)]
    # On the last frame a note still stands; below frames anywhere before the film's end.
    last = (score.frames - 1) / score.rate
    end = score.frames / score.rate
    return [at for at in near if 0 <= at and (at < end if score.subframe else at <= last)]
