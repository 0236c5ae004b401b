"""Chunk plan: how many frames a task has, by what the frames of its film have cost so far.

A worker that begins a film loads its take and builds its scene first. Chunks are long enough for
that to be a small part of their time, and become smaller towards the end of a film, so that all
workers end at about the same time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from pipeline.farm.frame_worker import ChunkCost

TARGET_SECONDS = 60.0
"""Time that a chunk should take: what is lost with a machine, and told of progress [s]."""

MAX_OVERHEAD = 0.1
"""Part of a chunk's time that loading and building may take."""

FIRST_CHUNK = 4
"""Frames of the chunks before anything is measured."""

SHARES = 2
"""Chunks that each worker still gets of what remains."""

MAX_CHUNK = 512
"""Most frames of a chunk."""


@dataclass(slots=True)
class FilmCosts:
    """What the frames of a film have cost.

    Attributes:
        frames: number of frames that were measured without a build.
        seconds: that they took [s].
        builds: number of loads and builds.
        overhead: time of these [s].
    """

    frames: int = 0
    seconds: float = 0.0
    builds: int = 0
    overhead: float = 0.0

    def add(self, cost: ChunkCost) -> None:
        """Add what a chunk has cost."""
        built = 1 if cost.first > 0.0 else 0
        self.frames += max(cost.rendered - built, 0)
        self.seconds += cost.frames
        if built:
            self.builds += 1
            self.overhead += cost.load + cost.first

    @property
    def per_frame(self) -> float | None:
        """Time of a frame without a build [s], None before one is measured."""
        return self.seconds / self.frames if self.frames else None

    @property
    def per_build(self) -> float:
        """Time that loading and building take beside the first frame [s]."""
        if not self.builds:
            return 0.0
        return max(self.overhead / self.builds - (self.per_frame or 0.0), 0.0)

    def expected(self, frames: int) -> float | None:
        """Return the time of a chunk with its load and build [s], None before it is known."""
        if self.per_frame is None:
            return None
        return self.per_build + frames * self.per_frame


def chunk_size(remaining: int, workers: int, costs: FilmCosts) -> int:
    """Return the number of frames of the next chunk of a film.

    Args:
        remaining: frames that no task has.
        workers: number of workers that the film can have.
        costs: of its frames so far.
    """
    share = math.ceil(remaining / (SHARES * max(workers, 1)))
    if costs.per_frame is None:
        return max(min(share, FIRST_CHUNK, remaining), 1)
    paid = costs.per_build * (1.0 - MAX_OVERHEAD) / MAX_OVERHEAD
    wanted = math.ceil(max(TARGET_SECONDS, paid) / max(costs.per_frame, 1e-6))
    return max(min(share, wanted, remaining, MAX_CHUNK), 1)
