"""Assembly: the frames of a farm as the outputs that rendering on one machine would have left."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial

from fileseq import FrameSet

from pipeline.atomic_file import write_if_changed
from pipeline.errors import ProductionError, StoreError
from pipeline.farm.film import Film
from pipeline.farm.frame_index import READERS, FrameIndex, FrameRecord
from pipeline.farm.preparation import is_prepared
from pipeline.farm.store import ObjectDamaged, ObjectMissing, Store
from pipeline.farm.take_object import fetch_take, take_required
from pipeline.production.run.encoder_check import require_encoders
from pipeline.production.run.film_stage import make_film
from pipeline.production.run.frame_ranges import parse_frames
from pipeline.production.run.frame_stage import note_levels
from pipeline.production.run.order import Order
from pipeline.production.run.outputs import Outputs
from pipeline.production.run.picture_notes import camera_notes
from pipeline.production.run.progress import Reporter, stage
from pipeline.production.run.scene_run import SceneRun, working
from pipeline.production.run.score_stage import write_score
from pipeline.production.run.take_stage import adopt_take
from pipeline.production.shots.shot_builder import ShotBuilder

MAX_BATCH = 32
"""Frames that are fetched before they are reported."""


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


def assemble(
    order: Order, store: Store, film: Film, reporter: Reporter, mixed: bool = False
) -> Outputs:
    """Make film, score and manifest of a scene from the take and the frames in a store.

    Args:
        order: of the film.
        store: that has take and frames.
        film: of the order's scene.
        reporter: of the progress.
        mixed: whether frames of several classes of renderers make one film.

    Raises:
        FramesMissing: the store does not have all frames; nothing is written then.
        MixedClasses: no class of renderers made all frames.
        TakeLost: the take has to be made again.
        PronkError: something cannot be made; earlier outputs stay.
    """
    frames = parse_frames(order.frames, order.scene.n_frames)
    require_encoders(order.scene)
    records = _records(store, film, frames, mixed)
    with working(order, reporter) as run:
        run.frames = frames
        with take_required(store):
            take = adopt_take(run, film.take, partial(fetch_take, store, film.take))
        shooting = ShotBuilder(order.scene, take)
        run.notes += camera_notes(order.scene, shooting)
        run.refuse_notes()
        if order.sound:
            write_score(run, take, shooting)
        _fetch_frames(run, store, film, records)
        note_levels(run, shooting, frames)
        run.refuse_notes()
        make_film(run, frames)
        run.finish()
        return run.outputs


def missing_frames(store: Store, film: Film, frames: Sequence[int]) -> list[int]:
    """Return the frames that are not in a store."""
    done = FrameIndex(store, film).done()
    return [frame for frame in frames if frame not in done]


def _records(store: Store, film: Film, frames: Sequence[int], mixed: bool) -> list[FrameRecord]:
    index = FrameIndex(store, film)
    missing = missing_frames(store, film, frames)
    if missing:
        raise FramesMissing(film.name, missing, [f for f in index.failures() if f in missing])
    if not is_prepared(store, film):
        raise StoreError(
            f"{film.name}: the store has no take {film.take}; 'pronk farm simulate' makes it"
        )
    return index.records(frames, index.whole_class(frames, mixed))


def _fetch_frames(run: SceneRun, store: Store, film: Film, records: Sequence[FrameRecord]) -> None:
    """Write the frames that the outputs do not have, and record them."""
    with stage(run.reporter, "render", len(records), "frames") as current:
        due = [record for record in records if not _is_there(run, film, record)]
        current.keep(len(records) - len(due))
        run.manifest.entries["renderer"] = records[0].renderer
        for first in range(0, len(due), MAX_BATCH):
            _fetch_batch(run, store, film, due[first : first + MAX_BATCH])
            current.advance(len(records) - len(due) + min(first + MAX_BATCH, len(due)))
        current.result = f"{len(due)} fetched" if due else "frames are up to date"


def _fetch_batch(run: SceneRun, store: Store, film: Film, batch: Sequence[FrameRecord]) -> None:
    index = FrameIndex(store, film)

    def fetched(record: FrameRecord) -> bytes | None:
        try:
            return store.get_checked(film.frame_object(record.key), record.digest)
        except (ObjectMissing, ObjectDamaged):
            return None

    with ThreadPoolExecutor(READERS) as pool:
        contents = list(pool.map(fetched, batch))
    lost = [record for record, data in zip(batch, contents, strict=True) if data is None]
    for record in lost:
        # So that it is rendered again.
        index.forget(record)
        store.remove(film.frame_object(record.key))
    if lost:
        raise FramesMissing(film.name, [record.frame for record in lost])
    for record, data in zip(batch, contents, strict=True):
        assert data is not None
        path = run.outputs.frame(record.frame, film.format)
        write_if_changed(path, data)
        run.records.add(path, record.key)


def _is_there(run: SceneRun, film: Film, record: FrameRecord) -> bool:
    """Return whether the outputs have a frame, whole, as the store has it."""
    path = run.outputs.frame(record.frame, film.format)
    known = run.records.of(path, record.key)
    return (
        known is not None
        and known.digest == record.digest
        and (run.records.is_intact(path, record.key))
    )
