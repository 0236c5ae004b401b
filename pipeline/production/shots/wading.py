"""Wading: who goes through the surface of the water, which holds nobody up and slows nobody."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.production.shots.skinning import Skin, visible_parts
from pipeline.simulation.clock import Clock
from pipeline.simulation.take import Take

SAMPLE_INTERVAL_S = 0.25
"""Time between the frames that are looked at [s]."""

MAX_SAMPLES = 200
"""Frames of a film that are looked at."""

LEAST_DEPTH = 0.02
"""Depth from which something is in the water [m]."""


@dataclass(frozen=True, slots=True)
class Wading:
    """A performer that is partly under water.

    Attributes:
        performer: its name.
        frame: the first that was found.
        depth: of its lowest point at its deepest [m].
    """

    performer: str
    frame: int
    depth: float


def waders(take: Take, skin: Skin, clock: Clock, level: float) -> list[Wading]:
    """Return who is partly under water at some time, in the order of the parts of the take.

    Args:
        take: of the film.
        skin: of the take.
        clock: of the film.
        level: height of the water [m].
    """
    parts = visible_parts(take)
    found: dict[str, Wading] = {}
    step = max(round(SAMPLE_INTERVAL_S * float(clock.rate)), -(-clock.frames // MAX_SAMPLES), 1)
    for frame in range(1, clock.frames + 1, step):
        row = clock.row_of_frame(frame)
        height = skin.posed(take, row)[:, 1] - level
        ranges: dict[str, tuple[float, float]] = {}
        for part, first, end in zip(parts, skin.starts, skin.starts[1:], strict=False):
            if end > first and part.life[0] <= row < part.life[1]:
                low, high = ranges.get(part.performer, (np.inf, -np.inf))
                own = height[first:end]
                ranges[part.performer] = min(low, own.min()), max(high, own.max())
        for performer, (low, high) in ranges.items():
            if low < -LEAST_DEPTH and high > 0.0:
                known = found.get(performer, Wading(performer, frame, 0.0))
                depth = max(known.depth, round(float(-low), 2))
                found[performer] = Wading(performer, known.frame, depth)
    return list(found.values())
