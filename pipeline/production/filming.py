"""Filming: which frames are due, and rendering them, in this process or in several.

A frame is due if the picture kept for it was made from something else than what the
renderer would be given now: its key is a digest of the whole shot, of the backend and
of the denoiser with its thread count, and stands inside the picture's own file.
"""

from __future__ import annotations

import hashlib
import multiprocessing
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from pipeline.errors import FilmingError
from pipeline.production.outputs import Outputs
from pipeline.production.shooting import Shooting
from pipeline.simulation.take_store import read_take
from pipeline.spec.scene import Scene
from render.backend import Backend
from render.errors import RenderError
from render.frame import Frame
from render.pictures import read_key, write_exr, write_png
from render.renderer import Renderer, Split

FRAMES_A_PROCESS = 500
"""A worker process is replaced after so many frames: Mitsuba does not give all memory back."""


def frame_key(shooting: Shooting, frame: int, extra: str) -> str:
    """Return the key of a frame: all that its picture depends on."""
    words = f"{shooting.shot(frame).digest}|{extra}"
    return hashlib.blake2b(words.encode(), digest_size=20).hexdigest()


def due(
    shooting: Shooting, outputs: Outputs, frames: Sequence[int], extra: str
) -> tuple[dict[int, str], list[int]]:
    """Return the keys of `frames`, and those whose picture is not there or is of something else."""
    suffix = shooting.film.format
    keys = {frame: frame_key(shooting, frame, extra) for frame in frames}
    missing = [f for f in frames if read_key(outputs.frame(f, suffix)) != keys[f]]
    return keys, missing


def film_frames(
    renderer: Renderer, shooting: Shooting, outputs: Outputs, keys: dict[int, str]
) -> Iterator[int]:
    """Render the frames of `keys` one after the other, and yield each as it is kept.

    Pictures are compressed and written beside the renderer's work on the next one.

    Raises:
        FilmingError: if a frame cannot be rendered or written.
    """
    waiting: list[tuple[int, Future[None]]] = []
    with ThreadPoolExecutor(max_workers=1) as writer:
        try:
            for frame, key in keys.items():
                picture = renderer.render(shooting.shot(frame))
                path = outputs.frame(frame, shooting.film.format)
                waiting.append((frame, writer.submit(write_frame, path, picture, key)))
                # At most one picture waits, so that memory stays flat.
                while len(waiting) > 1:
                    yield _kept(waiting.pop(0))
            for pair in waiting:
                yield _kept(pair)
        except (RenderError, OSError) as error:
            raise FilmingError(str(error)) from error


def write_frame(path: Path, frame: Frame, key: str) -> None:
    """Write a frame in the format that the name of its file says."""
    if path.suffix == ".exr":
        write_exr(path, frame.light, key)
    else:
        write_png(path, frame.srgb8, key)


def _kept(pair: tuple[int, Future[None]]) -> int:
    frame, future = pair
    future.result()
    return frame


@dataclass(frozen=True, slots=True)
class Share:
    """One worker's part of the frames, and all that it needs to render them."""

    scene: Scene
    take: Path
    outputs: Outputs
    backend: Backend
    keys: dict[int, str]


def film_in_processes(share: Share, jobs: int, progress: Callable[[int], None]) -> Split:
    """Render the frames of `share` in `jobs` processes at once.

    Args:
        share: all of them.
        jobs: number of processes.
        progress: called with the number of frames done so far.

    Returns:
        Where their time went, summed over the processes.

    Raises:
        FilmingError: if a frame cannot be rendered or written, or a process died.
    """
    context = multiprocessing.get_context("spawn")
    pieces = list(_pieces(share, jobs))
    split, done = Split(), 0
    # A worker is given one piece and is then replaced.
    with context.Pool(min(jobs, len(pieces)), _ignore_interrupt, maxtasksperchild=1) as pool:
        for part in pool.imap_unordered(_film_share, pieces):
            if isinstance(part, str):
                raise FilmingError(part)
            done += part.frames
            for name in ("frames", "build", "update", "trace", "denoise", "tone"):
                setattr(split, name, getattr(split, name) + getattr(part, name))
            progress(done)
    return split


def _pieces(share: Share, jobs: int) -> Iterator[Share]:
    """Cut `share` into runs of neighbouring frames, small enough to show progress."""
    frames = list(share.keys)
    size = min(FRAMES_A_PROCESS, max(1, -(-len(frames) // (jobs * 4))))
    for first in range(0, len(frames), size):
        keys = {frame: share.keys[frame] for frame in frames[first : first + size]}
        yield Share(share.scene, share.take, share.outputs, share.backend, keys)


def _film_share(share: Share) -> Split | str:
    """Render one share in a worker; an error comes back as its message."""
    try:
        shooting = Shooting(share.scene, read_take(share.take))
        renderer = Renderer(share.backend)
        for _ in film_frames(renderer, shooting, share.outputs, share.keys):
            pass
    except (FilmingError, RenderError) as error:
        return str(error)
    return renderer.split


def _ignore_interrupt() -> None:
    """Leave Ctrl-C to the parent, which ends its workers."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
