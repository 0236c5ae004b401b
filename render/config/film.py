"""Film: size, sampling, exposure and file formats of the frames."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from render.config.base import RenderConfig

Denoise = Literal["off", "fast", "high"]
SoftLight = Literal["half", "full"]
Format = Literal["png", "exr"]
Codec = Literal["h264", "prores"]
Preset = Literal["draft", "preview", "final", "master"]
Degrees = Annotated[float, Field(ge=0, le=360)]
Moments = Annotated[int, Field(ge=1, le=256)]
# H.264 in 4:2:0 keeps one chroma sample for two by two pixels.
Even = Annotated[int, Field(ge=16, le=8192, multiple_of=2)]

RAYS_PER_PATH = 4
"""Camera rays for each indirect light path: they cost half a path, and clean edges, textures and
shadows, while indirect light is smooth."""

# Films are shot with the shutter open for half of a frame.
_SHARP: dict[str, Any] = {"shutter_deg": 0.0, "moments": 4}
_BLURRED: dict[str, Any] = {"shutter_deg": 180.0, "moments": 6}
_FOR_VIEWING: dict[str, Any] = {"format": "png", "codec": "h264"}
_FOR_EDITING: dict[str, Any] = {"format": "exr", "codec": "prores"}

_PRESETS: dict[Preset, dict[str, Any]] = {
    "draft": {
        "size": (320, 180),
        "samples": 2,
        "depth": 3,
        "soft_light": "half",
        "denoise": "fast",
        **_SHARP,
        **_FOR_VIEWING,
    },
    "preview": {
        "size": (640, 360),
        "samples": 2,
        "depth": 4,
        "soft_light": "half",
        "denoise": "fast",
        **_SHARP,
        **_FOR_VIEWING,
    },
    "final": {
        "size": (1280, 720),
        "samples": 48,
        "depth": 5,
        "soft_light": "full",
        "denoise": "high",
        **_BLURRED,
        **_FOR_VIEWING,
    },
    "master": {
        "size": (1920, 1080),
        "samples": 256,
        "depth": 8,
        "soft_light": "full",
        "denoise": "high",
        **_BLURRED,
        **_FOR_EDITING,
        "moments": 16,
    },
}


class Film(RenderConfig):
    """Size and quality of the frames: a preset, and what differs from it."""

    preset: Preset = Field("preview", description="Source of the values left out.")
    size: tuple[Even, Even] | None = Field(None, description="Width and height [pixels], even.")
    samples: int | None = Field(
        None,
        ge=1,
        le=65536,
        description="Camera rays per pixel; a quarter as many continue as light paths.",
    )
    depth: int | None = Field(None, ge=1, le=64, description="Longest light path, in segments.")
    soft_light: SoftLight | None = Field(
        None,
        description="Resolution of sky light and indirect light: "
        "half takes a quarter of the time, and is soft at the edges of bare metal and glass.",
    )
    denoise: Denoise | None = Field(None, description="Denoiser of the finished frame.")
    shutter_deg: Degrees | None = Field(
        None,
        description="Shutter angle, 360 for the whole frame, which sets the motion blur.",
    )
    moments: Moments | None = Field(
        None,
        description="Moments of a blurred frame, which share its samples.",
    )
    exposure: float = Field(0.0, ge=-20, le=20, description="Exposure compensation [stops].")
    format: Format | None = Field(
        None, description="Format of the frames: png is ready to show; exr keeps all light."
    )
    codec: Codec | None = Field(
        None,
        description="Codec of the film: h264 in MP4 is ready to show; prores in MOV has ten bits "
        "and uncompressed sound, for editing.",
    )

    def resolved(self) -> FullFilm:
        """Return the film with the values of its preset written out."""
        given = {k: v for k, v in self.model_dump().items() if v is not None}
        return FullFilm.model_validate({**_PRESETS[self.preset], **given})


class FullFilm(Film):
    """A film with all values set."""

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
        """Camera rays per pixel in a pass; a pass has one path per pixel of the soft light."""
        return 1 if self.soft_light == "half" else RAYS_PER_PATH

    @property
    def passes(self) -> int:
        """Number of passes, at least one."""
        return max(round(self.samples / self.rays), 1)

    @property
    def suffix(self) -> str:
        """Suffix of the film's file."""
        return {"h264": ".mp4", "prores": ".mov"}[self.codec]

    @property
    def exposures(self) -> tuple[float, ...]:
        """Times of the moments of an exposure, as fractions of a frame from its start.

        Each moment has at least one pass.
        """
        if self.shutter_deg == 0.0:
            return (0.0,)
        count = min(self.moments, self.passes)
        return tuple(self.shutter_deg / 360.0 * (k + 0.5) / count for k in range(count))
