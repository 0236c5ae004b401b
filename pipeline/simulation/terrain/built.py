"""Ground as builders make it, all of it the same along z: stairs, ramps, ditches.

Heights are those of the edges' upper and lower ends at the vertices, so what should be a
wall takes the one cell in which it stands.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain.heightfield import HeightField
from pipeline.spec.terrain import DitchesTerrain, Grid, RampTerrain, StairsTerrain

ON_EDGE = 1e-9
"""Vertices this near to an edge lie on it, in its own lengths: rounding is not to decide."""


def stairs(words: StairsTerrain, chance: np.random.Generator) -> HeightField:
    """Return stairs whose tread k, counted from 1, is level at k times the step height."""
    del chance

    def climbed(run: Array) -> Array:
        risers = np.clip(np.floor(run / words.step_depth + ON_EDGE) + 1.0, 0.0, words.steps)
        return words.step_height * risers

    flight = (words.steps - 1) * words.step_depth
    return _along_x(words, _course(words, climbed, flight, words.landing))


def ramp(words: RampTerrain, chance: np.random.Generator) -> HeightField:
    """Return a ramp; its slope is exact in all cells that lie wholly on it."""
    del chance
    rise = math.tan(math.radians(words.slope_deg))

    def climbed(run: Array) -> Array:
        return np.clip(run * rise, 0.0, words.height)

    return _along_x(words, _course(words, climbed, words.height / rise, words.level))


def ditches(words: DitchesTerrain, chance: np.random.Generator) -> HeightField:
    """Return level ground with ditches; their floors are level."""
    end = words.size[0] / 2.0
    n = max(math.floor((end - words.start) / words.spacing + ON_EDGE), 0)
    # Each thing varies by a row of its own: a longer row of ditches begins like a shorter one.
    vary = words.variation * np.stack([own.random(n) for own in chance.spawn(3)])
    widths = words.width * (1.0 - 0.5 * vary[0])
    depths = words.depth * (1.0 - 0.5 * vary[1])
    # Of the ground between the widest ditches, at least half is left.
    off = 0.25 * (words.spacing - words.width) * (2.0 * vary[2] - words.variation)
    middles = words.start + (np.arange(n) + 0.5) * words.spacing + off
    x = _columns(words)
    heights = np.zeros_like(x)
    for middle, width, depth in zip(middles, widths, depths, strict=True):
        heights[np.abs(x - middle) < (0.5 + ON_EDGE) * width] = -depth
    return _along_x(words, heights)


def _columns(words: Grid) -> Array:
    """Return the places (n_x + 1,) of the grid's vertices along x [m]."""
    half = words.size[0] / 2.0
    return np.linspace(-half, half, words.cells[0] + 1)


def _course(
    words: StairsTerrain | RampTerrain,
    climbed: Callable[[Array], Array],
    length: float,
    top: float,
) -> Array:
    """Return the heights (n_x + 1,) of what leads up, down, or up and down again.

    Args:
        words: the terrain.
        climbed: run from where it begins -> height [m].
        length: of the climb [m].
        top: from the end of the climb to where it leads down again [m].
    """
    run = _columns(words) - words.start
    match words.course:
        case "up":
            return climbed(run)
        case "down":
            return -climbed(run)
        case "up and down":
            return np.minimum(climbed(run), climbed(2.0 * length + top - run))


def _along_x(words: Grid, heights: Array) -> HeightField:
    """Return the field that has these heights (n_x + 1,) all along z."""
    return HeightField(np.tile(heights, (words.cells[1] + 1, 1)), words.size)
