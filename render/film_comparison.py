"""Film comparison: a film decoded and compared with the frames and the sound that it was made of.

Pictures are compared in the codec's own pixel format, by the means of blocks: quantisation moves
single pixels, but the mean of a block hardly.
"""

from __future__ import annotations

import enum
import itertools
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
from numpy.typing import NDArray

from render.film_codecs import CODECS, CONTAINERS, RATE, Codec, Sound
from render.film_segments import Picture, video_frame

BLOCK = 16
"""Side of a block of luma; blocks of subsampled chroma are as large in the picture [pixels]."""

MAX_LEVELS = 6.0
"""Greatest difference between the means of a block, of 255.

Measured: 2.0 on rendered scenes (AV1), 3.7 on black and white noise in ProRes.
"""

WINDOW = RATE // 10
"""Length of a window of sound [samples]."""

MIN_CORRELATION = 0.35
"""Least correlation of a window that is audible.

Measured: 0.99 on steps and 0.51 on white noise in AAC, 0.75 on a film in Opus.
"""

AUDIBLE = 0.003
"""Root mean square from which a window is audible, of full scale."""

MAX_LEAK = 0.5
"""Root mean square in a silent window, of its louder neighbour: codecs smear onsets."""

MAX_LISTED = 4
"""Pictures that are listed one by one."""

Values = NDArray[np.float32]


class _Nothing(enum.Enum):
    """A frame or picture that there is not; None is a frame that is not compared."""

    ENDED = enum.auto()


def picture_differences(
    path: Path, frames: Iterable[Picture | None], fps: Fraction, codec: str = "h264"
) -> list[str]:
    """Return how the pictures of a film differ from those that `write_film` makes.

    Args:
        path: of the film.
        frames: as for `write_film`; None for a frame that is not compared.
        fps: frames per second.
        codec: of the film, a name in `CODECS`.
    """
    try:
        return list(_picture_differences(path, frames, fps, CODECS[codec]))
    except Exception as error:
        # A damaged file can raise anything.
        return [f"cannot be decoded ({error})"]


def sound_differences(
    path: Path, sound: Path | None, sound_from: Fraction = Fraction(0)
) -> list[str]:
    """Return how the sound of a film differs from that of its file.

    Args:
        path: of the film.
        sound: WAV file, None for a film without sound.
        sound_from: time in it of the film's first frame [s].
    """
    try:
        return list(_sound_differences(path, sound, sound_from))
    except Exception as error:
        # A damaged file can raise anything.
        return [f"its sound cannot be decoded ({error})"]


# --- pictures ---------------------------------------------------------------------


def _picture_differences(
    path: Path, frames: Iterable[Picture | None], fps: Fraction, codec: Codec
) -> Iterator[str]:
    compared = _Comparison(fps, codec, CONTAINERS[path.suffix].tick)
    with av.open(str(path)) as container:
        stream = _decodable(container.streams.video)
        # Broken pictures would be patched up in silence.
        stream.codec_context.options = {"err_detect": "explode"}
        pairs = itertools.zip_longest(container.decode(stream), frames, fillvalue=_Nothing.ENDED)
        for number, (picture, frame) in enumerate(pairs):
            compared.frames += frame is not _Nothing.ENDED
            if picture is not _Nothing.ENDED:
                known = None if frame is _Nothing.ENDED else frame
                compared.add(number, picture, known)
    yield from compared.texts()


def _decodable(streams: Any) -> Any:
    """Return the first of the streams.

    Raises:
        ValueError: there is none, or none that can be decoded.
    """
    if not streams or streams[0].codec_context is None:
        raise ValueError("it has no stream that can be")
    return streams[0]


@dataclass
class _Comparison:
    """Pictures of a film that are not like their frames; numbers count from 1.

    Attributes:
        fps: frames per second.
        codec: of the film.
        tick: unit of its times [s], 0 where they are exact.
        frames: number of frames.
        shown: number of pictures.
        late: those that are shown at another time.
        unlike: those of another size or format.
        wrong: those of other content, with the greatest difference of a block, of 255.
    """

    fps: Fraction
    codec: Codec
    tick: Fraction
    frames: int = 0
    shown: int = 0
    late: list[int] = field(default_factory=list)
    unlike: list[int] = field(default_factory=list)
    wrong: dict[int, float] = field(default_factory=dict)

    def add(self, index: int, picture: av.VideoFrame, frame: Picture | None) -> None:
        """Compare a picture with its frame, None for one that is not compared."""
        self.shown += 1
        time = Fraction(picture.pts or 0) * (picture.time_base or 0)
        if abs(time - index / self.fps) > self.tick / 2:
            self.late.append(index + 1)
        if frame is None:
            return
        levels = _levels_apart(picture, frame, index, self.fps, self.codec)
        if levels is None:
            self.unlike.append(index + 1)
        elif levels > MAX_LEVELS:
            self.wrong[index + 1] = levels

    def texts(self) -> Iterator[str]:
        """Yield what is wrong."""
        if self.shown != self.frames:
            yield f"shows {self.shown} pictures instead of {self.frames}"
        if self.late:
            yield f"{_listed(self.late)} not at the time of the frame"
        if self.unlike:
            yield f"{_listed(self.unlike)} of another size or format than the frame"
        if self.wrong:
            numbers, worst = list(self.wrong), max(self.wrong.values())
            yield f"{_listed(numbers)} unlike the frame, by up to {worst:.0f} levels of 255"


def _levels_apart(
    shown: av.VideoFrame, frame: Picture, number: int, fps: Fraction, codec: Codec
) -> float | None:
    """Return the greatest difference between the means of a block, of 255; None for other sizes."""
    expected = video_frame(frame, number, fps, codec)
    shape = (expected.width, expected.height, expected.format.name)
    if (shown.width, shown.height, shown.format.name) != shape:
        return None
    pairs = zip(_planes(shown), _planes(expected), strict=True)
    return max(_block_difference(one - two) for one, two in pairs)


def _planes(frame: av.VideoFrame) -> Iterator[Values]:
    """Yield the planes of a frame, 0 to 255."""
    is_deep = frame.format.components[0].bits > 8
    kind = np.dtype("<u2" if is_deep else "u1")
    for plane in frame.planes:
        values = np.frombuffer(memoryview(plane), kind).reshape(plane.height, -1)[:, : plane.width]
        yield values.astype(np.float32) / np.float32(4.0 if is_deep else 1.0)


def _block_difference(values: Values) -> float:
    """Return the greatest mean of a block, by magnitude."""
    rows, columns = (np.arange(0, length, BLOCK) for length in values.shape)
    sums = np.add.reduceat(np.add.reduceat(values, rows, axis=0), columns, axis=1)
    heights = np.diff(np.append(rows, values.shape[0]))
    widths = np.diff(np.append(columns, values.shape[1]))
    return float(np.abs(sums / np.outer(heights, widths)).max())


def _listed(numbers: list[int]) -> str:
    """Return picture numbers in words, with a verb."""
    named = ", ".join(map(str, numbers[:MAX_LISTED]))
    more = f" and {len(numbers) - MAX_LISTED} more" if len(numbers) > MAX_LISTED else ""
    return f"pictures {named}{more} are" if len(numbers) > 1 else f"picture {named} is"


# --- sound ------------------------------------------------------------------------


def _sound_differences(path: Path, sound: Path | None, sound_from: Fraction) -> Iterator[str]:
    with av.open(str(path)) as container:
        tracks = container.streams.audio
        if sound is None or not tracks:
            if tracks:
                yield "has sound, and was made without"
            elif sound is not None:
                yield "has no sound"
            return
        _decodable(tracks)
        length, lasts = _lengths(container)
        if abs(lasts - length) > Fraction(1, RATE):
            yield f"its sound lasts {float(lasts):.3f} s instead of {float(length):.3f} s"
    yield from _wave_differences(path, sound, round(sound_from * RATE), round(length * RATE))


def _lengths(container: Any) -> tuple[Fraction, Fraction]:
    """Return the lengths of the pictures and the sound [s]."""
    video, audio = container.streams.video[0], container.streams.audio[0]
    if video.duration is not None:
        return video.duration * video.time_base, audio.duration * audio.time_base
    # WebM tells no lengths of its tracks.
    pictures = samples = 0
    for packet in container.demux(video, audio):
        if packet.stream is video:
            pictures += packet.size > 0
        else:
            samples += sum(block.samples for block in packet.decode())
    return pictures / Fraction(video.average_rate), Fraction(samples, RATE)


def _wave_differences(path: Path, sound: Path, skipped: int, length: int) -> Iterator[str]:
    """Yield where the sound of a film first differs from `length` samples of its file."""
    measured = []
    pairs = itertools.zip_longest(_windows(path), _windows(sound, skipped))
    for number, (heard, written) in enumerate(pairs):
        # The film's sound is cut or padded to its pictures; codecs fill the last block.
        rest = min(length - number * WINDOW, WINDOW)
        if rest < WINDOW // 2:
            break
        one, two = _padded(heard, rest), _padded(written, rest)
        measured.append((_level(one), _level(two), _correlation(one, two)))
    levels = [0.0, *(level for _, level, _ in measured), 0.0]
    for number, (heard_level, level, correlation) in enumerate(measured):
        start = f"its sound differs from {sound.name} from {number * WINDOW / RATE:.1f} s on"
        if level >= AUDIBLE:
            if correlation < MIN_CORRELATION:
                yield f"{start}: the two correlate by {correlation:.2f}"
                return
        elif heard_level > AUDIBLE + MAX_LEAK * max(levels[number], levels[number + 2]):
            yield f"{start}: something is heard where the file is silent"
            return


def _correlation(one: Values, two: Values) -> float:
    power = np.sum(np.square(one, dtype=float)) * np.sum(np.square(two, dtype=float))
    return float(np.sum(one * two, dtype=float) / np.sqrt(power)) if power else 0.0


def _level(values: Values) -> float:
    return float(np.sqrt(np.mean(np.square(values, dtype=float))))


def _padded(window: Sound | None, length: int) -> Values:
    """Return the first samples of a window as stereo (2, length), with silence after its end."""
    padded = np.zeros((2, length), np.float32)
    if window is not None:
        padded[:, : window.shape[1]] = window[:, :length]
    return padded


def _windows(path: Path, skipped: int = 0) -> Iterator[Sound]:
    """Yield the sound of a file in windows of (channels, WINDOW), from a sample on."""
    pending: Any = None
    with av.open(str(path)) as container:
        stream = container.streams.audio[0]
        to_float = av.AudioResampler(format="fltp", layout=stream.codec_context.layout, rate=RATE)
        for block in container.decode(stream):
            for piece in to_float.resample(block):
                # Players drop samples before time 0.
                first = round(Fraction(piece.pts or 0) * (piece.time_base or 0) * RATE)
                values = piece.to_ndarray()[:, max(skipped - first, 0) :]
                pending = values if pending is None else np.concatenate([pending, values], axis=1)
                while pending.shape[1] >= WINDOW:
                    yield pending[:, :WINDOW]
                    pending = pending[:, WINDOW:]
    if pending is not None and pending.shape[1]:
        yield pending
