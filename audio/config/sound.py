"""Configuration of sound: voices, scale, tempo, room and loudness."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from audio.config import AudioConfig, checked_by, listed_in
from audio.config.meter import MeterText, Tempo, TempoChange
from audio.config.music import Music
from audio.config.phrase import PhraseOrSteps
from audio.config.pitch import ChordName, Pitch, ScaleName
from audio.config.quantisation import Quantisation
from audio.config.velocity import Velocity, VelocityOrNumber
from audio.general_midi import drum_key, program_number
from audio.harmony import parse_steps
from audio.music.composition import check_chords

Instrument = Annotated[str, checked_by(program_number), listed_in("instruments")]
Drum = Annotated[str, checked_by(drum_key), listed_in("drums")]
Pattern = Annotated[str, Field(min_length=1)]
DEFAULT_TEMPO = 120.0
"""Tempo of what counts beats where none is written [1/min]."""

Share = Annotated[float, Field(ge=0, le=1)]


class Range(AudioConfig):
    """A range of numbers."""

    above: float | None = Field(None, ge=0, description="Lower bound, included.")
    below: float | None = Field(None, gt=0, description="Upper bound, excluded.")

    @model_validator(mode="after")
    def _check_bounds(self) -> Self:
        if self.above is not None and self.below is not None and self.above >= self.below:
            raise ValueError(f"nothing is above {self.above:g} and below {self.below:g}")
        return self

    def contains(self, value: float) -> bool:
        """Return whether a number lies within."""
        return (self.above is None or value >= self.above) and (
            self.below is None or value < self.below
        )


class EventFilter(AudioConfig):
    """Selects events; every given condition must hold, `*` stands for any letters."""

    cause: Annotated[Pattern, listed_in("causes")] | None = Field(
        None, description="Cause, such as footfall or scuff."
    )
    who: Pattern | None = Field(None, description="Name of the performer that sounds.")
    part: Pattern | None = Field(None, description="Its part, such as foot_l1 or foot_*.")
    other: Pattern | None = Field(None, description="What it met, such as terrain or crate.")
    material: Pattern | None = Field(None, description="Material of the part that sounds.")
    surface: Pattern | None = Field(None, description="Material of what it met.")
    size: Range | None = Field(None, description="Length of the part that sounds [m].")
    strength: Range | None = Field(
        None, description="Speed of the impact, or of the motion that sounds [m/s]."
    )


class Voice(AudioConfig):
    """Sound of some events; defaults follow cause, material and size."""

    when: EventFilter = Field(EventFilter(), description="The events it applies to; default all.")
    instrument: Instrument | None = Field(
        None, description="Name of the General MIDI instrument that plays the notes."
    )
    drum: Drum | None = Field(
        None,
        description="Name of a General MIDI drum, such as 'low wood block', that plays the notes "
        "on the drum channel, instead of an instrument and its pitch.",
    )
    pitch: Pitch | None = Field(
        None,
        description="MIDI number, note name (C4 is 60), 'by size' (small is high), 'by foot' or "
        "'by part' (a scale step for each part), or 'by foot from C3' (the first foot there); "
        "tunes the note and the sound.",
    )
    scale: ScaleName | None = Field(
        None, description="Scale of these notes, or a chord whose notes are the steps."
    )
    chord: ChordName | None = Field(
        None, description="Chord that is played at once, such as Am7, its root nearest to pitch."
    )
    octave: int = Field(0, ge=-8, le=8, description="Octaves higher, or lower.")
    transpose: int = Field(0, ge=-48, le=48, description="Semitones higher, or lower.")
    phrase: PhraseOrSteps | None = Field(
        None,
        description="Notes that answer an event: degrees such as [0, 2, [0, 4], rest, 7], or "
        "mappings that also say how long each lasts; or all of it with one time for each step, as "
        "in {steps: [0, 2, 4], beats: 0.25}.",
    )
    velocity: VelocityOrNumber | None = Field(
        None, description="Velocity curve of the notes; a number for a fixed velocity."
    )
    length: float | None = Field(
        None, gt=0, le=60, description="Length of the note and decay time of the sound [s]."
    )
    gain_db: float = Field(0.0, ge=-60, le=24, description="Gain [dB].")
    pan: float | None = Field(
        None, ge=-1, le=1, description="From left (-1) to right (1); default where it happens."
    )
    reverb: Share | None = Field(
        None, description="Share of distant sound that the room reverberates; 0 is dry."
    )
    quantise: bool = Field(True, description="False to leave these events off the grid.")
    mute: bool = Field(False, description="True to silence these events in score and sound.")

    @model_validator(mode="after")
    def _check_conflicts(self) -> Self:
        if self.drum is not None and (self.instrument is not None or self.pitch is not None):
            raise ValueError("give either drum, or instrument and pitch: a drum has one pitch")
        tuned = [key for key in ("scale", "chord", "octave", "transpose") if getattr(self, key)]
        steps = self.phrase.steps if self.phrase else ()
        if any(step.chord is not None or step.degrees != (0,) for step in steps):
            tuned.append("degrees or chords in its phrase")
        if self.drum is not None and tuned:
            raise ValueError(f"a drum has one pitch; leave out {', '.join(tuned)}")
        if self.chord is not None and self.phrase is not None:
            raise ValueError("give either chord or phrase: steps of a phrase may have chords")
        return self


RoomName = Literal["open", "dry", "room", "hall"]

Metres = Annotated[float, Field(gt=0, le=1000)]


class Room(AudioConfig):
    """Acoustics of the place; the preset supplies the other keys."""

    preset: RoomName = Field(
        "open", description="open (the ground and little else), dry (nothing), room or hall."
    )
    size: tuple[Metres, Metres, Metres] | None = Field(
        None, description="Width, height and depth [m]; walls move out to enclose every source."
    )
    absorption: float | None = Field(
        None, ge=0, le=1, description="Share of the sound's energy that walls and ground absorb."
    )
    seconds: float | None = Field(
        None, gt=0, le=20, description="Time in which the reverberation falls by 60 dB [s]."
    )
    wet_db: float | None = Field(
        None, ge=-80, le=12, description="Level of the reverberation at full send [dB]."
    )


class Master(AudioConfig):
    """Loudness of the whole track."""

    lufs: float = Field(-16.0, ge=-40, le=-6, description="Target integrated loudness [LUFS].")
    true_peak_db: float = Field(
        -1.0, ge=-20, le=-0.1, description="Ceiling of peaks, between samples too [dB]."
    )
    most_gain_db: float = Field(
        30.0,
        ge=0,
        le=60,
        description="Greatest gain of a soft scene [dB]: a nearly silent scene stays soft.",
    )
    most_limiting_db: float = Field(
        6.0,
        ge=0,
        le=18,
        description="Greatest reduction of the highest peak [dB], and of rare ones alone: loud "
        "sounds stay louder than soft ones.",
    )


Decibels = Annotated[float, Field(ge=-60, le=24)]


class Mix(AudioConfig):
    """Gains of the buses of the track."""

    steps_db: Decibels = Field(0.0, description="Gain of footfalls and scuffs [dB].")
    impacts_db: Decibels = Field(0.0, description="Gain of what strikes, rolls and slides [dB].")
    voices_db: Decibels = Field(0.0, description="Gain of cries, hugs and breath [dB].")
    motions_db: Decibels = Field(
        0.0, description="Gain of what whirs, sings, springs and squeaks [dB]."
    )
    ambience_db: Decibels = Field(0.0, description="Gain of the ambience [dB].")
    music_db: Decibels = Field(0.0, description="Gain of the music [dB].")
    duck_db: float = Field(
        6.0, ge=0, le=40, description="By how much ambience and music give way to voices [dB]."
    )


def _expand_room(value: object) -> object:
    return {"preset": value} if isinstance(value, str) else value


def _expand_master(value: object) -> object:
    # YAML reads a bare `off` as a truth value.
    return None if value is False or value == "off" else value


AmbienceName = Literal[
    "auto", "none", "meadow", "forest", "desert", "shore", "stream", "rain", "night", "street",
    "fire", "room", "underwater",
]  # fmt: skip


def _channels(value: object) -> object:
    # YAML reads 5.1 as a number.
    return "5.1" if value == 5.1 and isinstance(value, float) else value


LayoutName = Literal["stereo", "5.1", "b-format"]

ChannelsName = Annotated[
    LayoutName, BeforeValidator(_channels, json_schema_input_type=LayoutName | Literal[5.1])
]

RoomOrName = Annotated[Room, BeforeValidator(_expand_room, json_schema_input_type=RoomName | Room)]
MasterOrOff = Annotated[
    Master | None,
    BeforeValidator(_expand_master, json_schema_input_type=Literal["off", False] | Master),
]


class Sound(AudioConfig):
    """The sound of a scene: the scale of its notes, its voices, its loudness."""

    scale: ScaleName = Field(
        "C minor pentatonic",
        description="Scale of the pitches that follow size or part: a root and a kind, such as "
        "'A dorian', or 'chromatic', or a chord such as Am7. Pitches given as notes ignore it.",
    )
    voices: tuple[Voice, ...] = Field(
        (), description="Voices; the first whose conditions hold for an event is used."
    )
    tempo_bpm: Tempo | None = Field(
        None,
        description="Quarter notes a minute of the score, its phrases and quantisation; if left "
        "out, that of the dance or of the events, and 120 where beats are counted.",
    )
    meter: MeterText | None = Field(
        None, description="Beats of a bar, such as 3/4 or 6/8; as the dance has it, or 4/4."
    )
    tempo_map: tuple[TempoChange, ...] = Field(
        (),
        max_length=1000,
        description="Changes of tempo and meter at bars, [{bar: 5, tempo_bpm: 90}, ...].",
    )
    first_bar: float | None = Field(
        None,
        ge=0,
        le=1e6,
        description="Time of bar 1 [s]; where the dance or the music begins if left out.",
    )
    quantise: Quantisation | None = Field(
        None, description="Moves notes to the grid of the tempo; default no quantisation."
    )
    velocity: VelocityOrNumber = Field(Velocity(), description="Velocity curve of the notes.")
    reverb: Share = Field(
        0.5, description="Share of distant sound that the room reverberates; 0 is dry."
    )
    tracks: Literal["performer", "cause"] = Field(
        "performer", description="Whether each performer or each cause has a MIDI track."
    )
    mpe: bool = Field(
        False,
        description="Whether each note has a channel of its own (MPE), so that sounds of one "
        "instrument bend independently.",
    )
    volume_db: float = Field(
        0.0, ge=-60, le=24, description="Gain of the whole, score and sound [dB]."
    )
    listener: Literal["camera"] | tuple[float, float, float] = Field(
        "camera", description="At the camera, or at a place [x, y, z] with its orientation."
    )
    ambience: AmbienceName = Field(
        "auto",
        description="Ambient sound: auto goes by ground, hour and weather; none is silence.",
    )
    channels: ChannelsName = Field(
        "stereo",
        description="5.1 or b-format (AmbiX, first order) also writes a WAV file so.",
    )
    music: Music | None = Field(
        None, description="Music: sections of bars, a MIDI file, or a generator."
    )
    mix: Mix = Field(
        Mix(), description="Gains of steps, impacts, voices, motions, ambience and music."
    )
    room: RoomOrName = Field(Room(), description="Acoustics of the track: open, dry, room, hall.")
    master: MasterOrOff = Field(
        Master(), description="Loudness of the track; off to leave the mix as it is."
    )
    soundfont: str | None = Field(
        None,
        min_length=1,
        description="A SoundFont (.sf2) beside the scene that plays the score as the track.",
    )

    @model_validator(mode="after")
    def _check_channels(self) -> Self:
        if self.soundfont is not None and self.channels != "stereo":
            raise ValueError("a soundfont plays in stereo; leave out soundfont or channels")
        return self

    @model_validator(mode="after")
    def _check_bars(self) -> Self:
        if self.tempo_map and self.tempo_bpm is None:
            raise ValueError("tempo_map needs tempo_bpm, the tempo of bar 1")
        bars = [change.bar for change in self.tempo_map]
        for earlier, later in pairwise(bars):
            if later <= earlier:
                raise ValueError(
                    f"tempo_map has bar {later} after bar {earlier}; write its bars in their order"
                )
        if self.tempo_map and self.beat_origin < 0:
            raise ValueError(
                f"tempo_map counts bars from quantise.offset, {self.beat_origin:g} s, before the "
                "film; give first_bar, the time of bar 1, instead of it"
            )
        if self.first_bar is not None and self.quantise is not None and self.quantise.offset:
            raise ValueError(
                "first_bar conflicts with quantise.offset: both are the time of a beat; remove one"
            )
        return self

    @model_validator(mode="after")
    def _check_music(self) -> Self:
        if self.music is not None:
            check_chords(self.music, parse_steps(self.scale))
        return self

    @property
    def beats_per_minute(self) -> float:
        """Tempo in which phrases and quantisation count beats [1/min]."""
        return DEFAULT_TEMPO if self.tempo_bpm is None else self.tempo_bpm

    @property
    def beat_origin(self) -> float:
        """Time of a beat of quantisation and of dancers that are locked to beats [s]."""
        if self.first_bar is not None:
            return self.first_bar
        return self.quantise.offset if self.quantise is not None else 0.0

    @property
    def counts_beats(self) -> bool:
        """Whether its tempo is written, or something in it is measured in beats."""
        phrases = [voice.phrase for voice in self.voices if voice.phrase is not None]
        return (
            self.tempo_bpm is not None
            or self.quantise is not None
            or any(not phrase.is_timed for phrase in phrases)
        )
