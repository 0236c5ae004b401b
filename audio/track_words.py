"""The author's words for the track: the room it sounds in, its master, a SoundFont to play it."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BeforeValidator, Field

from audio.model import Words

RoomName = Literal["open", "dry", "room", "hall"]

Metres = Annotated[float, Field(gt=0, le=1000)]


class Room(Words):
    """Where one listens; what is not said is as in the preset."""

    preset: RoomName = Field(
        "open", description="open (the ground and little else), dry (nothing), room or hall."
    )
    size: tuple[Metres, Metres, Metres] | None = Field(
        None, description="Width, height and depth [m]; walls give way to what lies beyond."
    )
    absorption: float | None = Field(
        None, ge=0, le=1, description="Share of the sound's energy that walls and ground take."
    )
    seconds: float | None = Field(
        None, gt=0, le=20, description="Time in which the reverberation falls by 60 dB [s]."
    )
    wet_db: float | None = Field(
        None, ge=-80, le=12, description="Level of the reverberation at full send [dB]."
    )


class Master(Words):
    """How loud the whole track is made."""

    lufs: float = Field(
        -16.0, ge=-40, le=-6, description="Integrated loudness that is aimed at [LUFS]."
    )
    true_peak_db: float = Field(
        -1.0, ge=-20, le=-0.1, description="What no peak passes, between samples either [dB]."
    )
    most_gain_db: float = Field(
        30.0,
        ge=0,
        le=60,
        description="Most that a soft scene is raised [dB]: what is nearly silent stays soft.",
    )
    most_limiting_db: float = Field(
        18.0,
        ge=0,
        le=40,
        description="Most that the highest peak is lowered to get there [dB]: what is loud stays "
        "louder than what is soft.",
    )


def _room(words: object) -> object:
    return {"preset": words} if isinstance(words, str) else words


def _master(words: object) -> object:
    # YAML reads a bare `off` as a truth value.
    return None if words is False or words == "off" else words


RoomOrName = Annotated[Room, BeforeValidator(_room, json_schema_input_type=RoomName | Room)]
MasterOrOff = Annotated[
    Master | None,
    BeforeValidator(_master, json_schema_input_type=Literal["off", False] | Master),
]
