"""Score -> MIDI file of type 1 with every note on the frame of its cause."""

from __future__ import annotations

import io
from collections import Counter
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import accumulate
from math import floor
from operator import itemgetter
from pathlib import Path

import mido

from audio.channel_allocation import AllocationLosses, ChannelNote, allocate_channels
from audio.controller_curves import controller_curve
from audio.loudness_at_listener import velocity_of_level
from audio.midi_tracks import PAN, REVERB, conductor_track, note_track
from audio.notes import Arrangement, Note, arrange
from audio.quantisation import TimingShifts
from audio.score import Score, ScoreEvent
from audio.sound_files import write_sound_file
from audio.tempo_report import TempoReport, tempo_report
from audio.time_grid import TickGrid

# Steps of the pan and reverb controllers [of 127]: finer ones would need more channels. A reverb
# step is 6 dB around the middle.
_PAN_STEP, _SEND_STEP = 16, 32
# Time for which an instrument may ring after its note's end [s].
_TAIL_SECONDS = 0.4


@dataclass(frozen=True, slots=True)
class MidiReport:
    """Contents of a MIDI file.

    Attributes:
        path: of the file.
        changed: whether the file was written; False if it held these bytes already.
        notes: number of notes played.
        muted: number of muted events.
        added: number of notes of chords and phrases beyond the first of each event.
        after_the_end: number of phrase notes dropped because they start after the last frame.
        losses: compromises made for want of channels.
        merged_by_frame: frame -> number of events that share the note of another.
        shifts: statistics of the quantisation.
        tempo: tempo, meter and their errors.
    """

    path: Path
    changed: bool
    notes: int
    muted: int
    added: int
    after_the_end: int
    losses: AllocationLosses
    merged_by_frame: dict[int, int]
    shifts: TimingShifts
    tempo: TempoReport


def write_midi(score: Score, path: Path) -> MidiReport:
    """Write a score as MIDI; an equal file is left alone, and on failure the earlier one stays.

    Raises:
        GridError: the frame rate has no grid.
        ScoreError: an event lies outside the score, or the score is too long for the format.
        SoundFileError: the file could not be written.
    """
    path = Path(path)
    data, arrangement, played, losses = _encode(score)
    events = sum(note.is_first for note in arrangement.notes)
    grid = arrangement.plan.grid
    return MidiReport(
        path=path,
        changed=write_sound_file(path, data),
        notes=played,
        muted=len(score.events) - events,
        added=len(arrangement.notes) - events,
        after_the_end=arrangement.after_the_end,
        losses=losses,
        merged_by_frame=dict(sorted(Counter(map(grid.frame_at, losses.merged)).items())),
        shifts=arrangement.shifts,
        tempo=tempo_report(score, arrangement.plan, [note.onset for note in arrangement.notes]),
    )


def midi_bytes(score: Score) -> bytes:
    """Return the MIDI file of a score; raises as `write_midi` does."""
    return _encode(score)[0]


def _encode(score: Score) -> tuple[bytes, Arrangement, int, AllocationLosses]:
    arrangement = arrange(score)
    grid = arrangement.plan.grid
    names = sorted({_track_name(score, note.event) for note in arrangement.notes})
    played, losses = _allocate(score, grid, arrangement.notes, names)
    end = grid.tick(score.frames + 1)
    tracks = [conductor_track(score, grid, arrangement.notes)]
    for index, name in enumerate(names):
        tracks.append(note_track(name, [note for note in played if note.track == index], end))
    file = mido.MidiFile(type=1, ticks_per_beat=grid.ticks_per_beat, charset="utf-8", tracks=tracks)
    out = io.BytesIO()
    file.save(file=out)
    return out.getvalue(), arrangement, len(played), losses


def _track_name(score: Score, event: ScoreEvent) -> str:
    return event.who if score.sound.tracks == "performer" else event.cause


def _allocate(
    score: Score, grid: TickGrid, notes: tuple[Note, ...], names: list[str]
) -> tuple[list[ChannelNote], AllocationLosses]:
    indices = {name: index for index, name in enumerate(names)}
    last = grid.tick(score.frames + 1)
    channel_notes = []
    for note in notes:
        # A note has at least one tick, even at the very end.
        start = min(grid.tick_at(note.onset), last - 1)
        end = min(max(grid.tick_at(note.onset + Fraction(note.seconds)), start + 1), last)
        channel_notes.append(
            ChannelNote(
                track=indices[_track_name(score, note.event)],
                start=start,
                end=end,
                program=note.program,
                pan=_pan_value(note.effective_pan),
                send=_send_value(note.send),
                pitch=note.pitch,
                velocity=velocity_of_level(note.level),
                curve=() if note.drum else controller_curve(note.event, grid, start, end),
                drum=note.drum,
            )
        )
    # Louder first within a tick and track, so that compromises affect the softest.
    channel_notes.sort(key=_order)
    return allocate_channels(
        channel_notes, round(_TAIL_SECONDS * float(score.rate * grid.ticks_per_frame))
    )


def _order(note: ChannelNote) -> tuple[int, ...]:
    sound = (note.program, note.pitch, note.pan, note.send)
    return (note.start, note.track, -note.velocity, *sound, note.end)


def _pan_value(pan: float) -> int:
    steps = 64 // _PAN_STEP
    return min(64 + _PAN_STEP * floor(pan * steps + 0.5), 127)


def _send_value(share: float) -> int:
    steps = 128 // _SEND_STEP
    return min(_SEND_STEP * floor(share * steps + 0.5), 127)


# Pan of a channel before its first change.
_CENTRE = 64


@dataclass(frozen=True, slots=True, order=True)
class NoteOn:
    """The onset of a note in a MIDI file.

    Attributes:
        tick: absolute.
        track: its name.
        channel: 0 to 15.
        pitch: 0 to 127.
        velocity: 1 to 127.
        ticks: length.
        program: of its channel at the onset.
        pan: of its channel at the onset, 0 to 127.
        send: of its channel to the reverb at the onset, 0 to 127.
    """

    tick: int
    track: str
    channel: int
    pitch: int
    velocity: int
    ticks: int = 0
    program: int = 0
    pan: int = _CENTRE
    send: int = 0


def read_note_list(data: bytes) -> tuple[NoteOn, ...]:
    """Return the notes of a MIDI file in the order of their ticks."""
    timed = []
    for track in mido.MidiFile(file=io.BytesIO(data), charset="utf-8").tracks:
        ticks = accumulate(message.time for message in track)
        timed += [(tick, track.name, message) for tick, message in zip(ticks, track, strict=True)]
    # Tracks share channels, so the setting of a channel may stand in another track.
    timed.sort(key=itemgetter(0))
    programs: dict[int, int] = {}
    controllers: dict[tuple[int, int], int] = {}
    sounding: dict[tuple[str, int, int], NoteOn] = {}
    notes = []
    for tick, name, message in timed:
        if message.type == "program_change":
            programs[message.channel] = message.program
        elif message.type == "control_change":
            controllers[message.channel, message.control] = message.value
        elif message.type in ("note_on", "note_off"):
            key = (name, message.channel, message.note)
            if key in sounding:
                started = sounding.pop(key)
                notes.append(replace(started, ticks=tick - started.tick))
            if message.type == "note_on" and message.velocity:
                sounding[key] = NoteOn(
                    *(tick, name, message.channel, message.note, message.velocity),
                    program=programs.get(message.channel, 0),
                    pan=controllers.get((message.channel, PAN), _CENTRE),
                    send=controllers.get((message.channel, REVERB), 0),
                )
    return tuple(sorted([*notes, *sounding.values()]))
