"""Sequence source: what the film of a sequence is made of, as its manifest keeps it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Collection, Iterator, Sequence
from dataclasses import asdict, dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from pipeline.production.run.file_records import FileRecords
from pipeline.production.run.film_source import FilmSource
from pipeline.production.run.manifest import Manifest
from pipeline.production.run.outputs import Outputs
from pipeline.production.shots.title_timing import TitledFilm, words_at
from pipeline.spec import SceneSequence
from render.config.titles import Title
from render.errors import RenderError
from render.film_codecs import CODECS
from render.film_segments import Picture
from render.lettering import lettered

CLIPS = "clips"
"""Folder of the clips' own outputs."""


@dataclass(frozen=True, slots=True)
class ClipSource:
    """A clip in the film.

    Attributes:
        name: of its folder and files.
        source: its frames.
        at: frames of the film before it.
        rise: frames of its transition at the beginning.
        fall: frames of its transition at the end.
    """

    name: str
    source: FilmSource
    at: int
    rise: int
    fall: int

    def outputs(self, sequence: Outputs) -> Outputs:
        """Return its own outputs, within those of the sequence."""
        return Outputs(sequence.folder / CLIPS / self.name, self.name)

    def weight(self, k: int) -> float:
        """Return by how much its frame k, from 0, is seen.

        The weights of two clips that dissolve add up to 1 in each frame.
        """
        count = len(self.source.frames)
        return min((k + 1) / (self.rise + 1), (count - k) / (self.fall + 1), 1.0)


@dataclass(frozen=True, slots=True)
class SequenceSource:
    """What the film of a sequence is made of.

    Attributes:
        clips: in their order.
        titled: its titles and what they go by.
        rate: frames per second.
        codec: of the film.
        has_sound: whether it has sound.
    """

    clips: tuple[ClipSource, ...]
    titled: TitledFilm
    rate: Fraction
    codec: str
    has_sound: bool

    sound_from = Fraction(0)

    @staticmethod
    def of(sequence: SceneSequence, has_sound: bool) -> SequenceSource:
        """Return the source of a sequence's film."""
        clips = tuple(
            ClipSource(
                clip.name,
                FilmSource.of(clip.scene, tuple(range(clip.first, clip.last + 1)), has_sound),
                *(clip.at, clip.rise, clip.fall),
            )
            for clip in sequence.clips
        )
        codec = sequence.clips[0].scene.film.resolved().codec
        return SequenceSource(clips, titled_film(sequence), sequence.rate, codec, has_sound)

    @property
    def facts(self) -> dict[str, Any]:
        """Its members as JSON has them."""
        clips = [{**asdict(clip), "source": clip.source.facts} for clip in self.clips]
        titled = {**asdict(self.titled), "titles": []}
        titled["titles"] = [title.model_dump(mode="json") for title in self.titled.titles]
        return {
            "clips": clips,
            "titled": json.loads(json.dumps(titled)),
            "rate": str(self.rate),
            "codec": self.codec,
            "has_sound": self.has_sound,
        }

    @staticmethod
    def read(members: object) -> SequenceSource | None:
        """Return the source that `facts` wrote, None for anything else."""
        match members:
            case {
                "clips": list(clips),
                "titled": dict(titled),
                "rate": str(rate),
                "codec": str(codec),
                "has_sound": bool(has_sound),
            } if codec in CODECS:
                try:
                    return SequenceSource(
                        tuple(_clip(clip) for clip in clips),
                        _titled(titled),
                        *(Fraction(rate), codec, has_sound),
                    )
                except (KeyError, TypeError, ValueError, ZeroDivisionError, ValidationError):
                    return None
        return None

    @property
    def n_frames(self) -> int:
        """Number of frames of the film."""
        return self.clips[-1].at + len(self.clips[-1].source.frames)

    def key(self, outputs: Outputs, records: FileRecords) -> str:
        """Return the key of the film: a digest of all that it is made of and of its sound.

        Args:
            outputs: of the sequence.
            records: of its own files.
        """
        state = hashlib.blake2b(digest_size=20)
        state.update(json.dumps([repr(CODECS[self.codec]), self.facts]).encode())
        for clip in self.clips:
            own = clip.outputs(outputs)
            files = FileRecords(own.folder, Manifest.read(own.manifest).files)
            state.update(f"\n{clip.source.key(own, files)}".encode())
        sound = records.of(outputs.wav) if self.has_sound else None
        state.update(f"\n{sound.digest if sound else ''}".encode())
        return state.hexdigest()

    def pictures(self, outputs: Outputs) -> Iterator[Picture]:
        """Yield the pictures of the film in their order.

        Raises:
            FrameFileError: a frame cannot be read.
        """
        for number in range(self.n_frames):
            yield self._picture(outputs, number)

    def whole_pictures(
        self, outputs: Outputs, damaged: Collection[str]
    ) -> Iterator[Picture | None]:
        """Yield the pictures of the film, None for one that a damaged frame is in.

        Args:
            outputs: of the sequence.
            damaged: names of damaged files from its folder.
        """
        for number in range(self.n_frames):
            files = [path for path, _, _ in self._shown(outputs, number)]
            names = {path.relative_to(outputs.folder).as_posix() for path in files}
            try:
                yield None if names & set(damaged) else self._picture(outputs, number)
            except RenderError:
                yield None

    def _picture(self, outputs: Outputs, number: int) -> Picture:
        shown = list(self._shown(outputs, number))
        pictures = [source.picture(path) for path, source, _ in shown]
        picture = pictures[0]
        if len(shown) > 1 or shown[0][2] != 1.0:
            weights = [weight for _, _, weight in shown]
            picture = _blended(pictures, weights)
        words = words_at(self.titled, float((number + Fraction(1, 2)) / self.rate))
        if not words:
            return picture
        return lettered(picture, words)

    def _shown(self, outputs: Outputs, number: int) -> Iterator[tuple[Path, FilmSource, float]]:
        """Yield the file, the source and the weight of each frame that is in one of the film."""
        for clip in self.clips:
            k = number - clip.at
            if 0 <= k < len(clip.source.frames):
                frame = clip.source.frames[k]
                path = clip.outputs(outputs).frame(frame, clip.source.format)
                yield path, clip.source, clip.weight(k)


def _blended(pictures: Sequence[Picture], weights: Sequence[float]) -> Picture:
    """Return a weighted sum of pictures as they are shown, as editing programs dissolve them."""
    whole = np.zeros(pictures[0].shape, np.float32)
    for picture, weight in zip(pictures, weights, strict=True):
        whole += np.float32(weight) * picture
    if pictures[0].dtype == np.uint16:
        return (whole + 0.5).astype(np.uint16)
    return (whole + 0.5).astype(np.uint8)


def titled_film(sequence: SceneSequence) -> TitledFilm:
    """Return what the titles of a sequence go by; its end credits list the titles of its scenes."""
    scenes = [clip.scene for clip in sequence.clips]
    names = tuple(dict.fromkeys(scene.title for scene in scenes if scene.title))
    length = float(sequence.n_frames / sequence.rate)
    return TitledFilm(
        sequence.titles, sequence.title, names, length, scenes[0].film.resolved().size
    )


def _clip(members: dict[str, Any]) -> ClipSource:
    source = FilmSource.read(members["source"])
    if source is None:
        raise ValueError("not the frames of a clip")
    name = members["name"]
    if not isinstance(name, str) or "/" in name or name.startswith("."):
        raise ValueError("not the name of a clip")
    return ClipSource(name, source, *(int(members[key]) for key in ("at", "rise", "fall")))


def _titled(members: dict[str, Any]) -> TitledFilm:
    titles = tuple(Title.model_validate(one) for one in members["titles"])
    wide, high = map(int, members["size"])
    names = tuple(map(str, members["names"]))
    return TitledFilm(titles, str(members["title"]), names, float(members["length"]), (wide, high))
