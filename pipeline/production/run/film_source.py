"""Film source: what a film is made of, as the manifest keeps it for whoever checks the film."""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Iterator
from dataclasses import asdict, dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from fileseq import FrameSet

from pipeline.errors import UsageError
from pipeline.production.run.file_records import FileRecords
from pipeline.production.run.frame_ranges import read_frames
from pipeline.production.run.outputs import Outputs
from pipeline.spec import Scene
from render.development import developed, developed16
from render.errors import RenderError
from render.film_codecs import CODECS
from render.film_segments import Picture, segment_length
from render.image_files import read_development, read_exr, read_png


def split_frames(frames: tuple[int, ...], rate: Fraction) -> list[tuple[int, ...]]:
    """Return the frames of each segment of a film of some frames at a rate."""
    length = segment_length(rate)
    return [frames[first : first + length] for first in range(0, len(frames), length)]


@dataclass(frozen=True, slots=True)
class FilmSource:
    """What a film is made of.

    Attributes:
        frames: ascending.
        rate: frames per second.
        format: of the frames, "png" or "exr".
        has_sound: whether it has the sound of the WAV file.
        codec: of the film, a name in `CODECS`.
    """

    frames: tuple[int, ...]
    rate: Fraction
    format: str
    has_sound: bool
    codec: str

    @property
    def facts(self) -> dict[str, Any]:
        """Its members as JSON has them."""
        return {**asdict(self), "frames": str(FrameSet(self.frames)), "rate": str(self.rate)}

    @staticmethod
    def of(scene: Scene, frames: tuple[int, ...], has_sound: bool) -> FilmSource:
        """Return the source of a film of some frames of a scene."""
        film = scene.film.resolved()
        return FilmSource(frames, scene.rate, film.format, has_sound, film.codec)

    @staticmethod
    def read(members: object) -> FilmSource | None:
        """Return the source that `facts` wrote, None for anything else."""
        match members:
            case {
                "frames": str(frames),
                "rate": str(rate),
                "format": "png" | "exr" as format,
                "has_sound": bool(has_sound),
                "codec": str(codec),
            } if codec in CODECS:
                try:
                    numbers = read_frames(frames)
                    return FilmSource(numbers, Fraction(rate), format, has_sound, codec)
                except (UsageError, ValueError, ZeroDivisionError):
                    return None
        return None

    @property
    def sound_from(self) -> Fraction:
        """Time in the sound of the first frame [s]."""
        return (self.frames[0] - 1) / self.rate

    @property
    def segments(self) -> list[tuple[int, ...]]:
        """Frames of each segment of the film."""
        return split_frames(self.frames, self.rate)

    def files(self, outputs: Outputs) -> list[Path]:
        """Return the files of the frames."""
        return [outputs.frame(frame, self.format) for frame in self.frames]

    def key(self, outputs: Outputs, records: FileRecords) -> str:
        """Return the key of the film: a digest of its codec, its rate and its sources' records."""
        names = [records.name(path) for path in self.files(outputs)]
        keys = [records[name].key if name in records else "" for name in names]
        state = hashlib.blake2b(digest_size=20)
        codec = repr(CODECS[self.codec])
        state.update("\n".join([codec, str(self.rate), str(self.frames[0]), *keys]).encode())
        if self.has_sound:
            sound = records.of(outputs.wav)
            state.update(f"\n{sound.digest if sound else ''}".encode())
        if len(self.segments) > 1:
            state.update(f"\nsegments of {len(self.segments[0])}".encode())
        return state.hexdigest()

    def picture(self, path: Path) -> Picture:
        """Return the frame of a file as a picture of the film, with the bits of its codec.

        Raises:
            FrameFileError: the frame cannot be read.
        """
        deep = CODECS[self.codec].bits == 16
        if self.format == "exr":
            return (developed16 if deep else developed)(read_exr(path), read_development(path))
        picture = read_png(path)
        # 257 = 65535 / 255, so that white stays white.
        return picture.astype(np.uint16) * 257 if deep else picture

    def pictures(self, outputs: Outputs) -> Iterator[Picture]:
        """Yield the pictures of the film in their order.

        Raises:
            FrameFileError: a frame cannot be read.
        """
        for path in self.files(outputs):
            yield self.picture(path)

    def whole_pictures(
        self, outputs: Outputs, damaged: Collection[str]
    ) -> Iterator[Picture | None]:
        """Yield the pictures of the film, None for a damaged one.

        Args:
            outputs: of the frames.
            damaged: names of damaged files from the folder of the outputs.
        """
        for path in self.files(outputs):
            if path.relative_to(outputs.folder).as_posix() in damaged:
                yield None
                continue
            try:
                yield self.picture(path)
            except RenderError:
                yield None
