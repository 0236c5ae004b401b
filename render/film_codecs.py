"""Film codecs: encoders of each value of `film.codec`, and the containers of films.

H.264 with AAC is for viewing. VP9 and AV1 with Opus are, too, by encoders under permissive
licences. ProRes 422 HQ with PCM is for editing: ten bits, no prediction between frames,
uncompressed sound.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction

import av
import numpy as np
from numpy.typing import NDArray

from render.errors import EncodeError

RATE = 48_000
"""Sample rate of the film's sound [Hz]."""

Sound = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class SoundCodec:
    """Encoder and formats of a film's sound.

    Attributes:
        encoder: FFmpeg's name of the encoder.
        samples: sample format: `fltp`, `flt` or `s32`.
        block: samples that the encoder takes at a time.
        bit_rate: [bit/s]; None for PCM.
    """

    encoder: str
    samples: str
    block: int
    bit_rate: int | None = None

    def quantized(self, sound: Sound) -> Sound | NDArray[np.int32]:
        """Return sound (channels, N) in the sample format of the encoder."""
        if self.samples == "fltp":
            return sound
        interleaved = np.ascontiguousarray(sound.T.reshape(1, -1))
        if self.samples == "flt":
            return interleaved
        whole = np.rint(interleaved.astype(np.float64) * 2**31)
        return np.clip(whole, -(2**31), 2**31 - 1).astype(np.int32)


@dataclass(frozen=True, slots=True)
class Codec:
    """Encoders and formats of one kind of film.

    Attributes:
        encoder: FFmpeg's name of the video encoder.
        pixels: pixel format of the video.
        bits: per channel of the input frames, 8 or 16.
        options: of the video encoder.
        sound: codec of the sound.
    """

    encoder: str
    pixels: str
    bits: int
    sound: SoundCodec
    options: Mapping[str, str] = field(default_factory=dict)

    @property
    def input_pixels(self) -> str:
        """Pixel format of the input frames."""
        return "rgb24" if self.bits == 8 else "rgb48le"

    @property
    def missing_encoders(self) -> tuple[str, ...]:
        """FFmpeg's names of the encoders that the installed PyAV lacks."""
        return tuple(name for name in (self.encoder, self.sound.encoder) if not _is_there(name))


def _is_there(encoder: str) -> bool:
    try:
        av.Codec(encoder, "w")
    except ValueError:  # the root of PyAV's error for an unknown codec
        return False
    return True


_AAC = SoundCodec("aac", "fltp", 1024, 192_000)
_OPUS = SoundCodec("libopus", "flt", 960, 160_000)
_PCM = SoundCodec("pcm_s24le", "s32", 1024)

CODECS: dict[str, Codec] = {
    # Constant rate factor 17 is visually lossless; those of VP9 and AV1 come as near to the frames.
    # The tree of macroblocks of x264 reads memory that nobody wrote, so that one film in some
    # thousands came out otherwise; without it films are 2 % larger, at equal quality.
    "h264": Codec(
        "libx264",
        "yuv420p",
        8,
        _AAC,
        {"crf": "17", "preset": "medium", "x264-params": "mbtree=0"},
    ),
    "prores": Codec("prores_ks", "yuv422p10le", 16, _PCM, {"profile": "3", "vendor": "apl0"}),
    # A bit rate of 0 leaves the quality to the rate factor.
    "vp9": Codec(
        "libvpx-vp9",
        "yuv420p",
        8,
        _OPUS,
        {"crf": "18", "b": "0", "deadline": "good", "cpu-used": "3", "row-mt": "1"},
    ),
    "av1": Codec("libsvtav1", "yuv420p", 8, _OPUS, {"crf": "16", "preset": "7"}),
}
"""Codecs by their names in the scene language."""


def find_codec(name: str) -> Codec:
    """Return the codec of a name in `CODECS`, which the installed PyAV can encode.

    Raises:
        EncodeError: PyAV lacks an encoder of it.
    """
    codec = CODECS[name]
    if not codec.missing_encoders:
        return codec
    others = [other for other, its in CODECS.items() if not its.missing_encoders]
    encoders = " and ".join(codec.missing_encoders)
    advice = f"write {' or '.join(others)}" if others else "install a PyAV with encoders"
    raise EncodeError(
        f"the installed PyAV {av.__version__} cannot encode {name}: it lacks {encoders}; {advice}"
    )


@dataclass(frozen=True, slots=True)
class Container:
    """A file format of films.

    Attributes:
        name: FFmpeg's name of the format.
        options: of the format for a film of so many frames a second.
        tick: unit of the times in it [s]; 0 where they are exact.
    """

    name: str
    options: Callable[[Fraction], Mapping[str, str]]
    tick: Fraction = Fraction(0)


def _quicktime_options(fps: Fraction) -> Mapping[str, str]:
    return {
        "movflags": "+faststart",
        "use_editlist": "1",
        # The unit of lengths, which must resolve both N / fps and whole samples.
        "movie_timescale": str(math.lcm(RATE, fps.numerator)),
    }


def _webm_options(_: Fraction) -> Mapping[str, str]:
    return {"cues_to_front": "1"}


CONTAINERS: dict[str, Container] = {
    ".mp4": Container("mp4", _quicktime_options),
    ".mov": Container("mov", _quicktime_options),
    ".webm": Container("webm", _webm_options, Fraction(1, 1000)),
}
"""Containers by the suffix of the film's file."""
