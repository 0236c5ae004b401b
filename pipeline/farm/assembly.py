"""Assembly: the frames of a farm as the outputs that rendering on one machine would have left."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from pipeline.atomic_file import write_if_changed
from pipeline.errors import StoreError
from pipeline.farm.archive import read_arrays
from pipeline.farm.film import Film
from pipeline.farm.frame_index import FrameRecord
from pipeline.farm.preparation import is_prepared, tracks_name
from pipeline.farm.segments import fetched_segments
from pipeline.farm.store import Store
from pipeline.farm.stored_frames import stored_pictures, stored_records
from pipeline.farm.take_object import fetch_take, take_required
from pipeline.production.run.encoder_check import require_encoders
from pipeline.production.run.exposure_stage import enter_exposure
from pipeline.production.run.film_stage import make_film
from pipeline.production.run.frame_ranges import parse_frames
from pipeline.production.run.frame_stage import enter_cuts, note_levels
from pipeline.production.run.order import Order
from pipeline.production.run.outputs import Outputs
from pipeline.production.run.picture_notes import shooting_notes
from pipeline.production.run.progress import Reporter, stage
from pipeline.production.run.scene_run import SceneRun, working
from pipeline.production.run.score_stage import write_score
from pipeline.production.run.take_stage import adopt_take
from pipeline.production.shots.film_tracks import FilmTracks
from pipeline.production.shots.shot_builder import ShotBuilder

MAX_BATCH = 32
"""Frames that are fetched at once."""


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
        # The cuts that the frames were shot by, whatever a director would decide here.
        tracks = FilmTracks.of_arrays(read_arrays(store, tracks_name(film)))
        shooting = ShotBuilder(order.scene, take, tracks)
        run.notes += shooting_notes(order.scene, shooting)
        run.refuse_notes()
        enter_cuts(run, shooting)
        if order.sound:
            write_score(run, take, shooting)
        _fetch_frames(run, store, film, records)
        enter_exposure(run, shooting, records[0].renderer)
        note_levels(run, shooting, frames)
        run.refuse_notes()
        with fetched_segments(store, film, records, run.outputs) as encoded:
            make_film(run, frames, encoded)
        run.finish()
        return run.outputs


def _records(store: Store, film: Film, frames: Sequence[int], mixed: bool) -> list[FrameRecord]:
    records = stored_records(store, film, frames, mixed)
    if not is_prepared(store, film):
        raise StoreError(
            f"{film.name}: the store has no take {film.take}; 'pronk farm simulate' makes it"
        )
    return records


def _fetch_frames(run: SceneRun, store: Store, film: Film, records: Sequence[FrameRecord]) -> None:
    """Write the frames that the outputs do not have, and record them."""
    with stage(run.reporter, "render", len(records), "frames") as current:
        due = [record for record in records if not _is_there(run, film, record)]
        kept = len(records) - len(due)
        current.keep(kept)
        run.manifest.entries["renderer"] = records[0].renderer
        pictures = stored_pictures(store, film, due, MAX_BATCH)
        for done, (record, data) in enumerate(pictures, kept + 1):
            path = run.outputs.frame(record.frame, film.format)
            write_if_changed(path, data)
            run.records.add(path, record.key)
            current.advance(done)
        current.result = f"{len(due)} fetched" if due else "frames are up to date"


def _is_there(run: SceneRun, film: Film, record: FrameRecord) -> bool:
    """Return whether the outputs have a frame, whole, as the store has it."""
    path = run.outputs.frame(record.frame, film.format)
    known = run.records.of(path, record.key)
    return (
        known is not None
        and known.digest == record.digest
        and (run.records.is_intact(path, record.key))
    )
