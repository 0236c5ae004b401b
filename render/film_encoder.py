"""Film encoder: frames in order, with sound, as a film in one of `CODECS`.

The time base of the video is 1 / fps, so that frame f (from 1) is presented at exactly
(f - 1) / fps, in WebM at the nearest millisecond; sound is cut or padded to exactly N / fps
seconds.
"""

from __future__ import annotations

import contextlib
import itertools
import os
from collections.abc import Iterable
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
from av.video.reformatter import ColorPrimaries, ColorRange, Colorspace, ColorTrc
from numpy.typing import NDArray

from pipeline.atomic_file import replaced_when_complete
from render.errors import EncodeError
from render.film_codecs import CONTAINERS, RATE, Codec, Container, Sound, SoundCodec, find_codec
from render.thread_priority import kept_priority

_THREADS = 4
"""A constant, because the bytes of H.264 and VP9 depend on it."""

# The encoder of AV1 describes itself on standard error; at level 1 it tells errors alone.
os.environ.setdefault("SVT_LOG", "1")

Picture = NDArray[np.uint8] | NDArray[np.uint16]


def write_film(
    path: Path,
    frames: Iterable[Picture],
    fps: Fraction,
    sound: Path | None = None,
    sound_from: Fraction = Fraction(0),
    key: str = "",
    codec: str = "h264",
) -> int:
    """Write frames with sound, if any, and return the number of frames.

    Args:
        path: of the film, with a suffix of `CONTAINERS`; replaced when the new film is complete.
        frames: images (H, W, 3) sRGB of one even size, with the codec's bits, in order.
        fps: frames per second.
        sound: WAV file of 48 kHz, one or two channels; cut or padded to the video.
        sound_from: time in it of the first frame [s].
        key: stored in the film's comment, for `film_key`.
        codec: name in `CODECS`.

    Raises:
        EncodeError: there is no frame, the frames differ in size, the sound has another
            format, the encoder is missing, or the encoder or the disk failed.
    """
    container = CONTAINERS.get(path.suffix)
    if container is None:
        suffixes = " or ".join(CONTAINERS)
        raise EncodeError(f"{path} is no film file; write a name that ends in {suffixes}")
    encoders = find_codec(codec)
    try:
        samples = None if sound is None else _read_wav(sound)[:, round(sound_from * RATE) :]
        with replaced_when_complete(path) as temporary:
            return _write(temporary, frames, fps, samples, key, encoders, container)
    except (OSError, ValueError, av.FFmpegError) as error:
        reason: object = error
        if isinstance(error, OSError) and error.filename == str(path):
            reason = error.strerror
        raise EncodeError(f"{path} could not be encoded: {reason}") from error


def _write(
    path: Path,
    frames: Iterable[Picture],
    fps: Fraction,
    sound: Sound | None,
    key: str,
    codec: Codec,
    form: Container,
) -> int:
    options = {"fflags": "+bitexact", **form.options(fps)}
    pictures = iter(frames)
    first = next(pictures, None)
    if first is None:
        raise EncodeError("there is no frame; render some first")
    with av.open(str(path), "w", format=form.name, options=options) as container:
        container.metadata["comment"] = key
        # The first packet writes the header, so both streams are declared before.
        video = _video_stream(container, first.shape, fps, codec)
        track = None if sound is None else _SoundTrack(container, sound, codec.sound)
        count = 0
        for picture in itertools.chain([first], pictures):
            if picture.shape != first.shape:
                raise EncodeError(
                    f"frame {count + 1} is {picture.shape[1]}x{picture.shape[0]} and the first "
                    f"{first.shape[1]}x{first.shape[0]}; render all frames at one size"
                )
            # The first frame opens the encoder.
            with kept_priority() if count == 0 else contextlib.nullcontext():
                packets = video.encode(video_frame(picture, count, fps, codec))
            container.mux(packets)
            count += 1
            if track is not None:
                track.encode_until(count / fps)
        container.mux(video.encode(None))
        if track is not None:
            track.finish_at(count / fps)
        return count


def _video_stream(container: Any, shape: tuple[int, ...], fps: Fraction, codec: Codec) -> Any:
    video = container.add_stream(codec.encoder, rate=fps)
    video.height, video.width = shape[:2]
    video.pix_fmt = codec.pixels
    context = video.codec_context
    context.time_base = 1 / fps
    context.thread_count = _THREADS
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

    def __init__(self, container: Any, sound: Sound, codec: SoundCodec) -> None:
        self._container, self._codec = container, codec
        self._sound = sound
        self._layout = "mono" if len(sound) == 1 else "stereo"
        self._stream = container.add_stream(codec.encoder, rate=RATE, layout=self._layout)
        if codec.bit_rate is not None:
            self._stream.bit_rate = codec.bit_rate
        self._at = 0

    def encode_until(self, seconds: Fraction) -> None:
        """Encode the complete blocks that end before a time."""
        while (self._at + self._codec.block) <= seconds * RATE:
            self._encode(self._codec.block)

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
