"""Film: how large, how clean, how bright."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from render.config.base import Words

Denoise = Literal["off", "fast", "high"]
SoftLight = Literal["half", "full"]
Format = Literal["png", "exr"]
Codec = Literal["h264", "prores"]
Preset = Literal["draft", "preview", "final", "master"]
Degrees = Annotated[float, Field(ge=0, le=360)]
Moments = Annotated[int, Field(ge=1, le=256)]
# H.264 in 4:2:0 keeps one chroma sample for two by two pixels.
Even = Annotated[int, Field(ge=16, le=8192, multiple_of=2)]

RAYS_A_PATH = 4
"""Rays through a pixel for each path that goes on from there: they cost half of one, and make
edges, textures and shadows clean, where the rest is smooth."""

# A shutter that is open for half of a frame is what films are shot with.
_STILL: dict[str, Any] = {"shutter_deg": 0.0, "moments": 4}
_BLURRED: dict[str, Any] = {"shutter_deg": 180.0, "moments": 6}
_SHOWN: dict[str, Any] = {"format": "png", "codec": "h264"}
_KEPT: dict[str, Any] = {"format": "exr", "codec": "prores"}

_PRESETS: dict[Preset, dict[str, Any]] = {
    "draft": {
        "size": (320, 180),
        "samples": 2,
        "depth": 3,
        "soft_light": "half",
        "denoise": "fast",
        **_STILL,
        **_SHOWN,
    },
    "preview": {
        "size": (640, 360),
        "samples": 2,
        "depth": 4,
        "soft_light": "half",
        "denoise": "fast",
        **_STILL,
        **_SHOWN,
    },
    "final": {
        "size": (1280, 720),
        "samples": 48,
        "depth": 5,
        "soft_light": "full",
        "denoise": "high",
        **_BLURRED,
        **_SHOWN,
    },
    "master": {
        "size": (1920, 1080),
        "samples": 256,
        "depth": 8,
        "soft_light": "full",
        "denoise": "high",
        **_BLURRED,
        **_KEPT,
        "moments": 16,
    },
}


class Film(Words):
    """Size and quality of the frames: a preset, and what differs from it."""

    preset: Preset = Field("preview", description="Where the words left out come from.")
    size: tuple[Even, Even] | None = Field(None, description="Width and height [pixels], even.")
    samples: int | None = Field(
        None,
        ge=1,
        le=65536,
        description="Rays through each pixel; a quarter as many go on from there as light paths.",
    )
    depth: int | None = Field(None, ge=1, le=64, description="Longest light path, in segments.")
    soft_light: SoftLight | None = Field(
        None,
        description="Size at which the light of the sky and from surface to surface is traced: "
        "half takes a quarter of the time, and is soft at the edges of bare metal and glass.",
    )
    denoise: Denoise | None = Field(None, description="What removes the noise that is left.")
    shutter_deg: Degrees | None = Field(
        None,
        description="How long the shutter is open, 360 for the whole frame: what moves is blurred.",
    )
    moments: Moments | None = Field(
        None,
        description="Moments of which a blurred frame is made, which share its samples.",
    )
    exposure: float = Field(0.0, ge=-20, le=20, description="Stops brighter than by itself.")
    format: Format | None = Field(
        None, description="Of the frames: png is ready to show; exr keeps all light."
    )
    codec: Codec | None = Field(
        None,
        description="Of the film: h264 in MP4 is ready to show; prores in MOV has ten bits and "
        "plain sound, for those who work on.",
    )

    def resolved(self) -> FullFilm:
        """Return the film with every word written out."""
        given = {w: v for w, v in self.model_dump().items() if v is not None}
        return FullFilm.model_validate({**_PRESETS[self.preset], **given})


class FullFilm(Film):
    """A film of which every word is set."""

    size: tuple[Even, Even]
    samples: int = Field(ge=1, le=65536)
    depth: int = Field(ge=1, le=64)
    soft_light: SoftLight
    denoise: Denoise
    shutter_deg: Degrees
    moments: Moments
    format: Format
    codec: Codec

    @property
    def rays(self) -> int:
        """Rays through each pixel in a pass, which has a path for each pixel of the soft light."""
        return 1 if self.soft_light == "half" else RAYS_A_PATH

    @property
    def passes(self) -> int:
        """How often the picture is traced, at least once."""
        return max(round(self.samples / self.rays), 1)

    @property
    def suffix(self) -> str:
        """How the film's file ends."""
        return {"h264": ".mp4", "prores": ".mov"}[self.codec]

    @property
    def exposures(self) -> tuple[float, ...]:
        """When a frame is taken, in parts of a frame from its begin: the middles of its moments.

        A moment has a pass at least.
        """
        if self.shutter_deg == 0.0:
            return (0.0,)
        count = min(self.moments, self.passes)
        return tuple(self.shutter_deg / 360.0 * (k + 0.5) / count for k in range(count))
