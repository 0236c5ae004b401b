"""Time axis shared by the plots: seconds below, frames above."""

from __future__ import annotations

from dataclasses import dataclass

import drawsvg

from pipeline.production.reports.canvas import Canvas
from pipeline.production.reports.plot_colors import FAINT, GRID

PIXELS_PER_SECOND, MIN_LENGTH, MAX_LENGTH = 260, 1000, 6000
"""Scale of an axis, and the bounds of its length [pixels]."""

TICK_SECONDS = (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500)
TICK_FRAMES = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 5000, 10000)
MIN_TICK_DISTANCE = 56
"""[pixels]"""


@dataclass(frozen=True, slots=True)
class Axis:
    """Time axis of a film: left end [pixels], pixels per second, duration [s], frame rate [1/s]."""

    x: float
    scale: float
    duration: float
    rate: float

    @classmethod
    def fitted(cls, x: float, duration: float, rate: float) -> Axis:
        """Return the axis of a film, as long as reads well."""
        length = min(max(PIXELS_PER_SECOND * duration, MIN_LENGTH), MAX_LENGTH)
        return cls(x, length / duration, duration, rate)

    @property
    def length(self) -> float:
        """Width of the whole axis [pixels]."""
        return self.scale * self.duration

    def at(self, time: float) -> float:
        """Return the x of a time [pixels]."""
        return self.x + self.scale * time


def draw_seconds(canvas: Canvas, axis: Axis, top: float, bottom: float) -> None:
    """Draw lines at round times from `top` to `bottom`, labelled below."""
    step = next((s for s in TICK_SECONDS if s * axis.scale >= MIN_TICK_DISTANCE), TICK_SECONDS[-1])
    for i in range(int(axis.duration / step + 1e-9) + 1):
        x = axis.at(i * step)
        canvas.draw(drawsvg.Line(x, top, x, bottom + 5, stroke=GRID, stroke_width=1))
        canvas.text(f"{i * step:g} s", (x, bottom + 22), 12, FAINT, "middle")


def draw_frames(canvas: Canvas, axis: Axis, top: float) -> None:
    """Draw ticks at round frames, labelled above `top`."""
    every = next(
        (n for n in TICK_FRAMES if n * axis.scale / axis.rate >= MIN_TICK_DISTANCE),
        TICK_FRAMES[-1],
    )
    last = round(axis.duration * axis.rate)
    for frame in (1, *range(every, last + 1, every)):
        x = axis.at((frame - 1) / axis.rate)
        canvas.draw(drawsvg.Line(x, top - 6, x, top, stroke=FAINT, stroke_width=1))
        if frame == 1 or frame > every / 2:
            text, anchor = ("frame 1", "start") if frame == 1 else (f"{frame}", "middle")
            canvas.text(text, (x, top - 11), 12, FAINT, anchor)
