"""Segments of a farm's film: encoded by workers, fetched and joined where the film is assembled.

A film of one segment has none in the store: its assembly encodes it.
"""

from __future__ import annotations

import hashlib
import re
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

import av

import pipeline
from pipeline.atomic_file import NAME_LENGTH, PARTIAL
from pipeline.farm.film import Film, scene_of
from pipeline.farm.frame_index import READERS, FrameRecord
from pipeline.farm.seals import digest_of
from pipeline.farm.store import ObjectFault, Store
from pipeline.farm.stored_frames import stored_pictures, stored_records
from pipeline.production.run.film_source import FilmSource, split_frames
from pipeline.production.run.outputs import Outputs
from pipeline.production.run.scene_run import translated_errors
from pipeline.spec import Scene
from render.film_codecs import CODECS
from render.film_segments import Picture, segment_suffix, write_segment

_RECORD = re.compile(r"([0-9]{4,})-([0-9]{4,})\.json")


class SegmentIndex:
    """The segments of one film in a store.

    Args:
        store: that has them.
        film: that they belong to.
    """

    def __init__(self, store: Store, film: Film) -> None:
        self._store, self._film = store, film
        self._folder = f"{film.folder}/segments"

    def done(self) -> set[tuple[int, int]]:
        """Return first and last frame of each segment that is there."""
        found = (_RECORD.fullmatch(name) for name in self._store.names(self._folder))
        return {(int(match[1]), int(match[2])) for match in found if match}

    def put(self, frames: Sequence[int], key: str) -> None:
        """Note the key of a segment that is stored."""
        self._store.put_json(self._name(frames), {"key": key})

    def forget(self, frames: Sequence[int]) -> None:
        """Forget a segment that is damaged or gone."""
        self._store.remove(self._name(frames))

    def _name(self, frames: Sequence[int]) -> str:
        return f"{self._folder}/{frames[0]:04d}-{frames[-1]:04d}.json"


@dataclass(frozen=True, slots=True)
class _SegmentObject:
    """A segment in a store, under the key of its content, with its digest beside it.

    Attributes:
        store: that may have it.
        key: of the segment.
        suffix: of its file.
    """

    store: Store
    key: str
    suffix: str

    @property
    def _name(self) -> str:
        return f"segments/{self.key}{self.suffix}"

    @property
    def _digest_name(self) -> str:
        return f"segments/{self.key}.json"

    @property
    def is_there(self) -> bool:
        return self.store.has(self._digest_name) and self.store.has(self._name)

    def put(self, data: bytes) -> None:
        self.store.put(self._name, data)
        self.store.put_json(self._digest_name, {"digest": digest_of(data), "size": len(data)})

    def get(self) -> bytes | None:
        """Return its file, None if the store has none; one that is damaged is removed."""
        if not self.store.has(self._digest_name):
            return None  # perhaps it is being stored now
        try:
            digest = str(self.store.get_json(self._digest_name).get("digest"))
            return self.store.get_checked(self._name, digest)
        except ObjectFault:
            self.store.remove(self._digest_name)
            self.store.remove(self._name)
            return None


def due_segments(store: Store, film: Film, frames: tuple[int, ...]) -> list[tuple[int, ...]]:
    """Return the frames of each segment that the store does not have; none of a film of one."""
    segments = split_frames(frames, film.rate)
    if len(segments) == 1:
        return []
    done = SegmentIndex(store, film).done()
    return [segment for segment in segments if (segment[0], segment[-1]) not in done]


def encode_segment(
    store: Store,
    film: Film,
    frames: tuple[int, ...],
    mixed: bool = False,
    scene: Scene | None = None,
) -> bool:
    """Encode a segment of frames that are in the store, unless it is there.

    Args:
        store: of the farm.
        film: of the segment.
        frames: of the segment.
        mixed: whether frames of several classes of renderers make one film.
        scene: of the film, read from the store by default.

    Returns:
        Whether it was encoded.

    Raises:
        FramesMissing: frames are missing or damaged.
        MixedClasses: no class of renderers made them all.
        FilmingError: it cannot be encoded.
        StoreError: something cannot be read or written.
    """
    source = FilmSource.of(scene or scene_of(store, film), frames, has_sound=False)
    records = stored_records(store, film, frames, mixed)
    segment = _object(store, source, {record.frame: record.digest for record in records})
    index = SegmentIndex(store, film)
    if segment.is_there:
        index.put(frames, segment.key)  # perhaps made for another film with these frames
        return False
    with tempfile.TemporaryDirectory(prefix="pronk_segment_") as made, translated_errors():
        place = Path(made, f"segment{segment.suffix}")
        picture = Path(made, f"frame.{film.format}")

        def pictures() -> Iterator[Picture]:
            for _, data in stored_pictures(store, film, records, READERS):
                picture.write_bytes(data)
                yield source.picture(picture)

        write_segment(place, pictures(), source.rate, source.codec, frames[0])
        data = place.read_bytes()
    segment.put(data)
    index.put(frames, segment.key)
    return True


@contextmanager
def fetched_segments(
    store: Store, film: Film, records: Sequence[FrameRecord], outputs: Outputs
) -> Iterator[Callable[[FilmSource], Path | None]]:
    """Yield a function that fetches segments, one at a time, into a file beside the outputs.

    It returns None for a segment that the store does not have; one that is damaged is removed.

    Args:
        store: of the farm.
        film: that is assembled.
        records: of its frames.
        outputs: of the film.
    """
    digests = {record.frame: record.digest for record in records}
    index = SegmentIndex(store, film)
    several = len(split_frames(tuple(digests), film.rate)) > 1
    place = outputs.folder / f".{outputs.name[:NAME_LENGTH]}.stored{PARTIAL}"

    def fetched(segment: FilmSource) -> Path | None:
        if not several:
            return None
        data = _object(store, segment, digests).get()
        if data is None:
            index.forget(segment.frames)
            return None
        place.write_bytes(data)
        return place

    try:
        yield fetched
    finally:
        with suppress(OSError):
            place.unlink(missing_ok=True)


def _object(store: Store, segment: FilmSource, digests: Mapping[int, str]) -> _SegmentObject:
    """Return a segment under the key of all that its bytes depend on.

    Args:
        store: of the farm.
        segment: its frames, rate, codec and development.
        digests: of the files of frames.
    """
    versions = (pipeline.__version__, av.__version__, sorted(av.library_versions.items()))
    form = (CODECS[segment.codec], str(segment.rate), segment.format)
    frames = [digests[frame] for frame in segment.frames]
    text = repr((versions, form, frames))
    key = hashlib.blake2b(text.encode(), digest_size=16).hexdigest()
    return _SegmentObject(store, key, segment_suffix(segment.codec))
