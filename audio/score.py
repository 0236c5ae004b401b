"""Score: all that the sound writers are given.

Events are already placed as the listener hears them; a score knows frames,
seconds and materials, and nothing of terrain, figures or cameras.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

from audio.words import Sound


@dataclass(frozen=True, slots=True)
class Bearing:
    """Where a sound is for the listener, at one moment.

    Attributes:
        distance: from the listener [m].
        azimuth: its direction [rad]; 0 straight ahead, positive to the right.
        nearing: how fast it comes nearer [m/s]; negative for what goes away.
    """

    distance: float
    azimuth: float
    nearing: float = 0.0


@dataclass(frozen=True, slots=True)
class ScoreEvent:
    """One sound: an onset with its cause, place and strength.

    Attributes:
        frame: 1-based frame that first shows the event; its note stands at (frame - 1) / fps.
        time: exact time of the cause [s], at most one frame before its frame's time.
        cause: "footfall", "scuff", "collision", ...
        who: performer that sounds, such as "bug".
        part: the part of it, such as "foot_l1"; empty for the whole.
        other: what it met, such as "terrain"; empty where there is nothing.
        material: of the part that sounds, such as "chitin".
        surface: material of what it met, such as "dry soil"; may be empty.
        strength: approach speed [m/s]; for motions their speed.
        energy: of the impact [J].
        size: characteristic length of what sounds [m].
        distance: from the listener [m]; of what lasts, where it comes nearest.
        azimuth: direction as heard there [rad]; 0 straight ahead, positive to the right.
        duration: of a sound that lasts [s]; 0 for an impact.
        speeds: of a sound that lasts, at even times from its onset to its end [m/s]; empty where
            it does not change or is not known.
        course: of a sound that lasts and moves, where it is at these times; empty where it stays.
        spot: where on itself it is struck, 0 to 1 along its longest axis; None if that is unknown.
    """

    frame: int
    time: Fraction
    cause: str
    who: str
    part: str = ""
    other: str = ""
    material: str = ""
    surface: str = ""
    strength: float = 1.0
    energy: float = 0.0
    size: float = 0.1
    distance: float = 1.0
    azimuth: float = 0.0
    duration: float = 0.0
    speeds: tuple[float, ...] = ()
    course: tuple[Bearing, ...] = ()
    spot: float | None = None


@dataclass(frozen=True, slots=True)
class Marker:
    """A place in the film that its makers should find again.

    Attributes:
        frame: 1-based frame from which it holds.
        kind: what it is.
        text: such as "follows bug, side".
    """

    frame: int
    kind: Literal["cut", "script"]
    text: str


@dataclass(frozen=True, slots=True)
class Score:
    """Events with the frame grid that they stand on.

    Attributes:
        rate: frames a second.
        frames: number of frames; the score lasts exactly frames / rate seconds.
        events: in the order of (frame, time, who, part).
        sound: the author's words on voices.
        seed: of what varies in the synthesis.
        title: of the scene; may hold any character.
        markers: cuts and instructions of the script, in the order of frames.
        subframe: whether sounds stand at the exact times of their causes instead of on the
            frames that first show them.
    """

    rate: Fraction
    frames: int
    events: tuple[ScoreEvent, ...]
    sound: Sound
    seed: int = 0
    title: str = ""
    markers: tuple[Marker, ...] = ()
    subframe: bool = False

    def onset(self, event: ScoreEvent) -> Fraction:
        """Return the time at which an event is to be heard [s]."""
        return event.time if self.subframe else (event.frame - 1) / self.rate
