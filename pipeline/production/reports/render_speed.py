"""Speed report: seconds a frame of a scene by preset, and what a whole film would take."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

from pipeline.production.reports.stills import spread
from pipeline.production.run.interrupts import held_back
from pipeline.production.run.order import Order
from pipeline.production.run.production import take_of, working
from pipeline.production.run.progress import Reporter, stage, step
from pipeline.production.shots.shot_builder import Shooting
from render.backend import choose
from render.config import FullFilm
from render.renderer import Renderer, Timings


@dataclass(frozen=True, slots=True)
class Speed:
    """How quickly one preset is rendered.

    Attributes:
        preset: its name.
        width, height: of a frame [pixels].
        samples: rays through each pixel.
        moments: of a blurred frame.
        first: seconds until the first frame, with compiling and building.
        frame: seconds of each frame after that.
        tracing, denoising, moving: shares of that, 0 to 1.
        film: seconds of the whole film.
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
    """Render some frames of a scene with each preset; nothing of it is kept.

    Args:
        order: the scene; what its film says beside the preset holds for all of them.
        presets: to measure.
        frames: how many after the first, spread over the film.
        reporter: told how far it is.

    Raises:
        PronkError: if one cannot be rendered.
    """
    found = []
    with working(order, reporter) as run:
        take = take_of(run)
        with held_back():
            renderer = Renderer(choose(order.backend))
        for preset in presets:
            film = order.scene.film.model_copy(update={"preset": preset})
            shooting = Shooting(order.scene.model_copy(update={"film": film}), take)
            with stage(reporter, f"bench {preset}", frames + 1) as current:
                seconds = list[float]()
                for done, frame in enumerate(spread(order.scene.n_frames, frames + 1)):
                    began = time.perf_counter()
                    with held_back():
                        picture = renderer.render(shooting.shot(frame))
                        if shooting.film.format == "png":
                            _ = picture.srgb8
                    seconds.append(time.perf_counter() - began)
                    if done == 0:
                        renderer.timings = Timings()
                    step(reporter, current, done + 1)
                speed = _speed(
                    preset, film.resolved(), seconds, renderer.timings, order.scene.n_frames
                )
                current.result = f"{speed.frame:.2f} s a frame"
            found.append(speed)
    return found


def _speed(
    preset: str, film: FullFilm, seconds: Sequence[float], split: Timings, count: int
) -> Speed:
    # A scene of one frame has no other than its first.
    later = list(seconds[1:]) or list(seconds)
    frame = sum(later) / len(later)
    whole = max(sum(later), 1e-9)
    return Speed(
        preset=preset,
        width=film.size[0],
        height=film.size[1],
        samples=film.samples,
        moments=len(film.exposures),
        first=seconds[0],
        frame=frame,
        tracing=split.trace / whole,
        denoising=split.denoise / whole,
        moving=split.update / whole,
        film=seconds[0] + frame * (count - 1),
    )


def told(speeds: Sequence[Speed]) -> str:
    """Return a table of speeds as text."""
    head = ("preset", "size", "samples", "first", "frame", "traced", "denoised", "film")
    rows = [
        (
            speed.preset,
            f"{speed.width}x{speed.height}",
            f"{speed.samples}" + (f" in {speed.moments}" if speed.moments > 1 else ""),
            f"{speed.first:.2f} s",
            f"{speed.frame:.2f} s",
            f"{speed.tracing:.0%}",
            f"{speed.denoising:.0%}",
            clock(speed.film),
        )
        for speed in speeds
    ]
    widths = [max(len(row[i]) for row in (head, *rows)) for i in range(len(head))]
    lines = ["  ".join(f"{word:<{w}}" for word, w in zip(row, widths, strict=True)).rstrip()
             for row in (head, *rows)]  # fmt: skip
    return "\n".join(lines)


def clock(seconds: float) -> str:
    """Return a length of time as hours, minutes and seconds."""
    whole = round(seconds)
    hours, minutes = divmod(whole // 60, 60)
    return f"{hours}:{minutes:02d}:{whole % 60:02d}" if hours else f"{minutes}:{whole % 60:02d}"
