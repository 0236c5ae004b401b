"""Tempo plan: the tempo, meter and bars of a score.

They are those of the scene, else those of its dance, else those of its events where they have a
pulse. A piece without any has an even grid instead of beats.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from audio.beat_clock import BeatClock, beat_clock
from audio.config.meter import bar_length, parse_meter
from audio.pulse import fit_pulse, nearest_phase
from audio.score import Score
from audio.time_grid import TickGrid, tick_grid
from audio.voice_selection import voice_of

TempoSource = Literal["scene", "dance", "song", "events", "music", "none"]


@dataclass(frozen=True, slots=True)
class TempoPlan:
    """Beats of a score.

    Attributes:
        source: what the tempo is from.
        clock: times of beats; without a tempo those in which phrases count.
        grid: ticks of the file.
    """

    source: TempoSource
    clock: BeatClock
    grid: TickGrid

    def grid_distances(self, onsets: Sequence[Fraction], beats: Fraction) -> NDArray[np.float64]:
        """Return the distances of onsets from a grid of the file's beats [frames].

        Args:
            onsets: times [s].
            beats: length of a grid step.
        """
        grid = self.grid
        unit = grid.ticks_per_beat * beats
        distances = []
        for onset in onsets:
            steps = round((grid.tick_at(onset) - grid.bar_line) / unit)
            line = grid.seconds(grid.bar_line + round(steps * unit))
            distances.append(float((onset - line) * grid.rate))
        return np.array(distances)


def tempo_plan(score: Score) -> TempoPlan:
    """Return the beats of a score.

    Raises:
        GridError: the frame rate has no grid.
    """
    sound, dance = score.sound, score.dance
    if sound.counts_beats:
        tempo = Fraction(str(sound.beats_per_minute))
        return _planned(score, "scene", tempo, _first_bar(score, tempo))
    if dance is not None:
        start = dance.start if sound.first_bar is None else Fraction(str(sound.first_bar))
        return _planned(score, "dance", dance.tempo, start)
    if score.song is not None:
        tempo = score.song.tempo
        return _planned(score, "song", tempo, _first_bar(score, tempo))
    pulse = _pulse(score)
    if pulse is None and sound.music is not None:
        tempo = Fraction(str(sound.beats_per_minute))
        return _planned(score, "music", tempo, _first_bar(score, tempo))
    if pulse is None:
        tempo = Fraction(str(sound.beats_per_minute))
        clock = beat_clock(tempo, Fraction(0), _meter(score))
        return TempoPlan("none", clock, tick_grid(score.rate))
    beat, start = pulse
    clock = beat_clock(60 * score.rate / beat, start / score.rate, _meter(score))
    # A bar line before the film would have no tick, and one within the first frame no pickup. The
    # pickup begins with the film, so its beats are not quite even: one has no onset within it.
    line = start if start >= 1 or start == 0 else start + beat
    return TempoPlan("events", clock, tick_grid(score.rate, clock, line))


def _planned(score: Score, source: TempoSource, tempo: Fraction, start: Fraction) -> TempoPlan:
    """Return the plan of a written tempo whose bar 1 is at a time [s]."""
    clock = beat_clock(tempo, start, _meter(score), score.sound.tempo_map)
    line = Fraction(round(start * score.rate))
    if line < 0:
        bar = bar_length(_meter(score)) * 60 * score.rate / tempo
        line += -(line // bar) * bar
    if not (score.sound.tempo_map or score.sound.quantise):
        # Moves by whole ticks keep frames and beats whole.
        tick = 1 / tick_grid(score.rate, clock, line).ticks_per_frame
        moved = nearest_phase(_onset_frames(score), 60 * score.rate / tempo, line, tick)
        line = moved if moved >= 1 else line
    return TempoPlan(source, clock, tick_grid(score.rate, clock, line))


def _meter(score: Score) -> tuple[int, int]:
    if score.sound.meter is not None:
        return parse_meter(score.sound.meter)
    return score.dance.meter if score.dance is not None else (4, 4)


def _first_bar(score: Score, tempo: Fraction) -> Fraction:
    """Return the time of bar 1 [s]."""
    sound, dance = score.sound, score.dance
    if sound.first_bar is not None or sound.quantise is not None:
        return Fraction(str(sound.beat_origin))
    if dance is not None:
        return dance.start
    frames = _onset_frames(score)
    return Fraction(int(frames[0])) / score.rate if frames.size else Fraction(0)


def _pulse(score: Score) -> tuple[Fraction, Fraction] | None:
    """Return length and start of the beats on which events fall [frames]; None if on none.

    Sustained sounds count only where they share the pulse of the impacts.
    """
    for durations in (True, False):
        pulse = fit_pulse(_onset_frames(score, sustained=durations), score.rate)
        if pulse is not None:
            return pulse.beat, pulse.start
    return None


def _onset_frames(score: Score, sustained: bool = True) -> NDArray[np.int64]:
    """Return the frames, from 0, of all events that are heard and may be on a beat, sorted."""
    heard = [
        event.frame - 1
        for event in score.events
        if not event.is_passing
        and (sustained or event.duration == 0)
        and not voice_of(score.sound, event).mute
    ]
    return np.array(sorted(heard), dtype=np.int64)
