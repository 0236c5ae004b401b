"""Codecs: how pictures and sound are packed, by the kind of film.

H.264 with AAC in MP4 is for showing. ProRes 422 HQ with plain samples in MOV is for those who
work on: ten bits, each picture by itself, sound as it was.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Sound = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class Codec:
    """How one kind of film is packed.

    Attributes:
        container: as FFmpeg calls it.
        video: encoder of the picture.
        pixels: format of the encoded pictures.
        bits: of a channel of the pictures that are given, 8 or 16.
        options: of the encoder.
        audio: encoder of the sound.
        samples: format of the sound's samples: `fltp` or `s32`.
        bit_rate: of the sound [bit/s]; None for plain samples.
    """

    container: str
    video: str
    pixels: str
    bits: int
    audio: str
    samples: str
    bit_rate: int | None = None
    options: Mapping[str, str] = field(default_factory=dict)

    @property
    def picture(self) -> str:
        """Format of the pictures that are given."""
        return "rgb24" if self.bits == 8 else "rgb48le"

    def sampled(self, sound: Sound) -> Sound | NDArray[np.int32]:
        """Return sound (channels, N) as the encoder takes it."""
        if self.samples == "fltp":
            return sound
        whole = np.clip(np.rint(sound.astype(np.float64) * 2**31), -(2**31), 2**31 - 1)
        return np.ascontiguousarray(whole.astype(np.int32).T.reshape(1, -1))


CODECS: dict[str, Codec] = {
    # 17 is hard to tell from the frames.
    ".mp4": Codec(
        container="mp4",
        video="libx264",
        pixels="yuv420p",
        bits=8,
        audio="aac",
        samples="fltp",
        bit_rate=192_000,
        options={"crf": "17", "preset": "medium"},
    ),
    ".mov": Codec(
        container="mov",
        video="prores_ks",
        pixels="yuv422p10le",
        bits=16,
        audio="pcm_s24le",
        samples="s32",
        options={"profile": "3", "vendor": "apl0"},
    ),
}
"""By the ends of their files' names."""
