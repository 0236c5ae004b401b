"""Thumbnails: small pictures of frames, for plots; nothing of a film is overwritten."""

from __future__ import annotations

import io
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from pipeline.production.run.interrupts import held_back
from pipeline.production.run.production import Production
from pipeline.production.run.progress import stage, step
from pipeline.production.shots.frame_rendering import due
from pipeline.production.shots.shot_builder import Shooting
from pipeline.simulation.take import Take
from render.backend import choose
from render.config import Film
from render.image_files import read_png
from render.renderer import Renderer

FINER = 1.5
"""Pixels of a thumbnail for each of the plot's, which are enlarged as much in its PNG."""


def thumbnails(run: Production, take: Take, frames: Sequence[int], height: int) -> list[bytes]:
    """Return frames as small PNG pictures: those that are rendered, shrunk, and the others new.

    Args:
        run: of the scene.
        take: what is filmed.
        frames: 1-based.
        height: of the pictures as the plot has them [pixels].

    Raises:
        RenderError: if one cannot be rendered or read.
    """
    scene = run.order.scene
    width, tall = scene.film.resolved().size
    size = _even(FINER * height * width / tall), _even(FINER * height)
    shooting = Shooting(scene, take)
    small = Film(preset="draft", size=size, exposure=scene.film.exposure)
    quick = Shooting(scene.model_copy(update={"film": small}), take)
    pictures: list[bytes] = []
    with stage(run.reporter, "thumbnails", len(frames)) as current:
        with held_back():
            renderer = Renderer(choose(run.order.backend))
        _, missing = due(shooting, run.outputs, frames, renderer.key_extra)
        for done, frame in enumerate(frames, start=1):
            if frame in missing or shooting.film.format != "png":
                with held_back():
                    picture = renderer.render(quick.shot(frame)).srgb8
            else:
                picture = read_png(run.outputs.frame(frame))
            pictures.append(_encoded(picture, size))
            step(run.reporter, current, done)
        kept = len(frames) - len(missing)
        current.result = f"{len(missing)} rendered small" + (f", {kept} kept" if kept else "")
    return pictures


def _even(pixels: float) -> int:
    return max(2 * round(pixels / 2), 2)


def _encoded(picture: NDArray[np.uint8], size: tuple[int, int]) -> bytes:
    out = io.BytesIO()
    Image.fromarray(picture).resize(size, Image.Resampling.LANCZOS).save(out, "PNG")
    return out.getvalue()
