"""Tracks of a MIDI file: the conductor track, and a track of notes per performer or cause."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from fractions import Fraction
from operator import attrgetter, itemgetter

import mido

from audio.channel_allocation import ChannelNote
from audio.controller_curves import BEND_RANGE, CENTERED, FULL_EXPRESSION
from audio.key_signature import score_key
from audio.notes import Note
from audio.score import Score
from audio.time_grid import TickGrid

TimedMessage = tuple[int, mido.Message | mido.MetaMessage]
"""A message with its tick."""

# Rates with an SMPTE offset, as mido names them. The code of 30000/1001 has drop-frame numbers,
# which are the same at offset zero.
_SMPTE_CODES = {
    Fraction(24): 24,
    Fraction(25): 25,
    Fraction(30000, 1001): 29.97,
    Fraction(30): 30,
}
# mido writes longer ones silently as invalid bytes.
_MAX_DELTA = 2**28 - 1
PAN, REVERB = 10, 91
"""Numbers of controllers."""
_EXPRESSION = 11
# Registered parameter 0 is the pitch bend range in semitones and cents; parameter (127, 127) is
# none, so that later data entries of other programs change nothing.
_BEND_RANGE_MESSAGES = ((101, 0), (100, 0), (6, BEND_RANGE), (38, 0), (101, 127), (100, 127))


def conductor_track(score: Score, grid: TickGrid, notes: tuple[Note, ...]) -> mido.MidiTrack:
    """Return the track of title, tempo, markers, and a cue point for each event."""
    head = [
        mido.MetaMessage("text", text=_encodable(f"title: {score.title}")),
        mido.MetaMessage("text", text=f"frames: {score.frames} at {score.rate} a second"),
    ]
    if score.rate in _SMPTE_CODES:
        # The film starts at 00:00:00:00; mido's default is another hour.
        code = _SMPTE_CODES[score.rate]
        head.append(mido.MetaMessage("smpte_offset", frame_rate=code, hours=0))
    end = grid.tick(score.frames + 1)
    key = score_key(score)
    if key is not None:
        head.append(mido.MetaMessage("key_signature", key=key))
    markers = [
        (grid.tick(marker.frame), mido.MetaMessage("marker", text=_encodable(marker.label)))
        for marker in score.markers
    ]
    cues = [
        (
            grid.tick_at(note.onset),
            mido.MetaMessage("cue_marker", text=_encodable(note.event.label)),
        )
        for note in notes
        if note.is_first
    ]
    timed = [*((0, message) for message in head), *_beat_messages(grid, end), *markers, *cues]
    return _track(score.title or "score", timed, end)


def _beat_messages(grid: TickGrid, end: int) -> Iterator[TimedMessage]:
    """Yield tempos and meters; one after the end would lengthen the file."""
    for tempo in grid.tempo_track(end).events:
        if tempo.tick < end:
            yield tempo.tick, mido.MetaMessage("set_tempo", tempo=tempo.microseconds)
    for signature in grid.signatures:
        if signature.tick < end or not signature.tick:
            beats, unit = signature.meter
            message = mido.MetaMessage("time_signature", numerator=beats, denominator=unit)
            yield signature.tick, message


def note_track(name: str, notes: list[ChannelNote], end: int) -> mido.MidiTrack:
    """Return a track of notes; on one tick ends come first, then changes just before onsets."""
    ends = [
        (note.end, mido.Message("note_off", channel=note.channel, note=note.pitch, velocity=0))
        for note in sorted(notes, key=attrgetter("end"))
    ]
    return _track(name, [*ends, *(timed for note in notes for timed in _messages(note))], end)


def _messages(note: ChannelNote) -> Iterator[TimedMessage]:
    """Yield all messages of a note but its end."""
    yield from _setup_messages(note)
    start, key, velocity = note.start, note.pitch, note.velocity
    yield start, mido.Message("note_on", channel=note.channel, note=key, velocity=velocity)
    for previous, point in zip(note.curve, note.curve[1:], strict=False):
        if point.bend != previous.bend:
            yield _pitch_bend(note, point.tick, point.bend)
        if point.expression != previous.expression:
            yield _control_change(note, point.tick, _EXPRESSION, point.expression)


def _setup_messages(note: ChannelNote) -> Iterator[TimedMessage]:
    """Yield the controller changes just before a note's onset."""
    channel, start = note.channel, note.start
    if note.sets_program:
        yield start, mido.Message("program_change", channel=channel, program=note.program)
    if note.sets_pan:
        yield _control_change(note, start, PAN, note.pan)
    if note.sets_send:
        yield _control_change(note, start, REVERB, note.send)
    if note.sets_bend_range:
        for number, value in _BEND_RANGE_MESSAGES:
            yield _control_change(note, start, number, value)
    if note.resets_controllers:
        yield _pitch_bend(note, start, CENTERED)
        yield _control_change(note, start, _EXPRESSION, FULL_EXPRESSION)
    for point in note.curve[:1]:
        yield _pitch_bend(note, start, point.bend)
        yield _control_change(note, start, _EXPRESSION, point.expression)


def _pitch_bend(note: ChannelNote, tick: int, bend: int) -> TimedMessage:
    return tick, mido.Message("pitchwheel", channel=note.channel, pitch=bend)


def _control_change(note: ChannelNote, tick: int, number: int, value: int) -> TimedMessage:
    return tick, mido.Message("control_change", channel=note.channel, control=number, value=value)


def _track(name: str, timed: Iterable[TimedMessage], end: int) -> mido.MidiTrack:
    """Return a track of messages at absolute ticks; those on one tick keep their order."""
    track = mido.MidiTrack([mido.MetaMessage("track_name", name=_encodable(name))])
    now = 0
    for tick, message in sorted(
        [*timed, (end, mido.MetaMessage("end_of_track"))], key=itemgetter(0)
    ):
        while tick - now > _MAX_DELTA:
            # A silence longer than the format holds is written in parts.
            track.append(mido.MetaMessage("text", text="", time=_MAX_DELTA))
            now += _MAX_DELTA
        track.append(message.copy(time=tick - now))
        now = tick
    return track


def _encodable(text: str) -> str:
    """Return a text without lone surrogates, which UTF-8 cannot encode."""
    return text.encode("utf-8", "replace").decode("utf-8")
