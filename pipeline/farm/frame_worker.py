"""Frame worker: frames of a film from the store, rendered into the store.

A worker keeps the scene, the rows and the renderer of the film that it worked on last, because
building them takes as long as several frames.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from pipeline.farm.archive import read_arrays
from pipeline.farm.film import Film, scene_of
from pipeline.farm.frame_index import FrameIndex, FrameRecord, class_of
from pipeline.farm.preparation import tracks_name
from pipeline.farm.seals import digest_of
from pipeline.farm.store import Store
from pipeline.farm.take_object import TakeRows, take_required
from pipeline.production.run.interrupts import held_back
from pipeline.production.run.outputs import Outputs
from pipeline.production.run.scene_run import translated_errors
from pipeline.production.shots.film_tracks import FilmTracks
from pipeline.production.shots.frame_rendering import frame_key, render_frames
from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.spec import Scene
from render.backend import Choice, choose
from render.renderer import Renderer, Timings


@dataclass(slots=True)
class ChunkCost:
    """What some frames of a film have cost.

    Attributes:
        rendered: frames that were rendered.
        kept: frames that were in the store.
        load: reading scene, take and tracks [s].
        first: the first frame, with the build of its scene [s]; 0.0 where nothing was built.
        frames: all others [s].
        fetched: read of the take [bytes].
        stored: pictures that were written [bytes].
    """

    rendered: int = 0
    kept: int = 0
    load: float = 0.0
    first: float = 0.0
    frames: float = 0.0
    fetched: int = 0
    stored: int = 0


@dataclass(slots=True)
class _Loaded:
    """The film that a worker works on."""

    film: Film
    rows: TakeRows
    shooting: ShotBuilder
    is_built: bool = False


Progress = Callable[[int, int], None]
"""Called with the number of frames that are in the store, and how many of them were there."""


class FrameWorker:
    """Renders frames of films of a store.

    Args:
        store: of the farm.
        backend: of the renderer.
        threads: of the renderer, all processors by default; pictures do not depend on it.
        mixed: whether it may go on with a film that another class of renderer began.
    """

    def __init__(
        self,
        store: Store,
        backend: Choice = "auto",
        threads: int | None = None,
        mixed: bool = False,
    ) -> None:
        self._store, self._mixed = store, mixed
        self._backend, self._threads = backend, threads
        self._renderer: Renderer | None = None
        self._loaded: _Loaded | None = None

    @property
    def film(self) -> str:
        """Key of the film that it worked on last, "" before the first."""
        return self._loaded.film.key if self._loaded else ""

    def render(
        self,
        film: Film,
        frames: Sequence[int],
        progress: Progress = lambda done, kept: None,
        scene: Scene | None = None,
    ) -> ChunkCost:
        """Render the frames that the store does not have, and store each when it is finished.

        Args:
            film: that is prepared.
            frames: ascending.
            progress: of the frames.
            scene: of the film, read from the store by default.

        Raises:
            FilmingError: a frame cannot be rendered.
            MixedClasses: another class of renderer began the film.
            TakeLost: the take has to be made again.
            StoreError: something cannot be read or written.
        """
        cost = ChunkCost()
        index = FrameIndex(self._store, film)
        with translated_errors():
            renderer = self._ready_renderer()
            index.begin_class(renderer.key_extra, self._mixed)
            done, mine = index.done(), class_of(renderer.key_extra)
            due = [frame for frame in frames if mine not in done.get(frame, ())]
            cost.kept = len(frames) - len(due)
            progress(cost.kept, cost.kept)
            if due:
                with take_required(self._store):
                    loaded = self._load(film, due, scene, cost)
                self._render_due(loaded, index, due, cost, progress)
        return cost

    def _ready_renderer(self) -> Renderer:
        if self._renderer is None:
            with held_back():
                self._renderer = Renderer(choose(self._backend), self._threads)
        return self._renderer

    def _load(
        self, film: Film, frames: Sequence[int], scene: Scene | None, cost: ChunkCost
    ) -> _Loaded:
        """Return the film with the rows of frames."""
        began = time.monotonic()
        loaded = self._loaded
        if loaded is None or loaded.film.key != film.key:
            # The old one is freed before the new one is read.
            self._loaded = None
            rows = TakeRows(self._store, film.take)
            tracks = FilmTracks.of_arrays(read_arrays(self._store, tracks_name(film)))
            shooting = ShotBuilder(scene or scene_of(self._store, film), rows.take, tracks)
            self._loaded = loaded = _Loaded(film, rows, shooting)
        before = loaded.rows.bytes_read if loaded.is_built else 0
        for frame in frames:
            loaded.rows.require(frame, frame)
        cost.fetched, cost.load = loaded.rows.bytes_read - before, time.monotonic() - began
        return loaded

    def _render_due(
        self,
        loaded: _Loaded,
        index: FrameIndex,
        due: Sequence[int],
        cost: ChunkCost,
        progress: Progress,
    ) -> None:
        renderer, film = self._ready_renderer(), loaded.film
        renderer.timings = Timings()
        keys = {frame: frame_key(loaded.shooting, frame, renderer.key_extra) for frame in due}
        for frame in list(keys):
            if self._record_known(film, index, frame, keys[frame], renderer.key_extra):
                del keys[frame]
                cost.kept += 1
                progress(cost.kept, cost.kept)
        with tempfile.TemporaryDirectory(prefix="pronk_frames_") as made:
            outputs = Outputs(Path(made), film.name)
            outputs.frames.mkdir()
            written = render_frames(renderer, loaded.shooting, outputs, keys)
            began = time.monotonic()
            for frame, (path, _) in zip(keys, written, strict=True):
                data = path.read_bytes()
                path.unlink()
                self._store.put(film.frame_object(keys[frame]), data)
                seconds = time.monotonic() - began
                began += seconds
                index.put(_record(frame, keys[frame], data, renderer.key_extra, seconds))
                if cost.rendered == 0 and not loaded.is_built:
                    cost.first = seconds
                else:
                    cost.frames += seconds
                loaded.is_built = True
                cost.rendered += 1
                cost.stored += len(data)
                progress(cost.rendered + cost.kept, cost.kept)

    def _record_known(
        self, film: Film, index: FrameIndex, frame: int, key: str, renderer: str
    ) -> bool:
        """Record a picture that another film has made; return whether there is one."""
        name = film.frame_object(key)
        if not self._store.has(name):
            return False
        index.put(_record(frame, key, self._store.get(name), renderer))
        return True


def _record(frame: int, key: str, data: bytes, renderer: str, seconds: float = 0.0) -> FrameRecord:
    return FrameRecord(frame, key, digest_of(data), len(data), renderer, round(seconds, 3))


def shard_frames(frames: Sequence[int], number: int, of: int) -> tuple[int, ...]:
    """Return one of several nearly equal runs of frames.

    Args:
        frames: all of them.
        number: of the run, from 1.
        of: number of runs.
    """
    first, last = (len(frames) * n // of for n in (number - 1, number))
    return tuple(frames[first:last])
