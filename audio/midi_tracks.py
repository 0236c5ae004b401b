"""Tracks of a MIDI file: the conductor track, and a track of notes per performer or cause."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from itertools import pairwise
from operator import attrgetter, itemgetter

import mido

from audio.controller_curves import CENTERED, FULL_EXPRESSION
from audio.controller_range import BEND_RANGE
from audio.key_signature import score_key
from audio.notes import Note
from audio.part_notes import PartNote
from audio.parts import DRUMS, MEMBER_CHANNELS, Part, TrackLayout
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
_PEDAL, _DOWN, _UP = 64, 127, 0
_EXPRESSION = 11
# Registered parameter 0 is the pitch bend range in semitones and cents; parameter (127, 127) is
# none, so that later data entries of other programs change nothing.
_BEND_RANGE_MESSAGES = ((101, 0), (100, 0), (6, BEND_RANGE), (38, 0), (101, 127), (100, 127))

# Registered parameter 6 of the manager's channel: the number of channels for notes.
_MPE_MESSAGES = ((101, 0), (100, 6), (6, len(MEMBER_CHANNELS)), (101, 127), (100, 127))
# Universal message for all devices: General MIDI, on.
_GM_SYSTEM_ON = (0x7E, 0x7F, 0x09, 0x01)


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
    head.append(_gm_reset())
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


def note_track(
    layout: TrackLayout,
    parts: Sequence[tuple[Part, list[PartNote]]],
    end: int,
    resets: bool = False,
) -> mido.MidiTrack:
    """Return the track of some parts.

    On one tick ends come first, then changes just before onsets. Programs are set once.

    Args:
        layout: name and port.
        parts: with their notes, in the order of time.
        end: of the film [ticks].
        resets: whether it is the first track of its port.
    """
    head: list[TimedMessage] = []
    if layout.port:
        head.append((0, mido.MetaMessage("device_name", name=f"Port {layout.port + 1}")))
        head.append((0, mido.MetaMessage("midi_port", port=layout.port)))
    if resets:
        head.append((0, _gm_reset()))
    ends: list[TimedMessage] = []
    pedals: list[TimedMessage] = []
    rest: list[TimedMessage] = []
    for part, notes in parts:
        head += _part_setup(part, notes)
        ends += [
            (note.end, mido.Message("note_off", channel=note.channel, note=note.pitch, velocity=0))
            for note in sorted(notes, key=attrgetter("end"))
        ]
        pedals += _pedal_messages(part, notes)
        rest += _part_messages(part, notes)
    return _track(layout.name, [*head, *ends, *pedals, *rest], end)


def _gm_reset() -> mido.Message:
    """Return the message GM System On, which sets every channel to its defaults."""
    return mido.Message("sysex", data=_GM_SYSTEM_ON)


def _part_setup(part: Part, notes: list[PartNote]) -> Iterator[TimedMessage]:
    """Yield what holds for a part for the whole film."""
    channels = [part.channel]
    if part.mpe:
        for number, value in _MPE_MESSAGES:
            yield _control_change(part.channel, 0, number, value)
        # Receivers without MPE read the channels of notes one by one.
        channels += sorted({note.channel for note in notes})
    for channel in channels:
        if part.key.program != DRUMS:
            program = part.key.program
            yield 0, mido.Message("program_change", channel=channel, program=program)
        if any(note.curve for note in notes):
            for number, value in _BEND_RANGE_MESSAGES:
                yield _control_change(channel, 0, number, value)


def _pedal_messages(part: Part, notes: list[PartNote]) -> Iterator[TimedMessage]:
    """Yield when the sustain pedal of a part goes down and comes up."""
    for down, up in sorted({note.pedal for note in notes if note.pedal is not None}):
        yield _control_change(part.channel, down, _PEDAL, _DOWN)
        yield _control_change(part.channel, up, _PEDAL, _UP)


def _part_messages(part: Part, notes: list[PartNote]) -> Iterator[TimedMessage]:
    """Yield the onsets of a part, with the controllers that change at them and after."""
    pan = send = -1
    bent: set[int] = set()
    for note in notes:
        start, channel = note.start, note.channel
        # Before the first note there is nothing that a change could disturb.
        at = 0 if pan < 0 else start
        if note.pan != pan:
            yield _control_change(part.channel, at, PAN, note.pan)
        if note.send != send:
            yield _control_change(part.channel, at, REVERB, note.send)
        pan, send = note.pan, note.send
        if channel in bent and not note.curve:
            yield _pitch_bend(channel, start, CENTERED)
            yield _loudness(part, channel, start, FULL_EXPRESSION)
            bent.discard(channel)
        for point in note.curve[:1]:
            yield _pitch_bend(channel, start, point.bend)
            yield _loudness(part, channel, start, point.expression)
            bent.add(channel)
        key, velocity = note.pitch, note.velocity
        yield start, mido.Message("note_on", channel=channel, note=key, velocity=velocity)
        for previous, point in pairwise(note.curve):
            if point.bend != previous.bend:
                yield _pitch_bend(channel, point.tick, point.bend)
            if point.expression != previous.expression:
                yield _loudness(part, channel, point.tick, point.expression)


def _loudness(part: Part, channel: int, tick: int, value: int) -> TimedMessage:
    """Return the loudness of a sounding note: expression, or with MPE the pressure of its key."""
    if part.mpe:
        return tick, mido.Message("aftertouch", channel=channel, value=value)
    return _control_change(channel, tick, _EXPRESSION, value)


def _pitch_bend(channel: int, tick: int, bend: int) -> TimedMessage:
    return tick, mido.Message("pitchwheel", channel=channel, pitch=bend)


def _control_change(channel: int, tick: int, number: int, value: int) -> TimedMessage:
    return tick, mido.Message("control_change", channel=channel, control=number, value=value)


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
