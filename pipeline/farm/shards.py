"""Shards: the work of one machine that nobody drives but a CI matrix, a job array or a person."""

from __future__ import annotations

import re
from dataclasses import asdict, dataclass

from pipeline.errors import StoreError, UsageError
from pipeline.farm.film import Film, film_of
from pipeline.farm.frame_index import FrameIndex
from pipeline.farm.frame_worker import ChunkCost, FrameWorker, shard_frames
from pipeline.farm.preparation import is_prepared, prepare
from pipeline.farm.segments import encode_segment
from pipeline.farm.store import Store
from pipeline.production.run.encoder_check import require_encoders
from pipeline.production.run.film_source import split_frames
from pipeline.production.run.frame_ranges import counted, parse_frames
from pipeline.production.run.notes import refuse_notes
from pipeline.production.run.order import Order
from pipeline.production.run.progress import Reporter, stage


@dataclass(frozen=True, slots=True)
class ShardResult:
    """What became of a shard.

    Attributes:
        film: that it belongs to.
        cost: of its frames.
    """

    film: Film
    cost: ChunkCost

    @property
    def text(self) -> str:
        """For people."""
        kept = f", {self.cost.kept} were there" if self.cost.kept else ""
        return f"{self.film.name}: {counted(self.cost.rendered)} rendered{kept}"

    @property
    def facts(self) -> dict[str, object]:
        """For other programs."""
        return {"film": self.film.key, "take": self.film.take, **asdict(self.cost)}


@dataclass(frozen=True, slots=True)
class EncodedShard:
    """What became of a shard of segments.

    Attributes:
        film: that they belong to.
        encoded: segments that were encoded.
        kept: segments that were in the store.
    """

    film: Film
    encoded: int = 0
    kept: int = 0

    @property
    def text(self) -> str:
        """For people."""
        kept = f", {self.kept} were there" if self.kept else ""
        noun = "segment" if self.encoded == 1 else "segments"
        return f"{self.film.name}: {self.encoded} {noun} encoded{kept}"

    @property
    def facts(self) -> dict[str, object]:
        """For other programs."""
        return {"film": self.film.key, "encoded": self.encoded, "kept": self.kept}


def prepare_film(order: Order, store: Store, reporter: Reporter) -> Film:
    """Return the film of a scene, whose take the store has then.

    Raises:
        NotesRefused: there are notes and the order is strict.
        PronkError: it cannot be simulated or stored.
    """
    film, files = film_of(order.scene, order.name)
    prepared = prepare(store, film, order.scene, files, reporter)
    if prepared.notes:
        reporter.notes(order.name, prepared.notes, None)
    if order.strict:
        refuse_notes(prepared.notes)
    return film


def render_shard(
    order: Order,
    store: Store,
    reporter: Reporter,
    take: str | None = None,
    shard: str | None = None,
    threads: int | None = None,
    mixed: bool = False,
) -> ShardResult:
    """Render frames of a scene into a store.

    Args:
        order: of the frames.
        store: that has the take.
        reporter: of the progress.
        take: key of the take; by default of the one that this machine would simulate.
        shard: part of the frames, such as "3/8"; None for all.
        threads: of the renderer, all processors by default.
        mixed: whether it may go on with a film that another class of renderer began.

    Raises:
        StoreError: the store does not have the take.
        UsageError: the shard is none.
        PronkError: a frame cannot be rendered or stored.
    """
    frames = parse_frames(order.frames, order.scene.n_frames)
    if shard is not None:
        frames = shard_frames(frames, *read_shard(shard))
    film, _ = film_of(order.scene, order.name, take)
    if not is_prepared(store, film):
        raise StoreError(
            f"{order.name}: {store.address} has no take {film.take} prepared for these settings; "
            "run 'pronk farm simulate' with the same scene and options first"
        )
    if not frames:
        return ShardResult(film, ChunkCost())
    worker = FrameWorker(store, order.backend, threads, mixed)
    with stage(reporter, "render", len(frames), "frames") as current:

        def progress(done: int, kept: int) -> None:
            if done == kept:
                current.keep(kept)
            else:
                current.advance(done)

        cost = worker.render(film, frames, progress, order.scene)
        FrameIndex(store, film).forget_failures(frames)
        result = ShardResult(film, cost)
        current.result = result.text
    return result


def encode_shard(
    order: Order,
    store: Store,
    reporter: Reporter,
    take: str | None = None,
    shard: str | None = None,
    mixed: bool = False,
) -> EncodedShard:
    """Encode segments of a film of several into a store; the only one of a film is left alone.

    Args:
        order: of the film.
        store: that has the frames.
        reporter: of the progress.
        take: key of the take; by default of the one that this machine would simulate.
        shard: part of the segments, such as "3/8"; None for all.
        mixed: whether frames of several classes of renderers make one film.

    Raises:
        FramesMissing: the store does not have all frames of a segment.
        UsageError: the shard is none.
        PronkError: a segment cannot be encoded or stored.
    """
    segments = split_frames(parse_frames(order.frames, order.scene.n_frames), order.scene.rate)
    mine = tuple(range(len(segments)))
    if shard is not None:
        mine = shard_frames(mine, *read_shard(shard))
    require_encoders(order.scene)
    film, _ = film_of(order.scene, order.name, take)
    if len(segments) == 1 or not mine:
        return EncodedShard(film)
    encoded = 0
    with stage(reporter, "encode", len(mine), "segments") as current:
        for done, number in enumerate(mine, 1):
            encoded += encode_segment(store, film, segments[number], mixed, order.scene)
            current.advance(done)
        result = EncodedShard(film, encoded, len(mine) - encoded)
        current.result = result.text
    return result


def read_shard(text: str) -> tuple[int, int]:
    """Return number and count of a shard such as "3/8".

    Raises:
        UsageError: it is none.
    """
    match = re.fullmatch(r"\s*([0-9]{1,6})\s*/\s*([0-9]{1,6})\s*", text)
    if match is None or not 1 <= int(match[1]) <= int(match[2]):
        raise UsageError(f"--shard {text!r}: write part and number of parts, from 1/8 to 8/8")
    return int(match[1]), int(match[2])
