"""Tracks of a MIDI file: messages at absolute ticks, put into the order that players need."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from operator import attrgetter, itemgetter

import mido

from audio.errors import ScoreError
from audio.gestures import BEND_RANGE, CENTRED, FULL
from audio.placed import Placed

Timed = tuple[int, mido.Message | mido.MetaMessage]
"""A message with its tick."""

# mido writes longer ones in silence, as bytes that no reader understands.
_MAX_DELTA = 2**28 - 1
_PAN, _EXPRESSION, _REVERB = 10, 11, 91
# Registered parameter 0 is the range of the pitch wheel, in semitones and hundredths; parameter
# 127, 127 is none, so that what another program sends later changes nothing.
_RANGE = ((101, 0), (100, 0), (6, BEND_RANGE), (38, 0), (101, 127), (100, 127))


def clean(text: str) -> str:
    """Return a text that has an UTF-8."""
    # Half of a surrogate pair has none; it must not cost the author the file.
    return text.encode("utf-8", "replace").decode("utf-8")


def name(text: str) -> Timed:
    """Return the name of a track."""
    return 0, mido.MetaMessage("track_name", name=clean(text))


def note_messages(notes: list[Placed]) -> list[Timed]:
    """Return a track's messages; on one tick ends come first, then changes just before onsets."""
    ends = [
        (note.end, mido.Message("note_off", channel=note.channel, note=note.pitch, velocity=0))
        for note in sorted(notes, key=attrgetter("end"))
    ]
    return ends + [message for note in notes for message in _played(note)]


def _played(note: Placed) -> Iterator[Timed]:
    """Give all that belongs to a note but its end."""
    channel, at = note.channel, note.start
    if note.sets_program:
        yield at, mido.Message("program_change", channel=channel, program=note.program)
    if note.sets_pan:
        yield _control(note, at, _PAN, note.pan)
    if note.sets_send:
        yield _control(note, at, _REVERB, note.send)
    if note.sets_range:
        yield from (_control(note, at, number, value) for number, value in _RANGE)
    if note.rests:
        yield from _stand(note, at, CENTRED, FULL)
    for moment in note.gesture[:1]:
        yield from _stand(note, at, moment.bend, moment.expression)
    yield at, mido.Message("note_on", channel=channel, note=note.pitch, velocity=note.velocity)
    for before, moment in zip(note.gesture, note.gesture[1:], strict=False):
        if moment.bend != before.bend:
            yield moment.tick, mido.Message("pitchwheel", channel=channel, pitch=moment.bend)
        if moment.expression != before.expression:
            yield _control(note, moment.tick, _EXPRESSION, moment.expression)


def _stand(note: Placed, at: int, bend: int, expression: int) -> Iterator[Timed]:
    yield at, mido.Message("pitchwheel", channel=note.channel, pitch=bend)
    yield _control(note, at, _EXPRESSION, expression)


def _control(note: Placed, at: int, number: int, value: int) -> Timed:
    return at, mido.Message("control_change", channel=note.channel, control=number, value=value)


def track(timed: Iterable[Timed], end: int) -> mido.MidiTrack:
    """Return a track of messages at absolute ticks; those on one tick keep their order.

    Raises:
        ScoreError: a gap is longer than the format can say.
    """
    written = mido.MidiTrack()
    now = 0
    for tick, message in sorted(
        [*timed, (end, mido.MetaMessage("end_of_track"))], key=itemgetter(0)
    ):
        if tick - now > _MAX_DELTA:
            raise ScoreError(f"{tick - now} ticks without an event; MIDI files hold {_MAX_DELTA}")
        written.append(message.copy(time=tick - now))
        now = tick
    return written
