"""Workers: rendering frames in several processes at once."""

from __future__ import annotations

import atexit
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass, fields, replace
from pathlib import Path

from pipeline.errors import FilmingError
from pipeline.production.run.outputs import Outputs
from pipeline.production.shots.frame_rendering import film_frames
from pipeline.production.shots.shot_builder import Shooting
from pipeline.simulation.take_store import read_take
from pipeline.spec.scene import Scene
from render.backend import Backend
from render.errors import DeviceMemoryShort, RenderError
from render.renderer import Renderer, Timings

FRAMES_A_PROCESS = 500
"""Workers are replaced after so many frames each: Mitsuba does not give all memory back."""

FRAMES_A_PIECE = 16
"""So many frames are given to a worker at once, at most."""


@dataclass(frozen=True, slots=True)
class Share:
    """Frames to be rendered, and all that a worker needs for them."""

    scene: Scene
    take: Path
    outputs: Outputs
    backend: Backend
    keys: dict[int, str]

    def pieces(self, size: int) -> Iterator[Share]:
        """Cut into runs of `size` neighbouring frames."""
        frames = list(self.keys)
        for first in range(0, len(frames), size):
            keys = {frame: self.keys[frame] for frame in frames[first : first + size]}
            yield replace(self, keys=keys)


def film_in_processes(share: Share, jobs: int, progress: Callable[[int], None]) -> Timings:
    """Render the frames of `share` in `jobs` processes at once.

    Args:
        share: all of them.
        jobs: number of processes.
        progress: called with the number of frames done so far.

    Returns:
        Where their time went, summed over the processes.

    Raises:
        FilmingError: if a frame cannot be rendered or written, or a process died.
        DeviceMemoryShort: a graphics processor has too little memory.
    """
    split = Timings()

    def done(part: Timings) -> None:
        for one in fields(split):
            setattr(split, one.name, getattr(split, one.name) + getattr(part, one.name))
        progress(split.frames)

    for batch in share.pieces(jobs * FRAMES_A_PROCESS):
        size = min(FRAMES_A_PIECE, max(1, len(batch.keys) // (jobs * 4)))
        _film_pieces(list(batch.pieces(size)), jobs, done)
    return split


def _film_pieces(pieces: Sequence[Share], jobs: int, done: Callable[[Timings], None]) -> None:
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(min(jobs, len(pieces)), context, begin_work) as pool:
        try:
            with deaf_children():
                parts = [pool.submit(_film_piece, piece) for piece in pieces]
            for future in as_completed(parts):
                part = future.result()
                if isinstance(part, DeviceMemoryShort):
                    raise part
                if isinstance(part, str):
                    raise FilmingError(part)
                done(part)
        except BrokenProcessPool as error:
            raise FilmingError(
                "a process that rendered has died; if memory was short, try fewer --jobs"
            ) from error
        except BaseException:
            # The pool would wait for all that is under way.
            for child in multiprocessing.active_children():
                child.terminate()
            raise


@contextmanager
def deaf_children() -> Iterator[None]:
    """Let processes that are started inside ignore Ctrl-C from their first moment.

    What is ignored stays so in a new program; a handler of theirs would come too late for
    the imports that they begin with. Here Ctrl-C goes on being heard, see `interrupts`.
    """
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


# --- in a worker ------------------------------------------------------------------

_equipment: tuple[Shooting, Renderer] | None = None
"""What this worker renders with: made for its first piece and kept for the others."""


def begin_work() -> None:
    """Prepare a worker's process."""
    # The parent answers Ctrl-C, and ends its workers.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # What a library prints is no result of the command.
    os.dup2(2, 1)
    atexit.register(_end_work)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_work() -> None:
    # The bindings complain of whatever is still alive when Python ends.
    global _equipment
    _equipment = None


def _end_with_parent() -> None:
    """End this process when the one that started it has been killed.

    The folder of the outputs is then free for another run, which must be alone in it.
    """
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _film_piece(piece: Share) -> Timings | str | DeviceMemoryShort:
    """Render one piece; an error comes back as its message."""
    global _equipment
    try:
        if _equipment is None:
            shooting = Shooting(piece.scene, read_take(piece.take))
            _equipment = shooting, Renderer(piece.backend)
        shooting, renderer = _equipment
        renderer.timings = Timings()
        for _ in film_frames(renderer, shooting, piece.outputs, piece.keys):
            pass
    except DeviceMemoryShort as error:
        return error
    except (FilmingError, RenderError) as error:
        return str(error)
    return renderer.timings
