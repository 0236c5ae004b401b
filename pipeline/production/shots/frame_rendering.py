"""Filming: which frames are due, and rendering them one after the other.

A frame is due if the picture kept for it was made from something else than what the
renderer would be given now: its key is a digest of the whole shot, of the backend and
of the denoiser with its thread count, and stands inside the picture's own file.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

from pipeline.errors import FilmingError
from pipeline.production.run.interrupts import held_back
from pipeline.production.run.outputs import Outputs
from pipeline.production.shots.shot_builder import Shooting
from render.errors import DeviceMemoryShort, RenderError
from render.frame import Frame
from render.image_files import read_key, write_exr, write_png
from render.renderer import Renderer


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
        DeviceMemoryShort: a graphics processor has too little memory.
    """
    waiting: list[tuple[int, Future[None]]] = []
    with ThreadPoolExecutor(max_workers=1) as writer:
        try:
            for frame, key in keys.items():
                with held_back():
                    picture = renderer.render(shooting.shot(frame))
                path = outputs.frame(frame, shooting.film.format)
                waiting.append((frame, writer.submit(write_frame, path, picture, key)))
                # At most one picture waits, so that memory stays flat.
                while len(waiting) > 1:
                    yield _kept(waiting.pop(0))
            for pair in waiting:
                yield _kept(pair)
        except DeviceMemoryShort:
            raise
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
