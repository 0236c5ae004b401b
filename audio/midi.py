"""Score -> MIDI file of type 1, its notes on the frames that caused them."""

from __future__ import annotations

import io
from collections import Counter
from dataclasses import dataclass, field
from math import floor
from pathlib import Path

import mido

from audio.channels import allocate
from audio.conductor import conductor
from audio.files import put
from audio.gestures import gesture_of
from audio.grid import Grid, grid_of
from audio.heard import pan_of
from audio.placed import Losses, Placed
from audio.score import Score, ScoreEvent
from audio.tracks import name, note_messages, track
from audio.voices import Note, notes_of

# Directions are told apart in steps of 16 of 127: finer ones would need more channels.
_PAN_STEP = 16
# The peak that full velocity stands for [dBFS]; a synthesiser's loudness follows
# 40 log10(velocity / 127). Source: MMA DLS 1999.
_FULL_VELOCITY_DB = -4.0
_TAIL_SECONDS = 0.4


@dataclass(frozen=True, slots=True)
class MidiReport:
    """What a MIDI file holds.

    Attributes:
        path: of the file.
        changed: whether the file was written; False if it held these bytes already.
        notes: notes played.
        muted: events that the author silenced.
        merged: events that a note of another one stands for, which begins with them.
        merged_by_frame: of which frames those are, and how many each.
        moved: notes heard from a neighbouring direction for want of channels.
        cut_short: notes ended early so that another can be struck.
        tails_cut: channels taken over while their last note still rang.
        stiff: notes that last, without pitch bend and expression for want of channels.
    """

    path: Path
    changed: bool
    notes: int
    muted: int
    merged: int
    moved: int
    cut_short: int
    tails_cut: int
    stiff: int
    merged_by_frame: dict[int, int] = field(default_factory=dict)


def write_midi(score: Score, path: Path) -> MidiReport:
    """Write a score as MIDI; an equal file is left alone, and on failure the earlier one stays.

    Raises:
        GridError: the frame rate has no exact grid.
        ScoreError: an event lies outside the score, or the score is too long for the format.
        SoundFileError: the file could not be written.
    """
    path = Path(path)
    data, notes, played, losses = _encode(score)
    grid = grid_of(score.rate)
    return MidiReport(
        path=path,
        changed=put(path, data),
        notes=played,
        muted=len(score.events) - notes,
        merged=len(losses.merged),
        moved=losses.moved,
        cut_short=losses.cut_short,
        tails_cut=losses.tails_cut,
        stiff=losses.stiff,
        merged_by_frame=dict(sorted(Counter(map(grid.frame_at, losses.merged)).items())),
    )


def midi_bytes(score: Score) -> bytes:
    """Return the MIDI file of a score; raises as `write_midi` does."""
    return _encode(score)[0]


def _encode(score: Score) -> tuple[bytes, int, int, Losses]:
    grid = grid_of(score.rate)
    notes = notes_of(score)
    names = sorted({_track_of(score, note.event) for note in notes})
    played, losses = _placed(score, grid, notes, names)
    end = grid.tick(score.frames + 1)
    tracks = [track(conductor(score, grid, notes), end)]
    for index, own in enumerate(names):
        messages = note_messages([note for note in played if note.track == index])
        tracks.append(track([name(own), *messages], end))
    file = mido.MidiFile(type=1, ticks_per_beat=grid.ticks_per_beat, charset="utf-8", tracks=tracks)
    out = io.BytesIO()
    file.save(file=out)
    return out.getvalue(), len(notes), len(played), losses


def _track_of(score: Score, event: ScoreEvent) -> str:
    return event.who if score.sound.tracks == "performer" else event.cause


def _placed(
    score: Score, grid: Grid, notes: tuple[Note, ...], names: list[str]
) -> tuple[list[Placed], Losses]:
    numbers = {own: index for index, own in enumerate(names)}
    last = grid.tick(score.frames + 1)
    wanted = []
    for note in notes:
        # A note is a tick long at least, also one at the last half tick of all.
        start = min(grid.tick_at(note.onset), last - 1)
        end = min(start + grid.ticks(note.seconds), last)
        wanted.append(
            Placed(
                track=numbers[_track_of(score, note.event)],
                start=start,
                end=end,
                program=note.program,
                pan=_pan(note.event),
                pitch=note.pitch,
                velocity=_velocity(note.level),
                gesture=() if note.drum else gesture_of(note.event, grid, start, end),
                drum=note.drum,
            )
        )
    # Louder first within a tick and track, so that what is lost for want of channels is faint.
    wanted.sort(key=lambda n: (n.start, n.track, -n.velocity, n.program, n.pitch, n.pan, n.end))
    return allocate(wanted, grid.ticks(_TAIL_SECONDS))


def _pan(event: ScoreEvent) -> int:
    steps = 64 // _PAN_STEP
    return min(64 + _PAN_STEP * floor(pan_of(event) * steps + 0.5), 127)


def _velocity(level: float) -> int:
    return min(max(round(127 * 10 ** ((level - _FULL_VELOCITY_DB) / 40)), 1), 127)
