"""Frame rendering: which frames are out of date, and rendering them in order.

A frame is out of date if the key in its file differs from its key now: a digest of the shot, the
backend and the denoiser with its thread count.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

from pipeline.errors import FilmingError
from pipeline.production.run.interrupts import held_back
from pipeline.production.run.outputs import Outputs
from pipeline.production.shots.shot_builder import ShotBuilder
from render.errors import DeviceMemoryShort, RenderError
from render.frame import Frame
from render.image_files import (
    read_exr,
    read_key,
    read_levels,
    read_png,
    write_exr,
    write_png,
)
from render.picture_levels import PictureLevels
from render.renderer import Renderer


def frame_key(builder: ShotBuilder, frame: int, extra: str) -> str:
    """Return the key of a frame, a digest of everything that it depends on."""
    content = f"{builder.shot(frame).digest}|{extra}"
    return hashlib.blake2b(content.encode(), digest_size=20).hexdigest()


def outdated_frames(
    builder: ShotBuilder, outputs: Outputs, frames: Sequence[int], extra: str
) -> tuple[dict[int, str], list[int]]:
    """Return the keys of `frames`, and the frames that are missing or out of date."""
    suffix = builder.film.format
    keys = {frame: frame_key(builder, frame, extra) for frame in frames}
    missing = [f for f in frames if read_key(outputs.frame(f, suffix)) != keys[f]]
    return keys, missing


def render_frames(
    renderer: Renderer, builder: ShotBuilder, outputs: Outputs, keys: dict[int, str]
) -> Iterator[int]:
    """Render the frames of `keys` in order, and yield each when it is written.

    Frames are compressed and written while the renderer works on the next one.

    Raises:
        FilmingError: if a frame cannot be rendered or written.
        DeviceMemoryShort: the GPU has too little memory.
    """
    pending: list[tuple[int, Future[None]]] = []
    with ThreadPoolExecutor(max_workers=1) as writer:
        try:
            for frame, key in keys.items():
                with held_back():
                    picture = renderer.render(builder.shot(frame))
                path = outputs.frame(frame, builder.film.format)
                pending.append((frame, writer.submit(write_frame, path, picture, key)))
                # At most one frame waits, which bounds the memory.
                while len(pending) > 1:
                    yield _written(pending.pop(0))
            for pair in pending:
                yield _written(pair)
        except DeviceMemoryShort:
            raise
        except (RenderError, OSError) as error:
            raise FilmingError(str(error)) from error


def write_frame(path: Path, frame: Frame, key: str) -> None:
    """Write a frame in the format of its file's suffix."""
    levels = PictureLevels.of(frame.light, frame.exposure)
    if path.suffix == ".exr":
        write_exr(path, frame.light, key, levels)
    else:
        write_png(path, frame.srgb8, key, levels=levels)


def frame_levels(
    builder: ShotBuilder, outputs: Outputs, frames: Sequence[int]
) -> list[PictureLevels]:
    """Return the levels of frames that are written.

    Raises:
        RenderError: a file cannot be read.
    """
    files = [outputs.frame(frame, builder.film.format) for frame in frames]
    return [read_levels(file) or _measured(file, builder.film.exposure) for file in files]


def _measured(path: Path, exposure: float) -> PictureLevels:
    """Return the levels of a frame that was written without them."""
    if path.suffix == ".exr":
        return PictureLevels.of(read_exr(path), exposure)
    return PictureLevels.of_srgb8(read_png(path))


def _written(pair: tuple[int, Future[None]]) -> int:
    frame, future = pair
    future.result()
    return frame
