"""Note list: what a MIDI file plays, as plain numbers that can be compared."""

from __future__ import annotations

import io
from dataclasses import dataclass

import mido


@dataclass(frozen=True, slots=True, order=True)
class NoteOn:
    """The begin of a note.

    Attributes:
        tick: of the file.
        track: its name.
        channel: 0 to 15.
        pitch: 0 to 127.
        velocity: 1 to 127.
    """

    tick: int
    track: str
    channel: int
    pitch: int
    velocity: int


def note_list(data: bytes) -> tuple[NoteOn, ...]:
    """Return the notes of a MIDI file in the order of their ticks."""
    notes = []
    for track in mido.MidiFile(file=io.BytesIO(data), charset="utf-8").tracks:
        tick = 0
        for message in track:
            tick += message.time
            if message.type == "note_on" and message.velocity:
                notes.append(
                    NoteOn(tick, track.name, message.channel, message.note, message.velocity)
                )
    return tuple(sorted(notes))
