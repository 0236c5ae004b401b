"""Score: the input of the sound writers.

Events are placed relative to the listener. A score has frames, seconds and materials, but no
terrain, figures or cameras.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from math import isfinite
from typing import Literal

from audio.ambience import Ambience
from audio.body_shape import BodyShape
from audio.config.sound import Sound
from audio.errors import ScoreError
from audio.music.scene_course import UNKNOWN_COURSE, SceneCourse
from audio.music.song_file import Song


@dataclass(frozen=True, slots=True)
class Bearing:
    """Position of a sound relative to the listener at one moment.

    Attributes:
        distance: from the listener [m].
        azimuth: direction [rad]; 0 straight ahead, positive to the right.
        approach_speed: rate at which the distance shrinks [m/s].
    """

    distance: float
    azimuth: float
    approach_speed: float = 0.0


@dataclass(frozen=True, slots=True)
class ScoreEvent:
    """One sound: an onset with its cause, place and strength.

    Attributes:
        frame: 1-based frame that first shows the event; its note stands at (frame - 1) / fps.
        time: exact time of the cause [s], at most one frame before its frame's time.
        cause: "footfall", "scuff", "collision", ...
        who: performer that sounds, such as "bug".
        part: part that sounds, such as "foot_l1"; empty for the whole performer.
        other: what the part met, such as "terrain"; may be empty.
        material: of the part, such as "chitin".
        surface: material of what the part met, such as "dry soil"; may be empty.
        strength: approach speed of an impact, or speed of a motion [m/s].
        energy: of the impact [J].
        size: characteristic length of the part [m].
        distance: from the listener [m]; of a sustained sound the smallest.
        azimuth: direction at that distance [rad]; 0 straight ahead, positive to the right.
        duration: of a sustained sound [s]; 0 for an impact.
        speeds: of a sustained sound, at even times from onset to end [m/s]; empty if constant or
            unknown.
        course: of a sustained sound that moves, its bearings at these times; empty if it stays.
        spot: point of impact along the part's longest axis, 0 to 1; None if unknown.
        shape: of the part; None if unknown.
        struck_shape: of the body that the part met; None for the ground or if unknown.
        is_passing: whether a dancer's hand only brushes something on its way, on no beat.
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
    shape: BodyShape | None = None
    struck_shape: BodyShape | None = None
    is_passing: bool = False

    @property
    def key(self) -> tuple[object, ...]:
        """Identity of the event, which seeds its random variation.

        Without its exact time, whose last bit differs between classes of processor.
        """
        return (self.frame, self.cause, self.who, self.part, self.other)

    @property
    def label(self) -> str:
        """Cause, part and counterpart, such as "footfall: bug.l1 > terrain"."""
        source = f"{self.cause}: {self.who}" + (f".{self.part}" if self.part else "")
        return source + (f" > {self.other}" if self.other else "")


@dataclass(frozen=True, slots=True)
class Marker:
    """A cut or a script instruction.

    Attributes:
        frame: 1-based frame of its start.
        kind: of marker.
        text: description, such as "side of bug".
    """

    frame: int
    kind: Literal["cut", "script"]
    text: str

    @property
    def label(self) -> str:
        """Kind and text, such as "cut: side of bug"."""
        return f"{self.kind}: {self.text}"


@dataclass(frozen=True, slots=True)
class DanceBeat:
    """The beat to which a scene's dancers dance.

    Attributes:
        tempo: beats a minute.
        start: time of the first beat [s].
        meter: beats of a bar and the note value of each.
    """

    tempo: Fraction
    start: Fraction
    meter: tuple[int, int] = (4, 4)


@dataclass(frozen=True, slots=True)
class Score:
    """Events with the frame grid that they stand on.

    Attributes:
        rate: frames a second.
        frames: number of frames; the score lasts exactly frames / rate seconds.
        events: in the order of (frame, time, who, part).
        sound: configuration of voices, room and loudness.
        seed: of the random variation in the synthesis.
        title: of the scene; may hold any character.
        markers: cuts and script instructions in the order of frames.
        subframe: whether sounds stand at the exact times of their causes instead of on the
            frames that first show them.
        dance: beat of the dancers who start first; None without any.
        ambience: ambient sound, in the track alone; None for silence.
        song: that the configuration of the music names; None without any.
        course: tension and motion of the scene, which generated music follows.
    """

    rate: Fraction
    frames: int
    events: tuple[ScoreEvent, ...]
    sound: Sound
    seed: int = 0
    title: str = ""
    markers: tuple[Marker, ...] = ()
    subframe: bool = False
    dance: DanceBeat | None = None
    ambience: Ambience | None = None
    song: Song | None = None
    course: SceneCourse = UNKNOWN_COURSE

    def onset(self, event: ScoreEvent) -> Fraction:
        """Return the time of an event's sound [s]."""
        return event.time if self.subframe else _frame_time(event.frame, self.rate)

    def validate(self) -> None:
        """Check length, rate and events.

        Raises:
            ScoreError: an event lies outside the score or holds a number that is not finite.
        """
        if self.frames < 1:
            raise ScoreError(f"a score has at least one frame; got {self.frames}")
        if self.rate <= 0:
            raise ScoreError(f"a frame rate is positive; got {self.rate}")
        end = self.frames / self.rate
        for event in self.events:
            self._validate_event(event, end)

    def _validate_event(self, event: ScoreEvent, end: Fraction) -> None:
        name = f"{event.cause} of {event.who}.{event.part} at frame {event.frame}"
        if not 1 <= event.frame <= self.frames:
            raise ScoreError(f"{name} lies outside frames 1 to {self.frames}")
        if not 0 <= self.onset(event) < end:
            raise ScoreError(f"{name}: its time, {float(event.time):.6g} s, lies outside the film")
        if not all(isfinite(speed) and speed >= 0 for speed in event.speeds):
            raise ScoreError(f"{name}: speeds must be finite and not negative")
        for field in ("strength", "energy", "size", "distance", "azimuth", "duration"):
            if not isfinite(getattr(event, field)):
                raise ScoreError(f"{name}: {field} is {getattr(event, field)}")
        if event.size <= 0 or min(event.distance, event.duration, event.energy) < 0:
            raise ScoreError(
                f"{name}: size must be positive; distance, duration and energy not negative"
            )


@lru_cache(maxsize=4096)
def _frame_time(frame: int, rate: Fraction) -> Fraction:
    """Return the time of a frame [s]; a crash has hundreds of events on one."""
    return (frame - 1) / rate
