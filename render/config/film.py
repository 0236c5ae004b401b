"""Film: size, sampling, exposure and file formats of the frames."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, ValidationInfo, field_validator

from render.config.base import RenderConfig
from render.config.look import Look

Denoise = Literal["off", "fast", "high"]
SoftLight = Literal["half", "full"]
Format = Literal["png", "exr"]
Codec = Literal["h264", "prores", "vp9", "av1"]
Container = Literal["mp4", "mov", "webm"]
Pass = Literal["depth", "normal", "motion", "id", "alpha"]
Preset = Literal["draft", "preview", "final", "master"]
Degrees = Annotated[float, Field(ge=0, le=360)]
Moments = Annotated[int, Field(ge=1, le=256)]
# Video in 4:2:0 keeps one chroma sample for two by two pixels.
Even = Annotated[int, Field(ge=16, le=8192, multiple_of=2)]

RAYS_PER_PATH = 4
"""Camera rays for each indirect light path: they cost half a path, and clean edges, textures and
shadows, while indirect light is smooth."""

# Films are shot with the shutter open for half of a frame.
_SHARP: dict[str, Any] = {"shutter_deg": 0.0, "moments": 4}
_BLURRED: dict[str, Any] = {"shutter_deg": 180.0, "moments": 6}
_FOR_VIEWING: dict[str, Any] = {"format": "png", "codec": "h264"}
_FOR_EDITING: dict[str, Any] = {"format": "exr", "codec": "prores"}

MIN_AV1_SIDE = 32
"""Shortest side of a film in AV1 [pixels]; with shorter ones its encoder may never return."""

CONTAINERS: dict[Codec, tuple[Container, ...]] = {
    "h264": ("mp4",),
    "prores": ("mov",),
    "vp9": ("mp4", "webm"),
    "av1": ("mp4", "webm"),
}
"""Containers that hold each codec, the default first."""

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
    look: Look = Field(
        default_factory=lambda: Look.model_validate("natural"),
        description="Grading: the name of a look, or its values.",
    )
    format: Format | None = Field(
        None, description="Format of the frames: png is ready to show; exr keeps all light."
    )
    passes: tuple[Pass, ...] = Field(
        (),
        description="For compositing, further parts of EXR frames: depth, normal, motion, alpha, "
        "and by id the mattes of performers, parts and materials (Cryptomatte).",
    )
    codec: Codec | None = Field(
        None,
        description="Codec of the film: h264, vp9 and av1 are ready to show; prores has ten bits "
        "and uncompressed sound, for editing.",
    )
    container: Container | None = Field(
        None,
        description="Format of the film's file: mp4 of h264, vp9 and av1, mov of prores. Films of "
        "vp9 and av1 may also be webm, whose times are whole milliseconds.",
    )

    @field_validator("passes")
    @classmethod
    def _check_passes(cls, value: tuple[Pass, ...], info: ValidationInfo) -> tuple[Pass, ...]:
        if len(set(value)) < len(value):
            raise ValueError("a pass is named twice; name each once")
        # A wrong preset or format is not among the values, and has an error of its own.
        if not value or not {"preset", "format"} <= info.data.keys():
            return value
        if (info.data["format"] or _PRESETS[info.data["preset"]]["format"]) != "exr":
            raise ValueError("passes are parts of EXR frames; write format: exr")
        return value

    @field_validator("codec")
    @classmethod
    def _check_codec(cls, value: Codec | None, info: ValidationInfo) -> Codec | None:
        size = info.data.get("size")
        if value == "av1" and size is not None and min(size) < MIN_AV1_SIDE:
            raise ValueError(
                f"av1 needs a size of at least {MIN_AV1_SIDE}x{MIN_AV1_SIDE}, is "
                f"{size[0]}x{size[1]}; write a larger size, or codec: vp9"
            )
        return value

    @field_validator("container")
    @classmethod
    def _check_container(cls, value: Container | None, info: ValidationInfo) -> Container | None:
        # A wrong preset or codec is not among the values, and has an error of its own.
        if value is None or not {"preset", "codec"} <= info.data.keys():
            return value
        codec = info.data["codec"] or _PRESETS[info.data["preset"]]["codec"]
        if value in CONTAINERS[codec]:
            return value
        holds = " or ".join(name for name, its in CONTAINERS.items() if value in its)
        right = " or ".join(CONTAINERS[codec])
        raise ValueError(f"{value} does not hold {codec}; write {right}, or codec: {holds}")

    def resolved(self) -> FullFilm:
        """Return the film with the values of its preset written out."""
        given = {k: v for k, v in self.model_dump().items() if v is not None}
        full = {**_PRESETS[self.preset], **given}
        return FullFilm.model_validate({"container": CONTAINERS[full["codec"]][0], **full})


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
    container: Container

    @property
    def rays(self) -> int:
        """Camera rays per pixel in a pass; a pass has one path per pixel of the soft light."""
        return 1 if self.soft_light == "half" else RAYS_PER_PATH

    @property
    def rounds(self) -> int:
        """Number of times that every pixel is sampled, at least one."""
        return max(round(self.samples / self.rays), 1)

    @property
    def suffix(self) -> str:
        """Suffix of the film's file."""
        return f".{self.container}"

    @property
    def exposures(self) -> tuple[float, ...]:
        """Times of the moments of an exposure, as fractions of a frame from its start.

        Each moment has at least one pass.
        """
        if self.shutter_deg == 0.0:
            return (0.0,)
        count = min(self.moments, self.rounds)
        return tuple(self.shutter_deg / 360.0 * (k + 0.5) / count for k in range(count))
