"""Film encoder: frames in order, with sound, as a film in one of `CODECS`.

H.264 with AAC in MP4 is for viewing. ProRes 422 HQ with PCM in MOV is for editing: ten bits, no
prediction between frames, uncompressed sound.

The time base of the video is 1 / fps, so that frame f (from 1) is presented at exactly
(f - 1) / fps; sound is cut or padded to exactly N / fps seconds.
"""

from __future__ import annotations

import itertools
import math
import struct
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
from av.video.reformatter import ColorPrimaries, ColorRange, Colorspace, ColorTrc
from numpy.typing import NDArray

from pipeline.atomic_file import replaced_when_complete
from render.errors import EncodeError

RATE = 48_000
"""Sample rate of the film's sound [Hz]."""
_AAC_FRAME = 1024
"""Samples in one frame of AAC."""
_X264_THREADS = 4
"""A constant, because the bytes of x264 depend on it."""

Picture = NDArray[np.uint8] | NDArray[np.uint16]
Sound = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class Codec:
    """Encoders and formats of one kind of film.

    Attributes:
        container: FFmpeg's name of the container.
        video: FFmpeg's name of the video encoder.
        pixels: pixel format of the video.
        bits: per channel of the input frames, 8 or 16.
        audio: FFmpeg's name of the audio encoder.
        samples: sample format of the audio: `fltp` or `s32`.
        bit_rate: of the audio [bit/s]; None for PCM.
        options: of the video encoder.
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
    def input_pixels(self) -> str:
        """Pixel format of the input frames."""
        return "rgb24" if self.bits == 8 else "rgb48le"

    def quantized(self, sound: Sound) -> Sound | NDArray[np.int32]:
        """Return sound (channels, N) in the sample format of the encoder."""
        if self.samples == "fltp":
            return sound
        whole = np.clip(np.rint(sound.astype(np.float64) * 2**31), -(2**31), 2**31 - 1)
        return np.ascontiguousarray(whole.astype(np.int32).T.reshape(1, -1))


CODECS: dict[str, Codec] = {
    # Constant rate factor 17 is visually lossless.
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
"""Codecs by the suffix of the film's file."""


def write_film(
    path: Path,
    frames: Iterable[Picture],
    fps: Fraction,
    sound: Path | None = None,
    sound_from: Fraction = Fraction(0),
    key: str = "",
) -> int:
    """Write frames with sound, if any, and return the number of frames.

    Args:
        path: of the film, with a suffix of `CODECS`; replaced when the new film is complete.
        frames: images (H, W, 3) sRGB of one even size, with the codec's bits, in order.
        fps: frames per second.
        sound: WAV file of 48 kHz, one or two channels; cut or padded to the video.
        sound_from: time in it of the first frame [s].
        key: stored in the film's comment, for `film_key`.

    Raises:
        EncodeError: there is no frame, the frames differ in size, the sound has another
            format, or the encoder or the disk failed.
    """
    codec = CODECS.get(path.suffix)
    if codec is None:
        suffixes = " or ".join(CODECS)
        raise EncodeError(f"{path} is no film file; write a name that ends in {suffixes}")
    try:
        samples = None if sound is None else _read_wav(sound)[:, round(sound_from * RATE) :]
        with replaced_when_complete(path) as temporary:
            return _write(temporary, frames, fps, samples, key, codec)
    except (OSError, ValueError, av.FFmpegError) as error:
        reason: object = error
        if isinstance(error, OSError) and error.filename == str(path):
            reason = error.strerror
        raise EncodeError(f"{path} could not be encoded: {reason}") from error


def film_key(path: Path) -> str | None:
    """Return the key that a film was written with; None if it has none or is torn."""
    try:
        if not _is_complete(path):
            return None
        with av.open(str(path)) as container:
            return container.metadata.get("comment")
    except (OSError, ValueError, av.FFmpegError):
        return None


def _is_complete(path: Path) -> bool:
    """Return whether the boxes of an MP4 file add up to its length.

    Its index stands at its start, so that FFmpeg opens a torn film as well.
    """
    length, at = path.stat().st_size, 0
    with path.open("rb") as file:
        while at + 8 <= length:
            file.seek(at)
            (size,) = struct.unpack(">I", file.read(4))
            if size == 1:  # a 64-bit size follows the name
                (size,) = struct.unpack(">4xQ", file.read(12))
            if size < 8:
                return False
            at += size
    return at == length


def _write(
    path: Path,
    frames: Iterable[Picture],
    fps: Fraction,
    sound: Sound | None,
    key: str,
    codec: Codec,
) -> int:
    options = {
        "movflags": "+faststart",
        "fflags": "+bitexact",
        "use_editlist": "1",
        # The unit of lengths, which must resolve both N / fps and whole samples.
        "movie_timescale": str(math.lcm(RATE, fps.numerator)),
    }
    pictures = iter(frames)
    first = next(pictures, None)
    if first is None:
        raise EncodeError("there is no frame; render some first")
    with av.open(str(path), "w", format=codec.container, options=options) as container:
        container.metadata["comment"] = key
        # The first packet writes the header, so both streams are declared before.
        video = _video_stream(container, first.shape, fps, codec)
        track = None if sound is None else _SoundTrack(container, sound, codec)
        count = 0
        for picture in itertools.chain([first], pictures):
            if picture.shape != first.shape:
                raise EncodeError(
                    f"frame {count + 1} is {picture.shape[1]}x{picture.shape[0]} and the first "
                    f"{first.shape[1]}x{first.shape[0]}; render all frames at one size"
                )
            container.mux(video.encode(video_frame(picture, count, fps, codec)))
            count += 1
            if track is not None:
                track.encode_until(count / fps)
        container.mux(video.encode(None))
        if track is not None:
            track.finish_at(count / fps)
        return count


def _video_stream(container: Any, shape: tuple[int, ...], fps: Fraction, codec: Codec) -> Any:
    video = container.add_stream(codec.video, rate=fps)
    video.height, video.width = shape[:2]
    video.pix_fmt = codec.pixels
    context = video.codec_context
    context.time_base = 1 / fps
    context.thread_count = _X264_THREADS
    # Without B-frames decoding order is presentation order, and no edit list shifts time.
    context.max_b_frames = 0
    context.gop_size = max(1, round(fps))
    context.options = dict(codec.options)
    context.colorspace = Colorspace.ITU709
    context.color_primaries = ColorPrimaries.BT709
    context.color_trc = ColorTrc.BT709
    context.color_range = ColorRange.MPEG
    return video


def video_frame(picture: Picture, count: int, fps: Fraction, codec: Codec) -> av.VideoFrame:
    """Return an image in limited-range BT.709 YUV, with its presentation time."""
    array: Any = np.ascontiguousarray(picture)
    rgb = av.VideoFrame.from_ndarray(array, format=codec.input_pixels)
    frame = rgb.reformat(
        format=codec.pixels,
        src_colorspace=Colorspace.ITU709,
        dst_colorspace=Colorspace.ITU709,
        src_color_range=ColorRange.JPEG,
        dst_color_range=ColorRange.MPEG,
        interpolation="AREA",
    )
    frame.colorspace = Colorspace.ITU709
    frame.color_primaries = ColorPrimaries.BT709
    frame.color_trc = ColorTrc.BT709
    frame.color_range = ColorRange.MPEG
    frame.pts, frame.time_base, frame.duration = count, 1 / fps, 1
    return frame


class _SoundTrack:
    """The sound of a film, encoded along with the video."""

    def __init__(self, container: Any, sound: Sound, codec: Codec) -> None:
        self._container, self._codec = container, codec
        self._sound = sound
        self._layout = "mono" if len(sound) == 1 else "stereo"
        self._stream = container.add_stream(codec.audio, rate=RATE, layout=self._layout)
        if codec.bit_rate is not None:
            self._stream.bit_rate = codec.bit_rate
        self._at = 0

    def encode_until(self, seconds: Fraction) -> None:
        """Encode the complete blocks that end before a time."""
        while (self._at + _AAC_FRAME) <= seconds * RATE:
            self._encode(_AAC_FRAME)

    def finish_at(self, seconds: Fraction) -> None:
        """Encode the rest up to a time."""
        self.encode_until(seconds)
        rest = round(seconds * RATE) - self._at
        if rest > 0:
            self._encode(rest)
        self._container.mux(self._stream.encode(None))

    def _encode(self, count: int) -> None:
        block = np.zeros((len(self._sound), count), np.float32)
        piece = self._sound[:, self._at : self._at + count]
        block[:, : piece.shape[1]] = piece
        samples = self._codec.quantized(block)
        frame = av.AudioFrame.from_ndarray(samples, format=self._codec.samples, layout=self._layout)
        # With pts alone the sound is a block late: the time base is needed, too.
        frame.sample_rate, frame.pts, frame.time_base = RATE, self._at, Fraction(1, RATE)
        self._container.mux(self._stream.encode(frame))
        self._at += count


def _read_wav(path: Path) -> Sound:
    """Return the samples of a WAV file, (channels, N), -1 to 1."""
    with av.open(str(path)) as container:
        if not container.streams.audio:
            raise EncodeError(f"{path} has no sound")
        stream = container.streams.audio[0]
        channels = stream.codec_context.layout.nb_channels
        if stream.rate != RATE or channels > 2:
            raise EncodeError(
                f"{path} has {stream.rate} Hz and {channels} channels; "
                f"write one or two channels at {RATE} Hz"
            )
        to_float = av.AudioResampler(format="fltp", layout=stream.codec_context.layout, rate=RATE)
        blocks = [
            piece.to_ndarray()
            for frame in container.decode(stream)
            for piece in to_float.resample(frame)
        ]
        return np.concatenate(blocks, axis=1) if blocks else np.zeros((channels, 0), np.float32)
