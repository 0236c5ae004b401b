"""Clock: the grid of steps, rows and frames.

The integer step is exact. A frame is `steps` steps, a row of the take is `steps / samples` of
them. Row 0 is frame 1, and S rows follow the last frame's, for a shutter that opens in the last
frame.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property


@dataclass(frozen=True)
class Clock:
    """The grid of one simulation.

    Attributes:
        rate: frames per second.
        frames: frames of the film.
        steps: world steps per frame.
        samples: rows of the take per frame; divides `steps`.
    """

    rate: Fraction
    frames: int
    steps: int = 4
    samples: int = 4

    @cached_property
    def dt(self) -> float:
        """Duration of a step [s]."""
        return float(1 / (self.rate * self.steps))

    @property
    def last_step(self) -> int:
        """Step of the last row."""
        return self.frames * self.steps

    @property
    def row_time(self) -> float:
        """Time between rows of the take [s]."""
        return float(self.dt) * self.steps / self.samples

    @property
    def rows(self) -> int:
        """Number of rows of the take."""
        return self.frames * self.samples + 1

    def row_of_step(self, step: int) -> int | None:
        """Returns the row at `step`, None between rows."""
        row, rest = divmod(step * self.samples, self.steps)
        return row if rest == 0 else None

    def step_of_row(self, row: int) -> int:
        """Returns the step of a row."""
        return row * self.steps // self.samples

    def row_of_frame(self, frame: int) -> int:
        """Returns the row that the 1-based `frame` shows."""
        return (frame - 1) * self.samples

    def frame_of(self, step: int, fraction: float) -> int:
        """Returns the first frame that shows a moment, `fraction` of a step after `step`.

        May be one more than `frames`: what happens after the last frame is not shown.
        """
        whole, rest = divmod(step, self.steps)
        return 1 + whole + (1 if rest > 0 or fraction > 0.0 else 0)

    def time_of(self, step: int, fraction: float = 0.0) -> Fraction:
        """Returns the exact time [s] of a moment."""
        return (step + Fraction(fraction)) / (self.rate * self.steps)

    def step_from(self, time: float) -> int:
        """Returns the first step that is not before `time` [s]."""
        return math.ceil(time * float(self.rate * self.steps) - 1e-9)

    def step_at(self, time: float) -> int:
        """Returns the last step that is not after `time` [s]."""
        return math.floor(time * float(self.rate * self.steps) + 1e-9)
