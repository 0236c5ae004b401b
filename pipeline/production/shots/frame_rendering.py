"""Frame rendering: which frames are out of date, and rendering them in order.

A frame is out of date if the key in its file differs from its key now: a digest of the shot, the
backend and the denoiser with its thread count. It is damaged if it is not as it was recorded; of a
run that was stopped before it recorded its frames, if the file is not as it says itself.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

from pipeline.errors import FilmingError
from pipeline.production.run.file_records import FileRecord, FileRecords
from pipeline.production.run.interrupts import held_back
from pipeline.production.run.outputs import Outputs
from pipeline.production.shots.shot_builder import ShotBuilder
from render.errors import DeviceMemoryShort, RenderError
from render.frame import Frame
from render.image_files import (
    read_development,
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
    builder: ShotBuilder,
    outputs: Outputs,
    records: FileRecords,
    frames: Sequence[int],
    extra: str,
) -> tuple[dict[int, str], list[int]]:
    """Return the keys of `frames`, and the frames that are missing, out of date or damaged.

    Frames without a record that are whole are recorded.
    """
    suffix = builder.film.format
    keys = {frame: frame_key(builder, frame, extra) for frame in frames}
    missing = [f for f in frames if not _is_right(outputs.frame(f, suffix), records, keys[f])]
    return keys, missing


def _is_right(path: Path, records: FileRecords, key: str) -> bool:
    if records.of(path, key) is not None:
        return records.is_intact(path, key)
    if read_key(path) != key:
        return False
    records.add(path, key)
    return True


def render_frames(
    renderer: Renderer, builder: ShotBuilder, outputs: Outputs, keys: dict[int, str]
) -> Iterator[tuple[Path, FileRecord]]:
    """Render the frames of `keys` in order, and yield file and record of each when it is written.

    Frames are compressed and written while the renderer works on the next one.

    Raises:
        FilmingError: if a frame cannot be rendered or written.
        DeviceMemoryShort: the GPU has too little memory.
    """
    pending: list[tuple[Path, Future[FileRecord]]] = []
    with ThreadPoolExecutor(max_workers=1) as writer:
        try:
            for frame, key in keys.items():
                with held_back():
                    picture = renderer.render(builder.shot(frame))
                path = outputs.frame(frame, builder.film.format)
                pending.append((path, writer.submit(write_frame, path, picture, key)))
                # At most one frame waits, which bounds the memory.
                while len(pending) > 1:
                    path, written = pending.pop(0)
                    yield path, written.result()
            for path, written in pending:
                yield path, written.result()
        except DeviceMemoryShort:
            raise
        except (RenderError, OSError) as error:
            raise FilmingError(str(error)) from error


def write_frame(path: Path, frame: Frame, key: str) -> FileRecord:
    """Write a frame in the format of its file's suffix, and return the record of the file."""
    levels = PictureLevels.of(frame.light, frame.development)
    if path.suffix == ".exr":
        write_exr(path, frame.light, key, levels, frame.development, frame.passes.parts())
    else:
        write_png(path, frame.srgb8, key, levels=levels)
    return FileRecord.of(path, key)


def frame_levels(
    builder: ShotBuilder, outputs: Outputs, frames: Sequence[int]
) -> list[PictureLevels]:
    """Return the levels of frames that are written.

    Raises:
        RenderError: a file cannot be read.
    """
    files = [outputs.frame(frame, builder.film.format) for frame in frames]
    return [read_levels(file) or _measured(file) for file in files]


def _measured(path: Path) -> PictureLevels:
    """Return the levels of a frame that was written without them."""
    if path.suffix == ".exr":
        return PictureLevels.of(read_exr(path), read_development(path))
    return PictureLevels.of_srgb8(read_png(path))
