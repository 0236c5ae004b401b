"""Score -> MIDI file of type 1 with every note on the frame of its cause."""

from __future__ import annotations

import io
from collections import Counter, defaultdict
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import accumulate
from math import floor
from operator import itemgetter
from pathlib import Path

import mido

from audio.controller_curves import note_curve
from audio.loudness_at_listener import velocity_of_level
from audio.midi_tracks import PAN, REVERB, conductor_track, note_track
from audio.notes import Arrangement, Note, arrange
from audio.part_notes import PartLosses, PartNote, settle_notes
from audio.parts import DRUMS, Part, PartKey, TrackLayout, lay_out
from audio.quantisation import TimingShifts
from audio.score import Score
from audio.sound_files import write_sound_file
from audio.tempo_report import TempoReport, tempo_report
from audio.time_grid import TickGrid


@dataclass(frozen=True, slots=True)
class PlayedPart:
    """A part with its notes.

    Attributes:
        part: with port and channel.
        notes: that are played.
        losses: of notes that share its channel.
    """

    part: Part
    notes: list[PartNote]
    losses: PartLosses


@dataclass(frozen=True, slots=True)
class PlayedTrack:
    """A track of a file with its parts."""

    layout: TrackLayout
    parts: tuple[PlayedPart, ...]


@dataclass(frozen=True, slots=True)
class MidiReport:
    """Contents of a MIDI file.

    Attributes:
        path: of the file.
        changed: whether the file was written; False if it held these bytes already.
        notes: number of notes played.
        muted: number of muted events.
        added: number of notes of chords and phrases beyond the first of each event.
        music: number of notes of the music, merged ones included.
        after_the_end: number of phrase notes dropped because they start after the last frame.
        parts: in the order of tracks.
        merged_by_frame: frame -> number of events that share the note of another.
        shifts: statistics of the quantisation.
        tempo: tempo, meter and their errors.
    """

    path: Path
    changed: bool
    notes: int
    muted: int
    added: int
    music: int
    after_the_end: int
    parts: tuple[PlayedPart, ...]
    merged_by_frame: dict[int, int]
    shifts: TimingShifts
    tempo: TempoReport

    @property
    def losses(self) -> PartLosses:
        """Losses of all parts."""
        losses = [played.losses for played in self.parts]
        return PartLosses(
            [tick for each in losses for tick in each.merged],
            sum(each.cut_short for each in losses),
            sum(each.without_curve for each in losses),
        )


def write_midi(score: Score, path: Path) -> MidiReport:
    """Write a score as MIDI; an equal file is left alone, and on failure the earlier one stays.

    Raises:
        GridError: the frame rate has no grid.
        ScoreError: an event lies outside the score, or there are more parts than the format holds.
        SoundFileError: the file could not be written.
    """
    path = Path(path)
    arrangement = arrange(score)
    tracks = play_parts(score, arrangement)
    data = encode_tracks(score, arrangement, tracks)
    events = sum(note.is_first for note in arrangement.notes)
    grid = arrangement.plan.grid
    parts = tuple(played for track in tracks for played in track.parts)
    merged = (tick for played in parts for tick in played.losses.merged)
    return MidiReport(
        path=path,
        changed=write_sound_file(path, data),
        notes=sum(len(played.notes) for played in parts),
        muted=len(score.events) - events,
        added=len(arrangement.event_notes) - events,
        music=len(arrangement.notes) - len(arrangement.event_notes),
        after_the_end=arrangement.after_the_end,
        parts=parts,
        merged_by_frame=dict(sorted(Counter(map(grid.frame_at, merged)).items())),
        shifts=arrangement.shifts,
        tempo=tempo_report(score, arrangement.plan, arrangement.event_notes),
    )


def midi_bytes(score: Score) -> bytes:
    """Return the MIDI file of a score; raises as `write_midi` does."""
    arrangement = arrange(score)
    return encode_tracks(score, arrangement, play_parts(score, arrangement))


def encode_tracks(score: Score, arrangement: Arrangement, tracks: tuple[PlayedTrack, ...]) -> bytes:
    """Return a MIDI file of some tracks of a score, after the conductor track."""
    grid = arrangement.plan.grid
    end = grid.tick(score.frames + 1)
    written = [conductor_track(score, grid, arrangement.notes)]
    reset: set[int] = {0}
    for track in tracks:
        parts = [(played.part, played.notes) for played in track.parts]
        written.append(note_track(track.layout, parts, end, resets=track.layout.port not in reset))
        reset.add(track.layout.port)
    division = grid.ticks_per_beat
    file = mido.MidiFile(type=1, ticks_per_beat=division, charset="utf-8", tracks=written)
    out = io.BytesIO()
    file.save(file=out)
    return out.getvalue()


def play_parts(score: Score, arrangement: Arrangement) -> tuple[PlayedTrack, ...]:
    """Return the tracks of a score: every part with its channel and notes."""
    grid = arrangement.plan.grid
    last = grid.tick(score.frames + 1)
    notes: dict[PartKey, list[PartNote]] = defaultdict(list)
    for note in arrangement.notes:
        notes[_part_key(score, note)].append(_part_note(note, grid, last))
    tracks = []
    for layout in lay_out(notes, score.sound.mpe):
        parts = []
        for part in layout.parts:
            ordered = sorted(notes[part.key], key=_order)
            parts.append(PlayedPart(part, *settle_notes(part, ordered)))
        tracks.append(PlayedTrack(layout, tuple(parts)))
    return tuple(tracks)


def _part_key(score: Score, note: Note) -> PartKey:
    event = note.event
    track = event.who if score.sound.tracks == "performer" else event.cause
    return PartKey(track, event.who, DRUMS if note.drum else note.program)


def _part_note(note: Note, grid: TickGrid, last: int) -> PartNote:
    # A note has at least one tick, even at the very end.
    start = min(grid.tick_at(note.onset), last - 1)
    end = min(max(grid.tick_at(note.onset + Fraction(note.seconds)), start + 1), last)
    pedal = None
    if note.pedal is not None:
        down, up = (min(grid.tick_at(time), last) for time in note.pedal)
        pedal = (down, up) if down < up else None
    return PartNote(
        start=start,
        end=end,
        pitch=note.pitch,
        velocity=velocity_of_level(note.level),
        pan=_controller(64, note.effective_pan * 64),
        send=_controller(0, note.send * 128),
        curve=note_curve(note, grid, start, end),
        pedal=pedal,
    )


def _order(note: PartNote) -> tuple[int, ...]:
    # Louder first within a tick, so that compromises affect the softest.
    return (note.start, -note.velocity, note.pitch, note.pan, note.send, note.end)


def _controller(middle: int, offset: float) -> int:
    return min(max(middle + floor(offset + 0.5), 0), 127)


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
        port = next((message.port for message in track if message.type == "midi_port"), 0)
        name = track.name, port
        timed += [(tick, name, message) for tick, message in zip(ticks, track, strict=True)]
    # Tracks of one port share channels, so the setting of a channel may stand in another track.
    timed.sort(key=itemgetter(0))
    programs: dict[tuple[int, int], int] = {}
    controllers: dict[tuple[int, int, int], int] = {}
    sounding: dict[tuple[str, int, int, int], NoteOn] = {}
    notes = []
    for tick, (name, port), message in timed:
        if message.type == "program_change":
            programs[port, message.channel] = message.program
        elif message.type == "control_change":
            controllers[port, message.channel, message.control] = message.value
        elif message.type in ("note_on", "note_off"):
            key = (name, port, message.channel, message.note)
            if key in sounding:
                started = sounding.pop(key)
                notes.append(replace(started, ticks=tick - started.tick))
            if message.type == "note_on" and message.velocity:
                sounding[key] = NoteOn(
                    *(tick, name, message.channel, message.note, message.velocity),
                    program=programs.get((port, message.channel), 0),
                    pan=controllers.get((port, message.channel, PAN), _CENTRE),
                    send=controllers.get((port, message.channel, REVERB), 0),
                )
    return tuple(sorted([*notes, *sounding.values()]))
