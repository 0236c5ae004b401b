"""Film encoder: frames in order, with sound, as a film in one of `CODECS`.

A film is encoded in segments, which are joined without being encoded again. The time base of the
video is 1 / fps, so that frame f (from 1) is presented at exactly (f - 1) / fps, in WebM at the
nearest millisecond; sound is cut or padded to exactly N / fps seconds.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from fractions import Fraction
from itertools import chain, islice
from pathlib import Path
from typing import Any

import av

from pipeline.atomic_file import replaced_when_complete
from render.errors import EncodeError
from render.film_codecs import CODECS, CONTAINERS, RATE, Codec, Container, Sound, find_codec
from render.film_segments import (
    Picture,
    SegmentForm,
    opened_segment,
    segment_length,
    segment_suffix,
    video_stream,
    write_segment,
)
from render.film_sound import SoundTrack, read_wav
from render.thread_priority import kept_priority

Segment = Path | Iterable[Picture]
"""A segment of a film: its file, or pictures that are to be encoded."""


def write_film(
    path: Path,
    frames: Iterable[Picture],
    fps: Fraction,
    sound: Path | None = None,
    sound_from: Fraction = Fraction(0),
    key: str = "",
    codec: str = "h264",
    length: int | None = None,
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
        length: of a segment [frames]; `segment_length` by default.

    Raises:
        EncodeError: there is no frame, the frames differ in size, the sound has another
            format, the encoder is missing, or the encoder or the disk failed.
    """
    segments = _split(iter(frames), length or segment_length(fps))
    return join_film(path, segments, fps, sound, sound_from, key, codec)


def _split(frames: Iterator[Picture], length: int) -> Iterator[Iterable[Picture]]:
    """Yield runs of frames, each of which is read before the next."""
    for frame in frames:
        yield chain([frame], islice(frames, length - 1))


def join_film(
    path: Path,
    segments: Iterable[Segment],
    fps: Fraction,
    sound: Path | None = None,
    sound_from: Fraction = Fraction(0),
    key: str = "",
    codec: str = "h264",
) -> int:
    """Write a film of segments; see `write_film`.

    Args:
        path: of the film.
        segments: in order; all but the last have `segment_length` frames. Each is done with
            before the next is taken.
        fps: frames per second.
        sound: WAV file.
        sound_from: time in it of the first frame [s].
        key: stored in the film's comment.
        codec: of the segments.

    Raises:
        EncodeError: as `write_film`; the segments differ in size or extradata, or one is damaged.
    """
    container = CONTAINERS.get(path.suffix)
    if container is None:
        suffixes = " or ".join(CONTAINERS)
        raise EncodeError(f"{path} is no film file; write a name that ends in {suffixes}")
    find_codec(codec)
    try:
        samples = None if sound is None else read_wav(sound)[:, round(sound_from * RATE) :]
        with replaced_when_complete(path) as temporary:
            return _write(temporary, segments, fps, samples, key, codec, container)
    except (OSError, ValueError, av.FFmpegError) as error:
        reason: object = error
        if isinstance(error, OSError) and error.filename == str(path):
            reason = error.strerror
        raise EncodeError(f"{path} could not be encoded: {reason}") from error


def _write(
    path: Path,
    segments: Iterable[Segment],
    fps: Fraction,
    sound: Sound | None,
    key: str,
    codec: str,
    form: Container,
) -> int:
    options = {"fflags": "+bitexact", **form.options(fps)}
    with av.open(str(path), "w", format=form.name, options=options) as container:
        container.metadata["comment"] = key
        joined: _Joined | None = None
        for segment in segments:
            first = 1 if joined is None else joined.count + 1
            with (
                _segment_file(segment, path, fps, codec, first) as file,
                opened_segment(file, fps) as (kind, packets),
            ):
                if joined is None:
                    joined = _Joined(container, kind, fps, sound, CODECS[codec])
                joined.add(kind, packets)
        if joined is None:
            raise EncodeError("there is no frame; render some first")
        return joined.finish()


@contextmanager
def _segment_file(
    segment: Segment, film: Path, fps: Fraction, codec: str, first: int
) -> Iterator[Path]:
    """Yield the file of a segment; that of pictures is beside the film until the end.

    Args:
        segment: its file or its pictures.
        film: that is written.
        fps: frames per second.
        codec: of the segment.
        first: number of its first frame.

    Raises:
        EncodeError: it cannot be encoded.
        OSError: the encoder or the disk failed; names the film.
    """
    if isinstance(segment, Path):
        yield segment
        return
    path = film.with_name(f"{film.stem}.segment{segment_suffix(codec)}")
    try:
        write_segment(path, segment, fps, codec, first)
        yield path
    except OSError as error:
        # Nobody knows the temporary file.
        if error.filename in (None, str(path)):
            raise OSError(error.errno, error.strerror or str(error), str(film)) from error
        raise
    finally:
        with suppress(OSError):
            path.unlink(missing_ok=True)


class _Joined:
    """The tracks of a film that is joined.

    Args:
        container: of the film.
        form: of all segments.
        fps: frames per second.
        sound: of the film.
        codec: of the film.

    Attributes:
        count: number of pictures so far.
    """

    def __init__(
        self, container: Any, form: SegmentForm, fps: Fraction, sound: Sound | None, codec: Codec
    ) -> None:
        self._container, self._form, self._fps = container, form, fps
        self.count = 0
        # The first packet writes the header, so both streams are declared before. The encoder
        # tells the container all that it knows of such a video, and encodes nothing.
        self._video = video_stream(container, form.size, fps, codec)
        wanted = self._video.codec_context.codec.canonical_name
        if form.codec != wanted:
            raise EncodeError(f"a segment is {form.codec}, not {wanted}; encode it again")
        with kept_priority():
            self._video.codec_context.open()
        if form.extradata is not None:
            self._video.codec_context.extradata = form.extradata
        self._track = None if sound is None else SoundTrack(container, sound, codec.sound)

    def add(self, form: SegmentForm, packets: Iterable[av.Packet[Any]]) -> None:
        """Add a segment, with the sound of its time.

        Raises:
            EncodeError: it is of another form than the first.
        """
        if form.size != self._form.size:
            raise EncodeError(
                f"frame {self.count + 1} is {form.size[0]}x{form.size[1]} and the first "
                f"{self._form.size[0]}x{self._form.size[1]}; render all frames at one size"
            )
        if form != self._form:
            raise EncodeError(
                f"the segment from frame {self.count + 1} on was encoded by another version or "
                "with other settings than the first; encode all segments with one version"
            )
        for packet in packets:
            packet.time_base, packet.duration = 1 / self._fps, 0
            packet.pts = packet.dts = self.count
            packet.stream = self._video
            self._container.mux(packet)
            self.count += 1
            if self._track is not None:
                self._track.encode_until(self.count / self._fps)

    def finish(self) -> int:
        """End the sound with the pictures, and return their number."""
        if self._track is not None:
            self._track.finish_at(self.count / self._fps)
        return self.count
