"""Axis of time, which several plots share: seconds below, frames above."""

from __future__ import annotations

from dataclasses import dataclass

import drawsvg

from pipeline.production.reports.canvas import Canvas
from pipeline.production.reports.colors import FAINT

GRID = "#d7d3c8"

SECOND, LEAST_WIDTH, MOST_WIDTH = 260, 1000, 6000
"""Width of a second, and of the whole axis at least and at most [pixels]."""

TICKS = (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500)
FRAMES = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 5000, 10000)
ROOM = 56
"""Least distance of ticks [pixels]."""


@dataclass(frozen=True, slots=True)
class Axis:
    """The axis of time: pixels of its begin, pixels a second, duration, frames a second."""

    x: float
    scale: float
    duration: float
    rate: float

    @classmethod
    def from_(cls, x: float, duration: float, rate: float) -> Axis:
        """Return the axis of a film that begins at `x`, as wide as reads well."""
        length = min(max(SECOND * duration, LEAST_WIDTH), MOST_WIDTH)
        return cls(x, length / duration, duration, rate)

    @property
    def length(self) -> float:
        """Width of the whole [pixels]."""
        return self.scale * self.duration

    def at(self, time: float) -> float:
        """Return where a time stands."""
        return self.x + self.scale * time


def draw_seconds(canvas: Canvas, axis: Axis, top: float, bottom: float) -> None:
    """Draw lines at whole parts of a second, told below `bottom`."""
    step = next((s for s in TICKS if s * axis.scale >= ROOM), TICKS[-1])
    for i in range(int(axis.duration / step + 1e-9) + 1):
        x = axis.at(i * step)
        canvas.draw(drawsvg.Line(x, top, x, bottom + 5, stroke=GRID, stroke_width=1))
        canvas.say(f"{i * step:g} s", (x, bottom + 22), 12, FAINT, "middle")


def draw_frames(canvas: Canvas, axis: Axis, top: float) -> None:
    """Draw ticks at frames, told above `top`."""
    every = next((n for n in FRAMES if n * axis.scale / axis.rate >= ROOM), FRAMES[-1])
    last = round(axis.duration * axis.rate)
    for frame in (1, *range(every, last + 1, every)):
        x = axis.at((frame - 1) / axis.rate)
        canvas.draw(drawsvg.Line(x, top - 6, x, top, stroke=FAINT, stroke_width=1))
        if frame == 1 or frame > every / 2:
            text, anchor = ("frame 1", "start") if frame == 1 else (f"{frame}", "middle")
            canvas.say(text, (x, top - 11), 12, FAINT, anchor)
