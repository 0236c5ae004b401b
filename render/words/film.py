"""Film: how large, how clean, how bright."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from render.words.base import Words

Denoise = Literal["off", "fast", "high"]
Format = Literal["png", "exr"]
Preset = Literal["draft", "preview", "final"]
# H.264 in 4:2:0 keeps one chroma sample for two by two pixels.
Even = Annotated[int, Field(ge=16, le=8192, multiple_of=2)]

_PRESETS: dict[Preset, dict[str, Any]] = {
    "draft": {"size": (320, 180), "samples": 2, "depth": 3, "denoise": "fast"},
    "preview": {"size": (640, 360), "samples": 4, "depth": 4, "denoise": "fast"},
    "final": {"size": (1280, 720), "samples": 12, "depth": 5, "denoise": "high"},
}


class Film(Words):
    """Size and quality of the frames: a preset, and what differs from it."""

    preset: Preset = Field("preview", description="Where the words left out come from.")
    size: tuple[Even, Even] | None = Field(None, description="Width and height [pixels], even.")
    samples: int | None = Field(None, ge=1, le=65536, description="Light paths a pixel.")
    depth: int | None = Field(None, ge=1, le=64, description="Longest light path, in segments.")
    denoise: Denoise | None = Field(None, description="What removes the noise that is left.")
    exposure: float = Field(0.0, ge=-20, le=20, description="Stops brighter than by itself.")
    format: Format = Field("png", description="png is ready to show; exr keeps all light.")

    def resolved(self) -> FullFilm:
        """Return the film with every word written out."""
        given = {w: v for w, v in self.model_dump().items() if v is not None}
        return FullFilm.model_validate({**_PRESETS[self.preset], **given})


class FullFilm(Film):
    """A film of which every word is set."""

    size: tuple[Even, Even]
    samples: int = Field(ge=1, le=65536)
    depth: int = Field(ge=1, le=64)
    denoise: Denoise
