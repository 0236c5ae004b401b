"""Film segments: runs of a film's pictures, each encoded by an encoder of its own.

A film is a row of segments, whether one process encodes all or several machines encode one each,
so that its bytes are the same. The file of a segment is a video without sound.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
from av.video.reformatter import ColorPrimaries, ColorRange, Colorspace, ColorTrc
from numpy.typing import NDArray

from render.config.film import CONTAINERS as CONTAINERS_OF
from render.errors import EncodeError
from render.film_codecs import CONTAINERS, Codec, find_codec
from render.thread_priority import kept_priority

SEGMENT_SECONDS = 10
"""Length of all segments of a film but the last [s].

A constant, because the bytes of films depend on it. Short segments are more tasks for a farm, long
ones leave its machines without work. Measured on 10 s of 480x270: in segments of 5 s the film is
as large as in one, within 0.5 %, and of 2 s within 2 %.
"""

_THREADS = 4
"""A constant, because the bytes of H.264 and VP9 depend on it."""

# The encoder of AV1 describes itself on standard error; at level 1 it tells errors alone.
os.environ.setdefault("SVT_LOG", "1")

Picture = NDArray[np.uint8] | NDArray[np.uint16]


@dataclass(frozen=True, slots=True)
class SegmentForm:
    """What all segments of a film have in common.

    Attributes:
        codec: FFmpeg's name of it.
        size: width and height [pixels].
        pixels: pixel format.
        extradata: of the codec, such as the parameter sets of H.264.
    """

    codec: str
    size: tuple[int, int]
    pixels: str | None
    extradata: bytes | None


def segment_length(fps: Fraction) -> int:
    """Return the number of frames in all segments of a film but the last."""
    return round(SEGMENT_SECONDS * _key_distance(fps))


def _key_distance(fps: Fraction) -> int:
    """Return the greatest distance of key frames, about a second [frames]."""
    return max(1, round(fps))


def segment_suffix(codec: str) -> str:
    """Return the suffix of a segment's file: of the codec's container with exact times."""
    exact = (f".{name}" for its, names in CONTAINERS_OF.items() if its == codec for name in names)
    return next(suffix for suffix in exact if not CONTAINERS[suffix].tick)


def write_segment(
    path: Path, pictures: Iterable[Picture], fps: Fraction, codec: str, first: int = 1
) -> None:
    """Encode pictures as a segment.

    Args:
        path: of the segment, with the suffix of `segment_suffix`.
        pictures: images (H, W, 3) sRGB of one even size, with the codec's bits, in order.
        fps: frames per second.
        codec: name in `CODECS`.
        first: number of the first picture in the film, for messages.

    Raises:
        EncodeError: there is no picture, they differ in size, or the encoder is missing.
        OSError: the encoder or the disk failed.
        ValueError: the encoder does not take the pictures.
    """
    encoders, form = find_codec(codec), CONTAINERS[path.suffix]
    video, shape = None, (0, 0, 3)
    with av.open(str(path), "w", format=form.name, options={"fflags": "+bitexact"}) as container:
        for count, picture in enumerate(pictures):
            if video is None:
                shape = picture.shape
                video = video_stream(container, (shape[1], shape[0]), fps, encoders)
            elif picture.shape != shape:
                raise EncodeError(
                    f"frame {first + count} is {picture.shape[1]}x{picture.shape[0]} and frame "
                    f"{first} {shape[1]}x{shape[0]}; render all frames at one size"
                )
            # The first frame opens the encoder.
            with kept_priority() if count == 0 else contextlib.nullcontext():
                packets = video.encode(video_frame(picture, count, fps, encoders))
            container.mux(packets)
        if video is None:
            raise EncodeError("there is no frame; render some first")
        container.mux(video.encode(None))


@contextlib.contextmanager
def opened_segment(
    path: Path, fps: Fraction
) -> Iterator[tuple[SegmentForm, Iterator[av.Packet[Any]]]]:
    """Yield the form of a segment and its packets, one for each picture, in order.

    Raises:
        EncodeError: it is no video, or of another rate.
        OSError: it cannot be read.
    """
    # Packets stay as they were written.
    with av.open(str(path), options={"fflags": "+noparse"}) as container:
        video = next(iter(container.streams.video), None)
        if video is None or video.codec_context is None:
            raise EncodeError(f"{path.name} is no segment of a film: it has no video; encode it")
        context = video.codec_context
        name, size = context.codec.canonical_name, (context.width, context.height)
        form = SegmentForm(name, size, context.pix_fmt, context.extradata)
        yield form, _packets(container, video, fps)


def _packets(container: Any, video: Any, fps: Fraction) -> Iterator[av.Packet[Any]]:
    count = 0
    for packet in container.demux(video):
        if packet.size:
            if Fraction(packet.pts or 0) * packet.time_base != count / fps:
                raise EncodeError(f"a segment is not of {fps} frames a second; encode it again")
            count += 1
            yield packet


def video_stream(container: Any, size: tuple[int, int], fps: Fraction, codec: Codec) -> Any:
    """Return a new stream of a container, with its encoder.

    Args:
        container: that is written.
        size: width and height [pixels].
        fps: frames per second.
        codec: of the video.
    """
    video = container.add_stream(codec.encoder, rate=fps)
    video.width, video.height = size
    video.pix_fmt = codec.pixels
    context = video.codec_context
    context.time_base = 1 / fps
    context.thread_count = _THREADS
    # Without B-frames decoding order is presentation order, and no edit list shifts time.
    context.max_b_frames = 0
    context.gop_size = _key_distance(fps)
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
