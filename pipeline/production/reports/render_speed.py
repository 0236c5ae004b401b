"""Render speed: seconds per frame of a scene by preset, and the time of the whole film."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

from pipeline.production.reports.stills import spread
from pipeline.production.run.interrupts import held_back
from pipeline.production.run.order import Order
from pipeline.production.run.progress import Reporter, stage
from pipeline.production.run.quantities import duration_text
from pipeline.production.run.scene_run import working
from pipeline.production.run.take_stage import take_of
from pipeline.production.shots.shot_builder import ShotBuilder
from render.backend import choose
from render.config import FullFilm
from render.renderer import Renderer, Timings


@dataclass(frozen=True, slots=True)
class Speed:
    """Render speed of one preset.

    Attributes:
        preset: its name.
        width, height: of a frame [pixels].
        samples: rays per pixel.
        moments: exposures of a blurred frame.
        first: time until the first frame, with compiling and building [s].
        frame: time of each frame after that [s].
        tracing, denoising, moving: shares of that, 0 to 1.
        film: time of the whole film [s].
    """

    preset: str
    width: int
    height: int
    samples: int
    moments: int
    first: float
    frame: float
    tracing: float
    denoising: float
    moving: float
    film: float


def measure(order: Order, presets: Sequence[str], frames: int, reporter: Reporter) -> list[Speed]:
    """Render some frames of a scene with each preset, keeping none.

    Args:
        order: the scene; settings of its film beside the preset hold for all of them.
        presets: to measure.
        frames: number of frames after the first, spread over the film.
        reporter: of progress.

    Raises:
        PronkError: a frame cannot be rendered.
    """
    found = []
    with working(order, reporter) as run:
        take = take_of(run)
        with held_back():
            renderer = Renderer(choose(order.backend))
        for preset in presets:
            film = order.scene.film.model_copy(update={"preset": preset})
            shooting = ShotBuilder(order.scene.model_copy(update={"film": film}), take)
            with stage(reporter, f"bench {preset}", frames + 1) as current:
                seconds = list[float]()
                for done, frame in enumerate(spread(order.scene.n_frames, frames + 1), start=1):
                    began = time.perf_counter()
                    with held_back():
                        picture = renderer.render(shooting.shot(frame))
                        if shooting.film.format == "png":
                            _ = picture.srgb8
                    seconds.append(time.perf_counter() - began)
                    if done == 1:
                        renderer.timings = Timings()
                    current.advance(done)
                split, count = renderer.timings, order.scene.n_frames
                found.append(_speed(preset, film.resolved(), seconds, split, count))
                current.result = f"{found[-1].frame:.2f} s a frame"
    return found


def _speed(
    preset: str, film: FullFilm, seconds: Sequence[float], split: Timings, count: int
) -> Speed:
    # A scene of one frame has only its first.
    later = list(seconds[1:]) or list(seconds)
    frame = sum(later) / len(later)
    total = max(sum(later), 1e-9)
    return Speed(
        preset=preset,
        width=film.size[0],
        height=film.size[1],
        samples=film.samples,
        moments=len(film.exposures),
        first=seconds[0],
        frame=frame,
        tracing=split.trace / total,
        denoising=split.denoise / total,
        moving=split.update / total,
        film=seconds[0] + frame * (count - 1),
    )


def table(speeds: Sequence[Speed]) -> str:
    """Return a table of speeds."""
    rows = [("preset", "size", "samples", "first", "frame", "traced", "denoised", "film")]
    rows += [
        (
            speed.preset,
            f"{speed.width}x{speed.height}",
            f"{speed.samples}" + (f" in {speed.moments}" if speed.moments > 1 else ""),
            f"{speed.first:.2f} s",
            f"{speed.frame:.2f} s",
            f"{speed.tracing:.0%}",
            f"{speed.denoising:.0%}",
            duration_text(speed.film),
        )
        for speed in speeds
    ]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return "\n".join(
        "  ".join(f"{cell:<{w}}" for cell, w in zip(row, widths, strict=True)).rstrip()
        for row in rows
    )
