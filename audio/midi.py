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
from audio.placed import Losses, Placed
from audio.quantising import Shifts
from audio.score import Score, ScoreEvent
from audio.tracks import name, note_messages, track
from audio.velocities import velocity_of
from audio.voices import Note, Voiced, voiced

# Directions are told apart in steps of 16 of 127: finer ones would need more channels.
_PAN_STEP = 16
# And shares of the reverb in steps of 32, 6 dB about the middle.
_SEND_STEP = 32
_TAIL_SECONDS = 0.4


@dataclass(frozen=True, slots=True)
class MidiReport:
    """What a MIDI file holds.

    Attributes:
        path: of the file.
        changed: whether the file was written; False if it held these bytes already.
        notes: notes played.
        muted: events that the author silenced.
        added: notes of chords and phrases beyond the first of each event.
        after_the_end: notes of phrases left out because they begin after the last frame.
        merged: events that a note of another one stands for, which begins with them.
        merged_by_frame: of which frames those are, and how many each.
        moved: notes heard from a neighbouring direction for want of channels.
        reverbs: notes heard with another share of the reverb for want of channels.
        cut_short: notes ended early so that another can be struck.
        tails_cut: channels taken over while their last note still rang.
        stiff: notes that last, without pitch bend and expression for want of channels.
        shifts: how far the quantisation moved notes.
    """

    path: Path
    changed: bool
    notes: int
    muted: int
    added: int
    after_the_end: int
    merged: int
    moved: int
    reverbs: int
    cut_short: int
    tails_cut: int
    stiff: int
    shifts: Shifts
    merged_by_frame: dict[int, int] = field(default_factory=dict)


def write_midi(score: Score, path: Path) -> MidiReport:
    """Write a score as MIDI; an equal file is left alone, and on failure the earlier one stays.

    Raises:
        GridError: the frame rate has no exact grid.
        ScoreError: an event lies outside the score, or the score is too long for the format.
        SoundFileError: the file could not be written.
    """
    path = Path(path)
    data, spoken, played, losses = _encode(score)
    opened = sum(note.opens for note in spoken.notes)
    grid = grid_of(score.rate)
    return MidiReport(
        path=path,
        changed=put(path, data),
        notes=played,
        muted=len(score.events) - opened,
        added=len(spoken.notes) - opened,
        after_the_end=spoken.after_the_end,
        merged=len(losses.merged),
        moved=losses.moved,
        reverbs=losses.reverbs,
        cut_short=losses.cut_short,
        tails_cut=losses.tails_cut,
        stiff=losses.stiff,
        shifts=spoken.shifts,
        merged_by_frame=dict(sorted(Counter(map(grid.frame_at, losses.merged)).items())),
    )


def midi_bytes(score: Score) -> bytes:
    """Return the MIDI file of a score; raises as `write_midi` does."""
    return _encode(score)[0]


def _encode(score: Score) -> tuple[bytes, Voiced, int, Losses]:
    grid = grid_of(score.rate)
    spoken = voiced(score)
    notes = spoken.notes
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
    return out.getvalue(), spoken, len(played), losses


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
                pan=_pan(note.side),
                send=_send(note.send),
                pitch=note.pitch,
                velocity=velocity_of(note.level),
                gesture=() if note.drum else gesture_of(note.event, grid, start, end),
                drum=note.drum,
            )
        )
    # Louder first within a tick and track, so that what is lost for want of channels is faint.
    wanted.sort(key=_before)
    return allocate(wanted, grid.ticks(_TAIL_SECONDS))


def _before(note: Placed) -> tuple[int, ...]:
    sound = (note.program, note.pitch, note.pan, note.send)
    return (note.start, note.track, -note.velocity, *sound, note.end)


def _pan(side: float) -> int:
    steps = 64 // _PAN_STEP
    return min(64 + _PAN_STEP * floor(side * steps + 0.5), 127)


def _send(share: float) -> int:
    steps = 128 // _SEND_STEP
    return min(_SEND_STEP * floor(share * steps + 0.5), 127)
