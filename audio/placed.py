"""Notes on their channels, and what had to be given up to put them there."""

from __future__ import annotations

from dataclasses import dataclass, field

from audio.gestures import Moment


@dataclass(slots=True)
class Placed:
    """A note on its channel.

    Attributes:
        track: index of the performer's or the cause's track.
        start: tick of its onset.
        end: tick of its end; later than the start.
        program: General MIDI program.
        pan: pan controller's value, 0 to 127.
        pitch: MIDI pitch.
        velocity: 1 to 127.
        gesture: what happens to it while it sounds, from its start on; empty for nothing.
        send: reverb controller's value, 0 to 127.
        drum: whether it belongs to the channel of drums, which has its own programs and pans.
        channel: 0 to 15; 9 for drums alone.
        sets_program: whether a program change must stand before it.
        sets_pan: whether a pan change must stand before it.
        sets_send: whether a change of the reverb's share must stand before it.
        sets_range: whether the range of the pitch wheel must be said before it.
        rests: whether pitch wheel and expression must be brought back before it.
    """

    track: int
    start: int
    end: int
    program: int
    pan: int
    pitch: int
    velocity: int
    gesture: tuple[Moment, ...] = ()
    send: int = 0
    drum: bool = False
    channel: int = -1
    sets_program: bool = False
    sets_pan: bool = False
    sets_send: bool = False
    sets_range: bool = False
    rests: bool = False

    def cut(self, end: int) -> None:
        """End it earlier."""
        self.end = end
        self.gesture = tuple(moment for moment in self.gesture if moment.tick < end)


@dataclass(slots=True)
class Losses:
    """What had to be given up because there are fifteen channels.

    Attributes:
        merged: ticks of notes that another one stands for, which begins with them.
        moved: notes heard from a neighbouring direction.
        reverbs: notes heard with another share of the room's reverb.
        cut_short: notes ended so that another can be struck.
        tails_cut: channels taken over while their last note still rang.
        stiff: notes that had to do without their gesture.
    """

    merged: list[int] = field(default_factory=list)
    moved: int = 0
    reverbs: int = 0
    cut_short: int = 0
    tails_cut: int = 0
    stiff: int = 0
