"""The author's words for sound: voices, scale, volume."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, PlainValidator, model_validator

from audio.instruments import drum_of, program_of
from audio.names import folded
from audio.scales import parse_note, parse_scale
from audio.track_words import Master, MasterOrOff, Room, RoomOrName

PITCH_RULES = ("by size", "by foot", "by part")


def _known_instrument(name: str) -> str:
    program_of(name)
    return name


def _known_drum(name: str) -> str:
    drum_of(name)
    return name


def _known_scale(text: str) -> str:
    parse_scale(text)
    return text


def _known_pitch(pitch: object) -> int | str:
    allowed = f"a MIDI number 0 to 127, a note such as C4, or one of: {', '.join(PITCH_RULES)}"
    if isinstance(pitch, int) and not isinstance(pitch, bool) and 0 <= pitch <= 127:
        return pitch
    if not isinstance(pitch, str):
        raise ValueError(f"a pitch is {allowed}; got {pitch!r}")
    if folded(pitch) in PITCH_RULES:
        return folded(pitch)
    try:
        return parse_note(pitch)
    except ValueError as error:
        raise ValueError(f"{error} (a pitch is {allowed})") from error


Instrument = Annotated[str, AfterValidator(_known_instrument)]
Drum = Annotated[str, AfterValidator(_known_drum)]
ScaleName = Annotated[str, AfterValidator(_known_scale)]
# One validator instead of a union, so that a slip is reported once and in our words.
Pitch = Annotated[
    int | str,
    PlainValidator(_known_pitch, json_schema_input_type=Annotated[int, Field(ge=0, le=127)] | str),
]
Pattern = Annotated[str, Field(min_length=1)]


class Words(BaseModel):
    """What the author's models of sound have in common."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class When(Words):
    """Which events a voice is for; all that is given must fit, `*` stands for any letters."""

    cause: Pattern | None = Field(None, description="What happened, such as footfall or scuff.")
    who: Pattern | None = Field(None, description="Name of the performer that sounds.")
    part: Pattern | None = Field(None, description="Its part, such as foot_l1 or foot_*.")
    material: Pattern | None = Field(None, description="Material of the part that sounds.")
    surface: Pattern | None = Field(None, description="Material of what it met.")


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
        description="MIDI number, note name (C4 is 60), 'by size' (small is high), or 'by foot' or "
        "'by part' (a step of the scale for each part); tunes the note and the sound.",
    )
    length: float | None = Field(
        None, gt=0, le=60, description="How long the note lasts and the sound dies away [s]."
    )
    gain_db: float = Field(0.0, ge=-60, le=24, description="Louder or softer [dB].")
    mute: bool = Field(False, description="True to silence these events in score and sound.")

    @model_validator(mode="after")
    def _drum_or_instrument(self) -> Self:
        if self.drum is not None and (self.instrument is not None or self.pitch is not None):
            raise ValueError("give either drum, or instrument and pitch: a drum has one pitch")
        return self


class Sound(Words):
    """The sound of a scene: the scale of its notes, its voices, its loudness."""

    scale: ScaleName = Field(
        "C minor pentatonic",
        description="Scale of the pitches that follow size or part: a root and a kind, such as "
        "'A dorian', or 'chromatic'. A pitch given as a note stays as it is.",
    )
    voices: tuple[Voice, ...] = Field((), description="Voices; the first that fits an event wins.")
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
