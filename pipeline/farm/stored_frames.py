"""Stored frames: those of a film that the store has, all or none."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor

from fileseq import FrameSet

from pipeline.errors import ProductionError
from pipeline.farm.film import Film
from pipeline.farm.frame_index import READERS, FrameIndex, FrameRecord
from pipeline.farm.store import ObjectDamaged, ObjectMissing, Store


class FramesMissing(ProductionError):
    """Frames of a film are not in the store.

    Attributes:
        missing: their numbers.
    """

    def __init__(self, film: str, missing: Sequence[int], failed: Sequence[int] = ()) -> None:
        self.missing = tuple(missing)
        count = "1 frame is" if len(missing) == 1 else f"{len(missing)} frames are"
        text = f"{film}: {count} missing: {FrameSet(missing)}"
        if failed:
            text += f"; given up: {FrameSet(failed)}"
        super().__init__(f"{text}; 'pronk farm frames' renders them")

    @property
    def facts(self) -> dict[str, object]:
        """The missing frames."""
        return {"missing": str(FrameSet(self.missing))}


def missing_frames(store: Store, film: Film, frames: Sequence[int]) -> list[int]:
    """Return the frames that are not in a store."""
    done = FrameIndex(store, film).done()
    return [frame for frame in frames if frame not in done]


def stored_records(
    store: Store, film: Film, frames: Sequence[int], mixed: bool
) -> list[FrameRecord]:
    """Return the records of frames.

    Args:
        store: that has them.
        film: that they belong to.
        frames: one at least.
        mixed: whether frames of several classes of renderers are taken.

    Raises:
        FramesMissing: the store does not have them all.
        MixedClasses: no class of renderers made them all.
        StoreError: a record cannot be read.
    """
    index = FrameIndex(store, film)
    missing = missing_frames(store, film, frames)
    if missing:
        raise FramesMissing(film.name, missing, [f for f in index.failures() if f in missing])
    return index.records(frames, index.whole_class(frames, mixed))


def stored_pictures(
    store: Store, film: Film, records: Sequence[FrameRecord], batch: int
) -> Iterator[tuple[FrameRecord, bytes]]:
    """Yield records with the files of their frames, fetched so many at once.

    Raises:
        FramesMissing: frames are gone or damaged; their records are dropped, so that they are
            rendered again.
        StoreError: one cannot be read.
    """
    index = FrameIndex(store, film)

    def fetched(record: FrameRecord) -> bytes | None:
        try:
            return store.get_checked(film.frame_object(record.key), record.digest)
        except (ObjectMissing, ObjectDamaged):
            return None

    for first in range(0, len(records), batch):
        due = records[first : first + batch]
        with ThreadPoolExecutor(READERS) as pool:
            contents = list(pool.map(fetched, due))
        lost = [record for record, data in zip(due, contents, strict=True) if data is None]
        for record in lost:
            index.forget(record)
            store.remove(film.frame_object(record.key))
        if lost:
            raise FramesMissing(film.name, [record.frame for record in lost])
        for record, data in zip(due, contents, strict=True):
            assert data is not None
            yield record, data
