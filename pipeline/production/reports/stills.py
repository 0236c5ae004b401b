"""Stills: single frames, contact sheets and thumbnails of a film."""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from pipeline.errors import UsageError
from pipeline.production.run.exposure_stage import expose
from pipeline.production.run.frame_ranges import counted
from pipeline.production.run.frame_stage import early_shooting_of, note_levels, shooting_of
from pipeline.production.run.interrupts import held_back
from pipeline.production.run.order import Order
from pipeline.production.run.progress import Reporter, stage
from pipeline.production.run.scene_run import SceneRun, working
from pipeline.production.run.workers import with_gpu_fallback
from pipeline.production.shots.frame_rendering import outdated_frames, write_frame
from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.simulation.take import Take
from render.backend import Backend, choose
from render.config import Film
from render.image_files import read_png, write_png
from render.renderer import Renderer

GAP = 6
"""Between the pictures of a sheet [pixels]."""

PAPER = 24
"""Grey level of a sheet between its pictures."""

THUMBNAIL_SCALE = 1.5
"""Pixels of a thumbnail per pixel of a plot, whose PNG is enlarged as much."""


def still(order: Order, number: int, reporter: Reporter, *, early: bool = False) -> Path:
    """Render one frame into the outputs and return its file.

    Args:
        order: settings of the run.
        number: of the frame, 1-based.
        reporter: of progress.
        early: whether to simulate only as much of the film as the frame needs to be looked at;
            otherwise it is as in the film.

    Raises:
        UsageError: the scene has no such frame.
        PronkError: it cannot be made.
    """
    last = order.scene.n_frames
    if not 1 <= number <= last:
        raise UsageError(f"frame {number}: the scene has frames 1-{last}")
    with working(order, reporter) as run:
        shooting = early_shooting_of(run, number) if early else shooting_of(run)
        return _stills(run, [number], shooting)[0]


def sheet(order: Order, count: int, columns: int, reporter: Reporter) -> Path:
    """Render `count` frames spread evenly over the film onto one sheet, and return its file.

    Raises:
        PronkError: it cannot be made.
    """
    if order.scene.film.resolved().format != "png":
        raise UsageError("a sheet is made of PNG frames; take film.format=exr away")
    frames = spread(order.scene.n_frames, count)
    with working(order, reporter) as run:
        files = _stills(run, frames, shooting_of(run))
        place = run.outputs.folder / f"{order.name}_sheet.png"
        picture = laid_out([read_png(file) for file in files], columns)
        write_png(place, picture, "sheet")
        run.records.update(place)
        return place


def spread(last: int, count: int) -> list[int]:
    """Return at most `count` frames spread evenly from 1 to `last`."""
    count = min(count, last)
    return sorted({1 + round(i * (last - 1) / max(count - 1, 1)) for i in range(count)})


def laid_out(pictures: Sequence[NDArray[np.uint8]], columns: int) -> NDArray[np.uint8]:
    """Return a sheet with `pictures` (H, W, 3), all of one size, row by row."""
    height, width, _ = pictures[0].shape
    columns = min(columns, len(pictures))
    rows = math.ceil(len(pictures) / columns)
    size = (rows * (height + GAP) + GAP, columns * (width + GAP) + GAP, 3)
    paper = np.full(size, PAPER, dtype=np.uint8)
    for i, picture in enumerate(pictures):
        row, column = divmod(i, columns)
        y, x = GAP + row * (height + GAP), GAP + column * (width + GAP)
        paper[y : y + height, x : x + width] = picture
    return paper


def _stills(run: SceneRun, frames: Sequence[int], shooting: ShotBuilder) -> list[Path]:
    """Render those of `frames` that are due, and return the files of all."""
    run.frames = tuple(frames)
    files = {f: run.outputs.frame(f, shooting.film.format) for f in frames}
    unit = "frame" if len(frames) == 1 else "frames"
    with stage(run.reporter, "render", len(frames), unit) as current:

        def rendered(backend: Backend) -> None:
            with held_back():
                renderer = Renderer(backend)
            expose(run, shooting, renderer)
            keys, missing = outdated_frames(
                shooting, run.outputs, run.records, frames, renderer.key_extra
            )
            kept = len(frames) - len(missing)
            current.keep(kept)
            for i, frame in enumerate(missing, start=1):
                with held_back():
                    picture = renderer.render(shooting.shot(frame))
                run.records.put(files[frame], write_frame(files[frame], picture, keys[frame]))
                current.advance(kept + i)
            current.result = counted(len(missing)) + (f", {kept} kept" if kept else "")

        with_gpu_fallback(run.order.backend, run.reporter, rendered)
    note_levels(run, shooting, frames)
    return list(files.values())


def thumbnails(run: SceneRun, take: Take, frames: Sequence[int], height: int) -> list[bytes]:
    """Return frames as small PNG pictures: rendered ones are shrunk, the others rendered small.

    Args:
        run: of the scene.
        take: of the scene.
        frames: 1-based.
        height: of the pictures in a plot [pixels].

    Raises:
        RenderError: a picture cannot be rendered or read.
    """
    scene = run.order.scene
    width, full_height = scene.film.resolved().size
    size = _even(THUMBNAIL_SCALE * height * width / full_height), _even(THUMBNAIL_SCALE * height)
    shooting = ShotBuilder(scene, take)
    small = Film(preset="draft", size=size, exposure=scene.film.exposure, look=scene.film.look)
    quick = ShotBuilder(shooting.scene.model_copy(update={"film": small}), take)
    pictures: list[bytes] = []
    with stage(run.reporter, "thumbnails", len(frames)) as current:
        with held_back():
            renderer = Renderer(choose(run.order.backend))
        expose(run, shooting, renderer)
        quick.set_tones(shooting.tracks.tones)
        _, missing = outdated_frames(shooting, run.outputs, run.records, frames, renderer.key_extra)
        for done, frame in enumerate(frames, start=1):
            if frame in missing or shooting.film.format != "png":
                with held_back():
                    picture = renderer.render(quick.shot(frame)).srgb8
            else:
                picture = read_png(run.outputs.frame(frame))
            out = io.BytesIO()
            Image.fromarray(picture).resize(size, Image.Resampling.LANCZOS).save(out, "PNG")
            pictures.append(out.getvalue())
            current.advance(done)
        kept = len(frames) - len(missing)
        current.result = f"{len(missing)} rendered small" + (f", {kept} kept" if kept else "")
    return pictures


def _even(pixels: float) -> int:
    return max(2 * round(pixels / 2), 2)
