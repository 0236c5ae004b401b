"""Quantisation: onsets moved to the grid of a tempo, and statistics of the shifts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import floor

from audio.beat_clock import BeatClock
from audio.config.quantisation import Quantisation, beats_of_grid
from audio.score import Score
from audio.time_grid import nearest_frame_time


@dataclass(frozen=True, slots=True)
class TimingShifts:
    """Statistics of the shifts of onsets.

    Attributes:
        events: number of quantised events.
        moved: number of events that moved.
        earlier: number of events that sound before their cause is shown.
        mean: mean absolute shift of those that moved [s].
        greatest: greatest absolute shift [s].
    """

    events: int = 0
    moved: int = 0
    earlier: int = 0
    mean: Fraction = Fraction(0)
    greatest: Fraction = Fraction(0)


def timing_shifts(shifts: Sequence[Fraction]) -> TimingShifts:
    """Return the statistics of the shifts of all quantised events [s]."""
    sizes = [abs(shift) for shift in shifts if shift]
    return TimingShifts(
        events=len(shifts),
        moved=len(sizes),
        earlier=sum(shift < 0 for shift in shifts),
        mean=sum(sizes, Fraction(0)) / max(len(sizes), 1),
        greatest=max(sizes, default=Fraction(0)),
    )


def quantise(onset: Fraction, config: Quantisation, score: Score, clock: BeatClock) -> Fraction:
    """Return a quantised onset [s], on a whole frame unless the score is exact below frames.

    An onset stays if no grid point lies within the film on the allowed side.

    Args:
        onset: time of the event [s].
        config: of the quantisation.
        score: its rate, length and whether it is exact below frames.
        clock: times of beats.
    """
    points = _grid_points(onset, config, score, clock)
    if config.mode == "next":
        points = [point for point in points if point >= onset]
    if not points:
        return onset
    # Of two equally near the later: sound after its cause is natural, sound before it is not.
    point = min(points, key=lambda point: (abs(point - onset), -point))
    moved = onset + Fraction(str(config.strength)) * (point - onset)
    return moved if score.subframe else nearest_frame_time(moved, score.rate)


def _grid_points(
    onset: Fraction, config: Quantisation, score: Score, clock: BeatClock
) -> list[Fraction]:
    """Return the grid points around an onset within the film."""
    pair = 2 * beats_of_grid(config.grid)
    second = Fraction(str(config.swing)) * pair
    nearest = floor(clock.beat(onset) / pair)
    beats = [(nearest + k) * pair + part for k in (-1, 0, 1, 2) for part in (0, second)]
    points = [clock.time(beat) for beat in beats]
    # The last frame may hold a note; below frames, any time before the film's end may.
    last = (score.frames - 1) / score.rate
    end = score.frames / score.rate
    return [at for at in points if 0 <= at and (at < end if score.subframe else at <= last)]
