"""The author's words for sound: voices, scale, volume."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Field, model_validator

from audio.instruments import drum_of, program_of
from audio.model import Words
from audio.phrase_words import Phrase
from audio.pitch_words import ChordName, Pitch, ScaleName
from audio.quantise_words import QuantiseWords
from audio.track_words import Master, MasterOrOff, Room, RoomOrName
from audio.velocity_words import Velocity, VelocityWords


def _known_instrument(name: str) -> str:
    program_of(name)
    return name


def _known_drum(name: str) -> str:
    drum_of(name)
    return name


Instrument = Annotated[str, AfterValidator(_known_instrument)]
Drum = Annotated[str, AfterValidator(_known_drum)]
Pattern = Annotated[str, Field(min_length=1)]
Share = Annotated[float, Field(ge=0, le=1)]


class Within(Words):
    """A range of numbers."""

    above: float | None = Field(None, ge=0, description="The least that fits.")
    below: float | None = Field(None, gt=0, description="What is as much or more does not fit.")

    @model_validator(mode="after")
    def _holds_something(self) -> Self:
        if self.above is not None and self.below is not None and self.above >= self.below:
            raise ValueError(f"nothing is above {self.above:g} and below {self.below:g}")
        return self

    def holds(self, value: float) -> bool:
        """Say whether a number lies within."""
        return (self.above is None or value >= self.above) and (
            self.below is None or value < self.below
        )


class When(Words):
    """Which events a voice is for; all that is given must fit, `*` stands for any letters."""

    cause: Pattern | None = Field(None, description="What happened, such as footfall or scuff.")
    who: Pattern | None = Field(None, description="Name of the performer that sounds.")
    part: Pattern | None = Field(None, description="Its part, such as foot_l1 or foot_*.")
    other: Pattern | None = Field(None, description="What it met, such as terrain or crate.")
    material: Pattern | None = Field(None, description="Material of the part that sounds.")
    surface: Pattern | None = Field(None, description="Material of what it met.")
    size: Within | None = Field(None, description="Length of what sounds [m].")
    strength: Within | None = Field(
        None, description="Speed of the blow, or of the motion that sounds [m/s]."
    )


class Voice(Words):
    """How some events sound; what is not said is chosen by cause, material and size."""

    when: When = Field(When(), description="The events that this voice is for; all if empty.")
    instrument: Instrument | None = Field(
        None, description="Name of a General MIDI instrument that plays the notes of the score."
    )
    drum: Drum | None = Field(
        None,
        description="Name of a General MIDI drum, such as 'low wood block', that plays the notes "
        "on the channel of drums, instead of an instrument and its pitch.",
    )
    pitch: Pitch | None = Field(
        None,
        description="MIDI number, note name (C4 is 60), 'by size' (small is high), 'by foot' or "
        "'by part' (a step of the scale for each part), or 'by foot from C3' (the first foot "
        "there); tunes the note and the sound.",
    )
    scale: ScaleName | None = Field(
        None, description="Scale of these notes, or a chord whose notes are the steps."
    )
    chord: ChordName | None = Field(
        None, description="Chord that is played at once, such as Am7, its root nearest to pitch."
    )
    octave: int = Field(0, ge=-8, le=8, description="Octaves higher, or lower.")
    transpose: int = Field(0, ge=-48, le=48, description="Semitones higher, or lower.")
    phrase: Phrase | None = Field(
        None,
        description="Notes that answer an event: degrees such as [0, 2, [0, 4], rest, 7], or "
        "mappings that also say how long each lasts; or all of it with one time for each step, as "
        "in {steps: [0, 2, 4], beats: 0.25}.",
    )
    velocity: Velocity | None = Field(
        None, description="How hard notes are struck; a number for always so."
    )
    length: float | None = Field(
        None, gt=0, le=60, description="How long the note lasts and the sound dies away [s]."
    )
    gain_db: float = Field(0.0, ge=-60, le=24, description="Louder or softer [dB].")
    pan: float | None = Field(
        None, ge=-1, le=1, description="From left (-1) to right (1), instead of where it is."
    )
    reverb: Share | None = Field(
        None, description="Share of what is far that the room gives back; 0 is dry."
    )
    quantise: bool = Field(
        True, description="False to leave these events where their causes are, off the grid."
    )
    mute: bool = Field(False, description="True to silence these events in score and sound.")

    @model_validator(mode="after")
    def _drum_or_instrument(self) -> Self:
        if self.drum is not None and (self.instrument is not None or self.pitch is not None):
            raise ValueError("give either drum, or instrument and pitch: a drum has one pitch")
        tuned = [w for w in ("scale", "chord", "octave", "transpose") if getattr(self, w)]
        steps = self.phrase.steps if self.phrase else ()
        if any(step.chord is not None or step.degrees != (0,) for step in steps):
            tuned.append("degrees or chords in its phrase")
        if self.drum is not None and tuned:
            raise ValueError(f"a drum has one pitch; leave out {', '.join(tuned)}")
        if self.chord is not None and self.phrase is not None:
            raise ValueError("give either chord or phrase: steps of a phrase may have chords")
        return self


class Sound(Words):
    """The sound of a scene: the scale of its notes, its voices, its loudness."""

    scale: ScaleName = Field(
        "C minor pentatonic",
        description="Scale of the pitches that follow size or part: a root and a kind, such as "
        "'A dorian', or 'chromatic', or a chord such as Am7. A pitch given as a note stays as it "
        "is.",
    )
    voices: tuple[Voice, ...] = Field((), description="Voices; the first that fits an event wins.")
    tempo_bpm: float = Field(
        120.0, ge=10, le=480, description="Beats a minute of phrases and of the quantisation."
    )
    quantise: QuantiseWords | None = Field(
        None, description="Draws notes to the grid of the tempo; nothing moves if not said."
    )
    velocity: Velocity = Field(VelocityWords(), description="How hard notes are struck.")
    reverb: Share = Field(
        0.5, description="Share of what is far that the room gives back; 0 is dry."
    )
    tracks: Literal["performer", "cause"] = Field(
        "performer", description="Whether each performer or each cause has a track of the score."
    )
    volume_db: float = Field(
        0.0, ge=-60, le=24, description="Loudness of the whole, score and sound [dB]."
    )
    listener: Literal["camera"] | tuple[float, float, float] = Field(
        "camera",
        description="Where one listens: at the camera, or at a place [x, y, z] facing as it does.",
    )
    room: RoomOrName = Field(Room(), description="What the track sounds in: open, dry, room, hall.")
    master: MasterOrOff = Field(
        Master(), description="How loud the track is made; off to leave it as it is."
    )
    soundfont: str | None = Field(
        None,
        min_length=1,
        description="A SoundFont (.sf2) beside the scene that plays the score as the track.",
    )
