"""Score -> MIDI file of type 1, its notes on the frames that caused them."""

from __future__ import annotations

import io
from dataclasses import dataclass
from fractions import Fraction
from math import floor
from operator import itemgetter
from pathlib import Path

import mido

from audio.channels import Losses, Placed, allocate
from audio.errors import ScoreError
from audio.files import put
from audio.grid import Grid, grid_of
from audio.heard import pan_of
from audio.score import Score, ScoreEvent
from audio.voices import Note, notes_of

# mido writes longer ones in silence, as bytes that no reader understands.
_MAX_DELTA = 2**28 - 1
# Rates that an SMPTE offset has a code for, as mido names them. The code of 30000/1001 counts
# with dropped numbers, which at offset zero differs from counting them all in nothing.
_SMPTE_CODES = {
    Fraction(24): 24,
    Fraction(25): 25,
    Fraction(30000, 1001): 29.97,
    Fraction(30): 30,
}
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
        merged: notes that one of the same pitch and onset already sounds.
        moved: notes heard from a neighbouring direction for want of channels.
        dropped: notes that no channel could play.
        cut_short: notes ended early by the next of the same pitch.
        tails_cut: channels taken over while their last note still rang.
    """

    path: Path
    changed: bool
    notes: int
    muted: int
    merged: int
    moved: int
    dropped: int
    cut_short: int
    tails_cut: int


def write_midi(score: Score, path: Path) -> MidiReport:
    """Write a score as MIDI; an equal file is left alone, and on failure the earlier one stays.

    Raises:
        GridError: the frame rate has no exact grid.
        ScoreError: an event lies outside the score, or the score is too long for the format.
        SoundFileError: the file could not be written.
    """
    path = Path(path)
    data, notes, played, losses = _encode(score)
    return MidiReport(
        path=path,
        changed=put(path, data),
        notes=played,
        muted=len(score.events) - notes,
        merged=losses.merged,
        moved=losses.moved,
        dropped=losses.dropped,
        cut_short=losses.cut_short,
        tails_cut=losses.tails_cut,
    )


def midi_bytes(score: Score) -> bytes:
    """Return the MIDI file of a score; raises as `write_midi` does."""
    return _encode(score)[0]


def _encode(score: Score) -> tuple[bytes, int, int, Losses]:
    grid = grid_of(score.rate)
    notes = notes_of(score)
    performers = sorted({note.event.who for note in notes})
    played, losses = _placed(score, grid, notes, performers)
    end = grid.tick(score.frames + 1)
    tracks = [_track(_conductor(score, grid, notes), end)]
    for index, who in enumerate(performers):
        own = [note for note in played if note.track == index]
        tracks.append(_track([(0, _name(who)), *_note_messages(own)], end))
    file = mido.MidiFile(type=1, ticks_per_beat=grid.ticks_per_beat, charset="utf-8", tracks=tracks)
    out = io.BytesIO()
    file.save(file=out)
    return out.getvalue(), len(notes), len(played), losses


def _placed(
    score: Score, grid: Grid, notes: tuple[Note, ...], performers: list[str]
) -> tuple[list[Placed], Losses]:
    track = {who: index for index, who in enumerate(performers)}
    end = grid.tick(score.frames + 1)
    wanted = []
    for note in notes:
        start = grid.tick(note.event.frame)
        wanted.append(
            Placed(
                track=track[note.event.who],
                start=start,
                end=min(start + grid.ticks(note.seconds), end),
                program=note.program,
                pan=_pan(note.event),
                pitch=note.pitch,
                velocity=_velocity(note.level),
            )
        )
    # Louder first within a tick and track, so that what is lost for want of channels is faint.
    wanted.sort(key=lambda n: (n.start, n.track, -n.velocity, n.program, n.pitch, n.pan))
    return allocate(wanted, grid.ticks(_TAIL_SECONDS))


def _pan(event: ScoreEvent) -> int:
    steps = 64 // _PAN_STEP
    return min(64 + _PAN_STEP * floor(pan_of(event) * steps + 0.5), 127)


def _velocity(level: float) -> int:
    return min(max(round(127 * 10 ** ((level - _FULL_VELOCITY_DB) / 40)), 1), 127)


def _conductor(
    score: Score, grid: Grid, notes: tuple[Note, ...]
) -> list[tuple[int, mido.MetaMessage]]:
    head = [
        _name(score.title or "score"),
        mido.MetaMessage("text", text=_text(f"title: {score.title}")),
        mido.MetaMessage("text", text=f"frames: {score.frames} at {score.rate} a second"),
        mido.MetaMessage("set_tempo", tempo=grid.tempo),
        mido.MetaMessage("time_signature", numerator=4, denominator=4),
    ]
    if score.rate in _SMPTE_CODES:
        # The film starts at 00:00:00:00; mido would start it at another hour.
        offset = mido.MetaMessage("smpte_offset", frame_rate=_SMPTE_CODES[score.rate], hours=0)
        head.insert(3, offset)
    cues = [(grid.tick(note.event.frame), _cue(note.event)) for note in notes]
    return [(0, message) for message in head] + cues


def _cue(event: ScoreEvent) -> mido.MetaMessage:
    what = f"{event.cause}: {event.who}" + (f".{event.part}" if event.part else "")
    return mido.MetaMessage(
        "cue_marker", text=_text(what + (f" > {event.other}" if event.other else ""))
    )


def _name(text: str) -> mido.MetaMessage:
    return mido.MetaMessage("track_name", name=_text(text))


def _text(text: str) -> str:
    # Half of a surrogate pair has no UTF-8; it must not cost the author the file.
    return text.encode("utf-8", "replace").decode("utf-8")


def _note_messages(notes: list[Placed]) -> list[tuple[int, mido.Message]]:
    """Return a track's messages; on one tick ends come first, then changes just before onsets."""
    ends = [
        (note.end, mido.Message("note_off", channel=note.channel, note=note.pitch, velocity=0))
        for note in notes
    ]
    onsets: list[tuple[int, mido.Message]] = []
    for note in notes:
        channel, at = note.channel, note.start
        if note.sets_program:
            change = mido.Message("program_change", channel=channel, program=note.program)
            onsets.append((at, change))
        if note.sets_pan:
            pan = mido.Message("control_change", channel=channel, control=10, value=note.pan)
            onsets.append((at, pan))
        strike = mido.Message("note_on", channel=channel, note=note.pitch, velocity=note.velocity)
        onsets.append((at, strike))
    return sorted(ends, key=itemgetter(0)) + onsets


def _track(timed: list[tuple[int, mido.Message]], end: int) -> mido.MidiTrack:
    """Return a track of messages at absolute ticks; those on one tick keep their order.

    Raises:
        ScoreError: a gap is longer than the format can say.
    """
    track = mido.MidiTrack()
    now = 0
    timed = [*timed, (end, mido.MetaMessage("end_of_track"))]
    for tick, message in sorted(timed, key=itemgetter(0)):
        if tick - now > _MAX_DELTA:
            raise ScoreError(f"{tick - now} ticks without an event; MIDI files hold {_MAX_DELTA}")
        track.append(message.copy(time=tick - now))
        now = tick
    return track
