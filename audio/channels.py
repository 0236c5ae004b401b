"""Channels for sounding notes: program and pan belong to a channel, so notes share one or differ.

Notes come in the order in which a player meets them: by tick, then by track. Each is given a
channel that has its program and pan already, else one that has fallen silent, and only then
another's: first a dying tail, then a neighbouring pan, at last nothing. What was given up on
the way is counted.
"""

from __future__ import annotations

from dataclasses import dataclass, field

# All but the tenth, which plays drums.
CHANNELS = tuple(channel for channel in range(16) if channel != 9)


@dataclass(slots=True)
class Placed:
    """A note on its channel.

    Attributes:
        track: index of the performer's track.
        start: tick of its onset.
        end: tick of its end; later than the start.
        program: General MIDI program.
        pan: pan controller's value, 0 to 127.
        pitch: MIDI pitch.
        velocity: 1 to 127.
        channel: 0 to 15, not 9.
        sets_program: whether a program change must stand before it.
        sets_pan: whether a pan change must stand before it.
    """

    track: int
    start: int
    end: int
    program: int
    pan: int
    pitch: int
    velocity: int
    channel: int = -1
    sets_program: bool = False
    sets_pan: bool = False


@dataclass(slots=True)
class Losses:
    """What had to be given up because there are fifteen channels.

    Attributes:
        merged: notes that one of the same pitch, onset and channel already sounds.
        moved: notes heard from a neighbouring direction.
        dropped: notes that no channel could play.
        cut_short: notes ended by the next of the same pitch.
        tails_cut: channels taken over while their last note still rang.
    """

    merged: int = 0
    moved: int = 0
    dropped: int = 0
    cut_short: int = 0
    tails_cut: int = 0


@dataclass(slots=True)
class _Channel:
    number: int
    program: int = -1
    pan: int = -1
    # Notes that may still sound, by pitch; the last of each.
    notes: dict[int, Placed] = field(default_factory=dict)
    last_end: int = -(10**9)

    def sounding(self, note: Placed) -> bool:
        """Say whether anything here sounds when the note comes; forgets what has ended."""
        self.notes = {p: old for p, old in self.notes.items() if not _over(old, note)}
        return bool(self.notes)

    def struck(self, note: Placed) -> Placed | None:
        """Return the note of the same pitch that still sounds."""
        old = self.notes.get(note.pitch)
        return old if old is not None and not _over(old, note) else None


def _over(old: Placed, note: Placed) -> bool:
    """Say whether an old note has ended for every reader when the new one comes.

    On one tick readers go track by track: an end in a later track would come after the onset.
    """
    return old.end < note.start or (old.end == note.start and old.track <= note.track)


def allocate(notes: list[Placed], tail: int) -> tuple[list[Placed], Losses]:
    """Give channels to notes.

    Args:
        notes: sorted by (start, track); ends may be shortened and velocities raised here.
        tail: ticks for which an instrument may ring on after its note's end.

    Returns:
        The notes that are played, and what was lost.
    """
    channels = [_Channel(number) for number in CHANNELS]
    played: list[Placed] = []
    losses = Losses()
    for note in notes:
        channel = _choose(channels, note, tail, losses)
        if channel is None:
            continue
        note.channel = channel.number
        note.sets_program = channel.program != note.program
        note.sets_pan = channel.pan != note.pan
        channel.program, channel.pan = note.program, note.pan
        channel.notes[note.pitch] = note
        channel.last_end = max(channel.last_end, note.end)
        played.append(note)
    return played, losses


def _choose(channels: list[_Channel], note: Placed, tail: int, losses: Losses) -> _Channel | None:
    same = [c for c in channels if (c.program, c.pan) == (note.program, note.pan)]
    free = [c for c in same if c.struck(note) is None]
    if free:
        return free[0]
    if any(_merge(c, note, losses) for c in same):
        return None
    silent = [c for c in channels if not c.sounding(note)]
    if silent:
        # Least recently heard first; one that has the program already needs one change less.
        best = min(
            silent, key=lambda c: (_rings(c, note, tail), c.program != note.program, c.last_end)
        )
        losses.tails_cut += _rings(best, note, tail)
        return best
    return _cut_in(same, note, losses) or _neighbour(channels, note, losses)


def _rings(channel: _Channel, note: Placed, tail: int) -> bool:
    return channel.last_end + tail > note.start


def _merge(channel: _Channel, note: Placed, losses: Losses) -> bool:
    """Let a note that begins now with the same pitch stand for this one too."""
    old = channel.struck(note)
    if old is None or old.start != note.start:
        return False
    old.velocity = max(old.velocity, note.velocity)
    losses.merged += 1
    return True


def _cut_in(same: list[_Channel], note: Placed, losses: Losses) -> _Channel | None:
    """End an earlier note of the same pitch so that this one can be struck."""
    for channel in same:
        old = channel.struck(note)
        # A tick before, unless the track's order already puts the end before the onset.
        end = note.start - (old is not None and old.track > note.track)
        if old is not None and end > old.start:
            old.end = end
            losses.cut_short += 1
            return channel
    return None


def _neighbour(channels: list[_Channel], note: Placed, losses: Losses) -> _Channel | None:
    """Move a note to the nearest direction that its program sounds from."""
    alike = [c for c in channels if c.program == note.program]
    alike.sort(key=lambda c: abs(c.pan - note.pan))
    for channel in alike:
        if channel.struck(note) is None:
            note.pan = channel.pan
            losses.moved += 1
            return channel
    if any(_merge(c, note, losses) for c in alike):
        return None
    losses.dropped += 1
    return None
