"""MIDI channel allocation: many notes on fifteen melodic channels and one of drums.

Program, pan, reverb and pitch bend belong to a channel, so notes that differ in them need
different channels while they sound. If channels run out, notes are moved to a similar channel,
merged with an equal note, or silence the channel with the oldest onset.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from audio.controller_curves import ControllerPoint

DRUM_CHANNEL = 9
"""The channel on which each key is a drum."""

CHANNELS = tuple(channel for channel in range(16) if channel != DRUM_CHANNEL)

_NEVER = -(10**9)


@dataclass(slots=True)
class ChannelNote:
    """A note with its channel and the controller messages that it needs.

    Attributes:
        track: index of its track.
        start: tick of its onset.
        end: tick of its end; later than the start.
        program: General MIDI program.
        pan: pan controller, 0 to 127.
        pitch: MIDI pitch.
        velocity: 1 to 127.
        curve: controller points from its start on; empty for none.
        send: reverb controller, 0 to 127.
        drum: whether it belongs to the drum channel, which has its own programs and pans.
        channel: 0 to 15.
        sets_program: whether a program change must precede it.
        sets_pan: whether a pan change must precede it.
        sets_send: whether a reverb change must precede it.
        sets_bend_range: whether the pitch bend range must precede it.
        resets_controllers: whether pitch bend and expression must be reset before it.
    """

    track: int
    start: int
    end: int
    program: int
    pan: int
    pitch: int
    velocity: int
    curve: tuple[ControllerPoint, ...] = ()
    send: int = 0
    drum: bool = False
    channel: int = -1
    sets_program: bool = False
    sets_pan: bool = False
    sets_send: bool = False
    sets_bend_range: bool = False
    resets_controllers: bool = False

    def last_end_before(self, note: ChannelNote) -> int:
        """Return the last tick at which this note may end so that another can be struck.

        On one tick readers go track by track: an end in a later track would follow the onset.
        """
        return note.start - (self.track > note.track)

    def has_ended(self, note: ChannelNote) -> bool:
        """Return whether this note has ended for every reader when another one starts."""
        return self.end <= self.last_end_before(note)

    def can_end_before(self, note: ChannelNote) -> bool:
        """Return whether this note started early enough to be ended before another one."""
        return self.last_end_before(note) > self.start


@dataclass(slots=True)
class AllocationLosses:
    """Compromises made for want of channels.

    Attributes:
        merged: start ticks of notes replaced by an equal note with the same onset.
        pan_changed: number of notes moved to a neighbouring direction.
        reverb_changed: number of notes with another share of the reverb.
        cut_short: number of notes ended so that another can be struck.
        tails_cut: number of channels reused while their last note still rang.
        without_curve: number of notes without their controller curve.
    """

    merged: list[int] = field(default_factory=list)
    pan_changed: int = 0
    reverb_changed: int = 0
    cut_short: int = 0
    tails_cut: int = 0
    without_curve: int = 0

    def merge(self, old: ChannelNote, note: ChannelNote) -> None:
        """Let a note that sounds already stand for another one too."""
        old.velocity = max(old.velocity, note.velocity)
        self.merged.append(note.start)

    def end_early(self, old: ChannelNote, note: ChannelNote) -> bool:
        """End an earlier note before another one; return whether it started early enough."""
        if not old.can_end_before(note):
            return False
        old.end = old.last_end_before(note)
        old.curve = tuple(point for point in old.curve if point.tick < old.end)
        self.cut_short += 1
        return True


@dataclass(slots=True)
class _ControllerState:
    """Controllers of a channel as set so far, by all tracks or by one."""

    program: int = -1
    pan: int = -1
    send: int = -1
    has_bend_range: bool = False
    is_bent: bool = False

    def suits(self, note: ChannelNote) -> bool:
        """Return whether a note can be played without changes."""
        return (self.program, self.pan, self.send) == (note.program, note.pan, note.send)

    def apply(self, note: ChannelNote) -> None:
        """Set the controllers of a note, and mark in the note those that change."""
        note.sets_program |= self.program != note.program
        note.sets_pan |= self.pan != note.pan
        note.sets_send |= self.send != note.send
        note.sets_bend_range |= bool(note.curve) and not self.has_bend_range
        note.resets_controllers |= self.is_bent and not note.curve
        self.program, self.pan, self.send = note.program, note.pan, note.send
        self.has_bend_range |= bool(note.curve)
        self.is_bent = bool(note.curve)


@dataclass(slots=True)
class _Channel:
    """A channel with the notes that may still sound.

    Attributes:
        number: 0 to 15.
        state: controllers as set by all tracks.
        track_states: controllers as set by each track.
        track: of the last note.
        notes: the last note of each pitch.
        last_end: greatest end of its notes.
    """

    number: int
    state: _ControllerState = field(default_factory=_ControllerState)
    track_states: dict[int, _ControllerState] = field(default_factory=dict)
    track: int = -1
    notes: dict[int, ChannelNote] = field(default_factory=dict)
    last_end: int = _NEVER

    def sounding(self, note: ChannelNote) -> list[ChannelNote]:
        """Return the notes that sound when another starts, and forget those that have ended."""
        self.notes = {p: old for p, old in self.notes.items() if not old.has_ended(note)}
        return list(self.notes.values())

    def is_open(self, note: ChannelNote) -> bool:
        """Return whether a note can be added: no sounding note has a controller curve."""
        return not any(old.curve for old in self.sounding(note))

    def same_pitch(self, note: ChannelNote) -> ChannelNote | None:
        """Return the sounding note of the same pitch."""
        old = self.notes.get(note.pitch)
        return old if old is not None and not old.has_ended(note) else None

    def is_ringing(self, note: ChannelNote, tail: int) -> bool:
        """Return whether an ended note may still ring when another starts."""
        return self.last_end + tail > note.start

    def add(self, note: ChannelNote) -> None:
        """Play a note."""
        note.channel = self.number
        if not note.drum:
            self.state.apply(note)
            self.track_states.setdefault(note.track, _ControllerState()).apply(note)
        self.track = note.track
        self.notes[note.pitch] = note
        self.last_end = max(self.last_end, note.end)


def allocate_channels(
    notes: list[ChannelNote], tail: int
) -> tuple[list[ChannelNote], AllocationLosses]:
    """Assign channels to notes.

    Args:
        notes: sorted by (start, track); their ends may be shortened and velocities raised.
        tail: ticks for which an instrument may ring after its note's end.

    Returns:
        The notes that are played, and the compromises; every dropped note is merged with another.
    """
    channels = [_Channel(number) for number in CHANNELS]
    drums = _Channel(DRUM_CHANNEL)
    played: list[ChannelNote] = []
    losses = AllocationLosses()
    for note in notes:
        if note.drum:
            channel = _drum_channel(drums, note, losses)
        else:
            channel = _choose_channel(channels, note, tail, losses)
        if channel is not None:
            channel.add(note)
            played.append(note)
    return played, losses


def _drum_channel(drums: _Channel, note: ChannelNote, losses: AllocationLosses) -> _Channel | None:
    old = drums.same_pitch(note)
    if old is None or losses.end_early(old, note):
        return drums
    losses.merge(old, note)
    return None


def _choose_channel(
    channels: list[_Channel], note: ChannelNote, tail: int, losses: AllocationLosses
) -> _Channel | None:
    """Return the channel of a note; None if it is merged with another note."""
    silent = [c for c in channels if not c.sounding(note)]
    if note.curve and not silent:
        # Impacts fade quickly, whereas a sustained sound stays audible.
        stolen = _steal([c for c in channels if c.is_open(note)], note, losses)
        if stolen is not None:
            return stolen
        note.curve = ()
        losses.without_curve += 1
    shared = silent if note.curve else [c for c in channels if c.is_open(note)]
    suitable = [c for c in shared if c.state.suits(note)]
    own = [c for c in suitable if c.track == note.track]
    for channel in own:
        # A change of pitch bend would be audible in the ring of the last note.
        bends_ring = (channel.state.is_bent or bool(note.curve)) and channel.is_ringing(note, tail)
        if channel.same_pitch(note) is None and not bends_ring:
            return channel
    if _merge_with_equal(own, note, losses):
        return None
    if silent:
        return _least_recent(silent, note, tail, losses)
    return _share_channel(channels, shared, suitable, note, losses)


def _least_recent(
    silent: list[_Channel], note: ChannelNote, tail: int, losses: AllocationLosses
) -> _Channel:
    """Return the silent channel used least recently, preferring one with the program."""
    best = min(
        silent,
        key=lambda c: (c.is_ringing(note, tail), c.state.program != note.program, c.last_end),
    )
    losses.tails_cut += best.is_ringing(note, tail)
    return best


def _share_channel(
    channels: list[_Channel],
    shared: list[_Channel],
    suitable: list[_Channel],
    note: ChannelNote,
    losses: AllocationLosses,
) -> _Channel | None:
    """Return a channel for a note that starts while all channels sound."""
    for channel in suitable:
        if channel.same_pitch(note) is None:
            return channel
    if _merge_with_equal(suitable, note, losses):
        return None
    for channel in suitable:
        old = channel.same_pitch(note)
        if old is not None and losses.end_early(old, note):
            return channel
    similar = [c for c in shared if c.state.program == note.program]
    similar.sort(key=lambda c: (abs(c.state.pan - note.pan), abs(c.state.send - note.send)))
    near = _move_to_similar(similar, note, losses)
    if near is not None or _merge_with_equal(similar, note, losses):
        return near
    stolen = _steal(channels, note, losses)
    if stolen is None:
        sounding = [(c, old) for c in channels for old in c.sounding(note)]
        _, most_similar = min(sounding, key=lambda pair: _difference(pair[0], pair[1], note))
        losses.merge(most_similar, note)
    return stolen


def _merge_with_equal(
    channels: list[_Channel], note: ChannelNote, losses: AllocationLosses
) -> bool:
    """Merge a note with one of the same onset and pitch; return whether there is one."""
    for channel in channels:
        old = channel.same_pitch(note)
        if old is not None and old.start == note.start:
            losses.merge(old, note)
            return True
    return False


def _move_to_similar(
    similar: list[_Channel], note: ChannelNote, losses: AllocationLosses
) -> _Channel | None:
    """Change a note's pan and reverb to those of the nearest channel with its program."""
    for channel in similar:
        if channel.same_pitch(note) is None:
            losses.pan_changed += note.pan != channel.state.pan
            losses.reverb_changed += note.send != channel.state.send
            note.pan, note.send = channel.state.pan, channel.state.send
            return channel
    return None


def _steal(
    channels: list[_Channel], note: ChannelNote, losses: AllocationLosses
) -> _Channel | None:
    """Silence the channel with the oldest last onset, as a synthesiser steals a voice.

    None if all channels have notes with the onset of the new one.
    """
    for channel in sorted(channels, key=lambda c: max(old.start for old in c.sounding(note))):
        sounding = channel.sounding(note)
        if all(old.can_end_before(note) for old in sounding):
            for old in sounding:
                losses.end_early(old, note)
            return channel
    return None


def _difference(
    channel: _Channel, old: ChannelNote, note: ChannelNote
) -> tuple[int, bool, int, int]:
    distance = abs(channel.state.pan - note.pan), abs(old.pitch - note.pitch)
    return (-old.start, channel.state.program != note.program, *distance)
