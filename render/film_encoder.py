"""Film: frames in order, with sound, as a film of one of the kinds in `CODECS`.

The clock of the picture is 1 / fps, so that frame f (from 1) is presented at exactly
(f - 1) / fps; sound is cut or padded to exactly N / fps seconds.
"""

from __future__ import annotations

import itertools
import math
import os
import struct
from collections.abc import Iterable
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
from av.video.reformatter import ColorPrimaries, ColorRange, Colorspace, ColorTrc
from numpy.typing import NDArray

from render.codecs import CODECS, Codec, Sound
from render.errors import EncodeError

RATE = 48_000
"""Sound in the film [samples a second]."""
_BLOCK = 1024
"""Samples in one frame of AAC."""
_THREADS = 4
"""Threads of x264, which decide its bytes: a constant, no property of the machine."""

Picture = NDArray[np.uint8] | NDArray[np.uint16]


def write_film(
    path: Path,
    frames: Iterable[Picture],
    fps: Fraction,
    sound: Path | None = None,
    sound_from: Fraction = Fraction(0),
    key: str = "",
) -> int:
    """Write frames, and sound if there is any; return the number of frames.

    Args:
        path: where the film goes, its end one of `CODECS`; it is replaced when the new one is
            whole.
        frames: pictures (H, W, 3) sRGB of one even size, with the codec's bits, in order.
        fps: frames a second.
        sound: WAV file of 48 kHz, one or two channels; cut or padded to the picture.
        sound_from: time in it at which the first frame stands [s].
        key: kept in the film's comment, for `film_key`.

    Raises:
        EncodeError: there is no frame, the frames differ in size, the sound is of
            another kind, or the encoder or the disk failed.
    """
    codec = CODECS.get(path.suffix)
    if codec is None:
        ends = " or ".join(CODECS)
        raise EncodeError(f"{path} is no place for a film; let its name end in {ends}")
    temporary = path.with_name(f".{path.stem}.{os.getpid()}.partial{path.suffix}")
    try:
        heard = None if sound is None else _heard(sound)[:, round(sound_from * RATE) :]
        count = _write(temporary, frames, fps, heard, key, codec)
        os.replace(temporary, path)
    except (OSError, ValueError, av.FFmpegError) as error:
        raise EncodeError(f"{path} could not be encoded: {error}") from error
    finally:
        temporary.unlink(missing_ok=True)
    return count


def film_key(path: Path) -> str | None:
    """Return the key that a film was written with; None if it has none or is not whole."""
    try:
        if not _whole(path):
            return None
        with av.open(str(path)) as container:
            return container.metadata.get("comment")
    except (OSError, ValueError, av.FFmpegError):
        return None


def _whole(path: Path) -> bool:
    """Say whether the boxes of an MP4 file add up to its length.

    Its index stands at its begin, so that a torn film would otherwise pass for a whole one.
    """
    length, at = path.stat().st_size, 0
    with path.open("rb") as file:
        while at + 8 <= length:
            file.seek(at)
            (size,) = struct.unpack(">I", file.read(4))
            if size == 1:  # the length is too large for four bytes and follows the name
                (size,) = struct.unpack(">4xQ", file.read(12))
            if size < 8:
                return False
            at += size
    return at == length


def _write(
    path: Path,
    frames: Iterable[Picture],
    fps: Fraction,
    heard: Sound | None,
    key: str,
    codec: Codec,
) -> int:
    options = {
        "movflags": "+faststart",
        "fflags": "+bitexact",
        "use_editlist": "1",
        # Lengths are kept in this unit, which is to hold both N / fps and whole samples.
        "movie_timescale": str(math.lcm(RATE, fps.numerator)),
    }
    pictures = iter(frames)
    first = next(pictures, None)
    if first is None:
        raise EncodeError("there is no frame to make a film of; render some first")
    with av.open(str(path), "w", format=codec.container, options=options) as container:
        container.metadata["comment"] = key
        # Both streams are declared before the first packet writes the header.
        video = _video(container, first.shape, fps, codec)
        track = None if heard is None else _Track(container, heard, codec)
        count = 0
        for picture in itertools.chain([first], pictures):
            if picture.shape != first.shape:
                raise EncodeError(
                    f"frame {count + 1} is {picture.shape[1]}x{picture.shape[0]} and the first "
                    f"{first.shape[1]}x{first.shape[0]}; render all frames at one size"
                )
            container.mux(video.encode(_shown(picture, count, fps, codec)))
            count += 1
            if track is not None:
                track.play_until(count / fps)
        container.mux(video.encode(None))
        if track is not None:
            track.end_at(count / fps)
        return count


def _video(container: Any, shape: tuple[int, ...], fps: Fraction, codec: Codec) -> Any:
    video = container.add_stream(codec.video, rate=fps)
    video.height, video.width = shape[:2]
    video.pix_fmt = codec.pixels
    context = video.codec_context
    context.time_base = 1 / fps
    context.thread_count = _THREADS
    # Without B-frames the order of decoding is that of showing, and no edit list shifts time.
    context.max_b_frames = 0
    context.gop_size = max(1, round(fps))
    context.options = dict(codec.options)
    context.colorspace = Colorspace.ITU709
    context.color_primaries = ColorPrimaries.BT709
    context.color_trc = ColorTrc.BT709
    context.color_range = ColorRange.MPEG
    return video


def _shown(picture: Picture, count: int, fps: Fraction, codec: Codec) -> av.VideoFrame:
    """Return a picture in YUV by the matrix of BT.709, limited range, at its time."""
    whole: Any = np.ascontiguousarray(picture)
    rgb = av.VideoFrame.from_ndarray(whole, format=codec.picture)
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


class _Track:
    """The sound of a film, fed as the picture goes on."""

    def __init__(self, container: Any, heard: Sound, codec: Codec) -> None:
        self._container, self._codec = container, codec
        self._heard = heard
        self._layout = "mono" if len(heard) == 1 else "stereo"
        self._stream = container.add_stream(codec.audio, rate=RATE, layout=self._layout)
        if codec.bit_rate is not None:
            self._stream.bit_rate = codec.bit_rate
        self._at = 0

    def play_until(self, seconds: Fraction) -> None:
        """Encode the whole blocks that end before a time."""
        while (self._at + _BLOCK) <= seconds * RATE:
            self._feed(_BLOCK)

    def end_at(self, seconds: Fraction) -> None:
        """Encode what is left up to a time, and no more."""
        self.play_until(seconds)
        rest = round(seconds * RATE) - self._at
        if rest > 0:
            self._feed(rest)
        self._container.mux(self._stream.encode(None))

    def _feed(self, count: int) -> None:
        block = np.zeros((len(self._heard), count), np.float32)
        piece = self._heard[:, self._at : self._at + count]
        block[:, : piece.shape[1]] = piece
        samples = self._codec.sampled(block)
        frame = av.AudioFrame.from_ndarray(samples, format=self._codec.samples, layout=self._layout)
        # With pts alone the sound comes a block too late: the time base is needed too.
        frame.sample_rate, frame.pts, frame.time_base = RATE, self._at, Fraction(1, RATE)
        self._container.mux(self._stream.encode(frame))
        self._at += count


def _heard(path: Path) -> Sound:
    """Return the sound of a WAV file, (channels, samples), -1 to 1."""
    with av.open(str(path)) as container:
        if not container.streams.audio:
            raise EncodeError(f"{path} has no sound")
        stream = container.streams.audio[0]
        channels = stream.codec_context.layout.nb_channels
        if stream.rate != RATE or channels > 2:
            raise EncodeError(
                f"{path} has {stream.rate} Hz and {channels} channels; "
                f"write it with {RATE} Hz and one or two"
            )
        to_float = av.AudioResampler(format="fltp", layout=stream.codec_context.layout, rate=RATE)
        blocks = [
            piece.to_ndarray()
            for frame in container.decode(stream)
            for piece in to_float.resample(frame)
        ]
        return np.concatenate(blocks, axis=1) if blocks else np.zeros((channels, 0), np.float32)
