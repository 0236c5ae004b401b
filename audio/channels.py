"""Channels for sounding notes: program, pan and reverb belong to a channel, so notes share one.

Notes come in the order in which a player meets them: by tick, then by track. Each is given a
channel that has its track, program, pan and reverb already, else one that has fallen silent, and
only then another's: first a dying tail, then that of another track, then a neighbouring pan or
reverb, then the channel of whatever began longest ago. Only what begins at one moment with fifteen
others must share a note with one of them. What was given up on the way is counted.

A note with a gesture has its channel to itself, because pitch wheel and expression belong to
channels too. Each track says by itself all that its notes need, also where another track has said
it for the same channel: those who open a score take tracks apart.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from audio.placed import Losses, Placed

DRUMS = 9
"""The tenth channel, on which each key is a drum."""

CHANNELS = tuple(channel for channel in range(16) if channel != DRUMS)


@dataclass(slots=True)
class _Said:
    """What a channel, or one track's part of it, has been told."""

    program: int = -1
    pan: int = -1
    send: int = -1
    ranged: bool = False
    moved: bool = False

    def suits(self, note: Placed) -> bool:
        """Say whether a note can be played with what has been told."""
        return (self.program, self.pan, self.send) == (note.program, note.pan, note.send)

    def hear(self, note: Placed) -> None:
        """Take in what a note needs, and let the note say what is new."""
        note.sets_program |= self.program != note.program
        note.sets_pan |= self.pan != note.pan
        note.sets_send |= self.send != note.send
        note.sets_range |= bool(note.gesture) and not self.ranged
        note.rests |= self.moved and not note.gesture
        self.program, self.pan, self.send = note.program, note.pan, note.send
        self.ranged |= bool(note.gesture)
        self.moved = bool(note.gesture)


@dataclass(slots=True)
class _Channel:
    number: int
    said: _Said = field(default_factory=_Said)
    said_by: dict[int, _Said] = field(default_factory=dict)
    # Of whom the last note is.
    track: int = -1
    # Notes that may still sound, by pitch; the last of each.
    notes: dict[int, Placed] = field(default_factory=dict)
    last_end: int = -(10**9)

    def sounding(self, note: Placed) -> list[Placed]:
        """Return what sounds here when the note comes; forgets what has ended."""
        self.notes = {p: old for p, old in self.notes.items() if not _over(old, note)}
        return list(self.notes.values())

    def open(self, note: Placed) -> bool:
        """Say whether others may join in: not while something happens to a note."""
        return not any(old.gesture for old in self.sounding(note))

    def struck(self, note: Placed) -> Placed | None:
        """Return the note of the same pitch that still sounds."""
        old = self.notes.get(note.pitch)
        return old if old is not None and not _over(old, note) else None

    def take(self, note: Placed) -> None:
        """Play a note."""
        note.channel = self.number
        if not note.drum:
            self.said.hear(note)
            self.said_by.setdefault(note.track, _Said()).hear(note)
        self.track = note.track
        self.notes[note.pitch] = note
        self.last_end = max(self.last_end, note.end)


def _over(old: Placed, note: Placed) -> bool:
    """Say whether an old note has ended for every reader when the new one comes.

    On one tick readers go track by track: an end in a later track would come after the onset.
    """
    return old.end <= _end_before(old, note)


def _end_before(old: Placed, note: Placed) -> int:
    """Return the last tick at which an old note may end so that the new one can be struck."""
    return note.start - (old.track > note.track)


def allocate(notes: list[Placed], tail: int) -> tuple[list[Placed], Losses]:
    """Give channels to notes.

    Args:
        notes: sorted by (start, track); ends may be shortened and velocities raised here.
        tail: ticks for which an instrument may ring on after its note's end.

    Returns:
        The notes that are played, and what was lost: none without one that stands for it.
    """
    channels = [_Channel(number) for number in CHANNELS]
    drums = _Channel(DRUMS)
    played: list[Placed] = []
    losses = Losses()
    for note in notes:
        channel = _drum(drums, note, losses) if note.drum else _choose(channels, note, tail, losses)
        if channel is not None:
            channel.take(note)
            played.append(note)
    return played, losses


def _drum(drums: _Channel, note: Placed, losses: Losses) -> _Channel | None:
    old = drums.struck(note)
    if old is None or _ended(old, note, losses):
        return drums
    _stand_for(old, note, losses)
    return None


def _choose(channels: list[_Channel], note: Placed, tail: int, losses: Losses) -> _Channel | None:
    silent = [c for c in channels if not c.sounding(note)]
    if note.gesture and not silent:
        # What is struck is soon faint; what rolls is heard for as long as it does.
        taken = _take_over([c for c in channels if c.open(note)], note, losses)
        if taken is not None:
            return taken
        note.gesture = ()
        losses.stiff += 1
    shared = silent if note.gesture else [c for c in channels if c.open(note)]
    same = [c for c in shared if c.said.suits(note)]
    own = [c for c in same if c.track == note.track]
    for channel in own:
        if channel.struck(note) is None and not _rings_bent(channel, note, tail):
            return channel
    if _merge(own, note, losses):
        return None
    if silent:
        return _silent(silent, note, tail, losses)
    return _crowded(channels, shared, same, note, losses)


def _silent(silent: list[_Channel], note: Placed, tail: int, losses: Losses) -> _Channel:
    """Return the channel that was heard least recently, better one that has the program."""
    best = min(
        silent, key=lambda c: (_rings(c, note, tail), c.said.program != note.program, c.last_end)
    )
    losses.tails_cut += _rings(best, note, tail)
    return best


def _crowded(
    channels: list[_Channel],
    shared: list[_Channel],
    same: list[_Channel],
    note: Placed,
    losses: Losses,
) -> _Channel | None:
    """Return a channel for a note that begins while all of them sound."""
    for channel in same:
        if channel.struck(note) is None:
            return channel
    if _merge(same, note, losses):
        return None
    cut = _cut_in(same, note, losses)
    if cut is not None:
        return cut
    alike = [c for c in shared if c.said.program == note.program]
    alike.sort(key=lambda c: (abs(c.said.pan - note.pan), abs(c.said.send - note.send)))
    near = _neighbour(alike, note, losses)
    if near is not None or _merge(alike, note, losses):
        return near
    taken = _take_over(channels, note, losses)
    if taken is None:
        struck = [(c, old) for c in channels for old in c.sounding(note)]
        _, like = min(struck, key=lambda pair: _unlike(pair[0], pair[1], note))
        _stand_for(like, note, losses)
    return taken


def _rings(channel: _Channel, note: Placed, tail: int) -> bool:
    return channel.last_end + tail > note.start


def _rings_bent(channel: _Channel, note: Placed, tail: int) -> bool:
    """Say whether bringing its controllers to this note would be heard in a channel's tail."""
    return (channel.said.moved or bool(note.gesture)) and _rings(channel, note, tail)


def _stand_for(old: Placed, note: Placed, losses: Losses) -> None:
    """Let a note that is struck already stand for this one too."""
    old.velocity = max(old.velocity, note.velocity)
    losses.merged.append(note.start)


def _merge(channels: list[_Channel], note: Placed, losses: Losses) -> bool:
    """Let a note that begins now with the same pitch stand for this one too."""
    for channel in channels:
        old = channel.struck(note)
        if old is not None and old.start == note.start:
            _stand_for(old, note, losses)
            return True
    return False


def _ended(old: Placed, note: Placed, losses: Losses) -> bool:
    """End an earlier note, if it has begun early enough."""
    end = _end_before(old, note)
    if end <= old.start:
        return False
    old.cut(end)
    losses.cut_short += 1
    return True


def _cut_in(same: list[_Channel], note: Placed, losses: Losses) -> _Channel | None:
    """End an earlier note of the same pitch so that this one can be struck."""
    for channel in same:
        old = channel.struck(note)
        if old is not None and _ended(old, note, losses):
            return channel
    return None


def _neighbour(alike: list[_Channel], note: Placed, losses: Losses) -> _Channel | None:
    """Move a note to the nearest direction and reverb that its program sounds with."""
    for channel in alike:
        if channel.struck(note) is None:
            losses.moved += note.pan != channel.said.pan
            losses.reverbs += note.send != channel.said.send
            note.pan, note.send = channel.said.pan, channel.said.send
            return channel
    return None


def _take_over(channels: list[_Channel], note: Placed, losses: Losses) -> _Channel | None:
    """Silence the channel whose last onset is longest ago, as a synthesiser steals a voice.

    None where all have been struck at this very moment.
    """
    for channel in sorted(channels, key=lambda c: max(old.start for old in c.sounding(note))):
        sounding = channel.sounding(note)
        if all(_end_before(old, note) > old.start for old in sounding):
            for old in sounding:
                _ended(old, note, losses)
            return channel
    return None


def _unlike(channel: _Channel, old: Placed, note: Placed) -> tuple[int, bool, int, int]:
    distance = abs(channel.said.pan - note.pan), abs(old.pitch - note.pitch)
    return (-old.start, channel.said.program != note.program, *distance)
