"""Part notes: the notes of one part, of which a key sounds once at a time.

A key that is struck again while it sounds ends its earlier note. Struck twice on one tick it is
one note, the louder. Pitch bend belongs to a channel, so a sustained note bends where it sounds
alone; with MPE each note has a channel while one is free.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import groupby
from operator import attrgetter

from audio.controller_curves import ControllerPoint
from audio.parts import MEMBER_CHANNELS, Part


@dataclass(slots=True)
class PartNote:
    """A note of a part.

    Attributes:
        start: tick of its onset.
        end: tick of its end; later than the start.
        pitch: MIDI pitch, or key of a drum.
        velocity: 1 to 127.
        pan: pan controller, 0 to 127.
        send: reverb controller, 0 to 127.
        curve: controller points from its start on; empty for none.
        channel: 0 to 15.
        pedal: ticks from which, and until which, the sustain pedal is down that holds it.
    """

    start: int
    end: int
    pitch: int
    velocity: int
    pan: int = 64
    send: int = 0
    curve: tuple[ControllerPoint, ...] = ()
    channel: int = -1
    pedal: tuple[int, int] | None = None


@dataclass(slots=True)
class PartLosses:
    """What notes of a part lost because they share its channel.

    Attributes:
        merged: start ticks of notes that another note of their key and tick stands for.
        cut_short: number of notes ended because their key was struck again.
        without_curve: number of notes without their controller curve.
    """

    merged: list[int] = field(default_factory=list)
    cut_short: int = 0
    without_curve: int = 0


def settle_notes(part: Part, notes: list[PartNote]) -> tuple[list[PartNote], PartLosses]:
    """Return the notes that are played, with their channels, and what was lost.

    Args:
        part: the part.
        notes: of it, sorted by start, louder ones first; their ends may be shortened and their
            velocities raised.
    """
    _share_place(notes)
    losses = PartLosses()
    channels = [_Channel(number) for number in (MEMBER_CHANNELS if part.mpe else (part.channel,))]
    played: list[PartNote] = []
    for note in notes:
        # The channel that has been silent longest; without one, the least busy.
        channel = min(channels, key=lambda each: each.order(note))
        if channel.add(note, losses):
            played.append(note)
    return played, losses


def _share_place(notes: list[PartNote]) -> None:
    """Give notes of one tick one pan and reverb, which belong to the channel: their mean."""
    for _, group in groupby(notes, key=attrgetter("start")):
        struck = list(group)
        weight = sum(note.velocity for note in struck)
        pan = sum(note.pan * note.velocity for note in struck)
        send = sum(note.send * note.velocity for note in struck)
        for note in struck:
            # Rounded to the nearest, half upward.
            note.pan = (2 * pan + weight) // (2 * weight)
            note.send = (2 * send + weight) // (2 * weight)


@dataclass(slots=True)
class _Channel:
    """A channel with the notes that sound on it.

    Attributes:
        number: 0 to 15.
        sounding: notes that have not ended.
        last_end: greatest end of its notes.
    """

    number: int
    sounding: list[PartNote] = field(default_factory=list)
    last_end: int = -1

    def order(self, note: PartNote) -> tuple[int, int, int]:
        """Return what makes the channel less suitable for a note that starts."""
        self.sounding = [old for old in self.sounding if old.end > note.start]
        return len(self.sounding), self.last_end, self.number

    def add(self, note: PartNote, losses: PartLosses) -> bool:
        """Play a note; return False if another one stands for it."""
        old = next((old for old in self.sounding if old.pitch == note.pitch), None)
        if old is not None and old.start == note.start:
            old.velocity = max(old.velocity, note.velocity)
            old.end = max(old.end, note.end)
            losses.merged.append(note.start)
            return False
        if old is not None:
            old.end = note.start
            old.curve = tuple(point for point in old.curve if point.tick < old.end)
            self.sounding.remove(old)
            losses.cut_short += 1
        if self.sounding:
            # A bend would be heard of the others, too.
            for other in (note, *self.sounding):
                losses.without_curve += bool(other.curve)
                other.curve = ()
        note.channel = self.number
        self.sounding.append(note)
        self.last_end = max(self.last_end, note.end)
        return True
