"""Tempo report: the tempo and meter of a MIDI file, and their errors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from audio.config.quantisation import beats_of_grid
from audio.notes import Note
from audio.score import Score
from audio.tempo_plan import TempoPlan, TempoSource


@dataclass(frozen=True, slots=True)
class TempoReport:
    """Tempo and meter of a MIDI file.

    Attributes:
        source: what the tempo is from.
        bpm: quarter notes a minute of bar 1; without a tempo those of the file's even grid.
        meter: of bar 1, such as "4/4".
        first_bar: time of bar 1 in the film [s].
        ticks_per_beat: division of the file.
        ticks_per_frame: of the last tempo; may be a fraction.
        changes: number of tempo events.
        frame_error: greatest distance of a note's time in the file from its time in the film [s].
        beat_error: distance of the last beat of the file from that of the exact tempo [s].
        grid: note value of the quantisation, or a sixteenth.
        on_grid: share of the notes within half a frame of that grid, without those that a dance
            makes in passing; None without a tempo.
        passing: number of the latter.
    """

    source: TempoSource
    bpm: Fraction
    meter: str
    first_bar: Fraction
    ticks_per_beat: int
    ticks_per_frame: Fraction
    changes: int
    frame_error: Fraction
    beat_error: Fraction
    grid: str
    on_grid: float | None
    passing: int


def tempo_report(score: Score, plan: TempoPlan, notes: Sequence[Note]) -> TempoReport:
    """Return the report of a score's tempo.

    Args:
        score: the score.
        plan: its tempo, meter and bars.
        notes: of its events.
    """
    grid = plan.grid
    end = grid.tick(score.frames + 1)
    track = grid.tempo_track(end)
    times = {*(note.onset for note in notes), score.frames / score.rate}
    errors = [abs(track.seconds(grid.tick_at(time)) - time) for time in times]
    has_beats = plan.source != "none"
    beats = plan.clock.beat(score.frames / score.rate)
    bpm = 60 / plan.clock.spans[0].length if has_beats else 60_000_000 / grid.tempo
    step = score.sound.quantise.grid if score.sound.quantise is not None else "1/16"
    on_grid = None
    meant = [note.onset for note in notes if not note.event.is_passing]
    if has_beats and meant:
        distances = np.abs(plan.grid_distances(meant, beats_of_grid(step)))
        on_grid = float((distances <= 0.5 + 1e-9).mean())
    return TempoReport(
        source=plan.source,
        bpm=bpm,
        meter="{}/{}".format(*plan.clock.meters[0].meter),
        first_bar=grid.seconds(grid.bar_line),
        ticks_per_beat=grid.ticks_per_beat,
        ticks_per_frame=grid.ticks_per_frame,
        changes=len(track.events),
        frame_error=max(errors),
        beat_error=abs(grid.drift * beats) if has_beats else Fraction(0),
        grid=step,
        on_grid=on_grid,
        passing=len(notes) - len(meant),
    )
