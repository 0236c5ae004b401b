"""Constructed terrains: stairs, ramps, ditches and stepping stones.

Heights are those of the edges' upper and lower ends at the vertices, so what should be a
wall takes the one cell in which it stands.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain.generators import generates
from pipeline.simulation.terrain.heightfield import HeightField
from pipeline.spec.terrain.base import GridTerrain
from pipeline.spec.terrain.kinds import (
    IRREGULAR,
    DitchesTerrain,
    RampTerrain,
    StairsTerrain,
    StonesTerrain,
)

EDGE_TOLERANCE = 1e-9
"""Vertices this near to an edge, in lengths of the feature, lie on it in spite of rounding."""


@generates(StairsTerrain)
def stairs(terrain: StairsTerrain, rng: np.random.Generator) -> HeightField:
    """Return stairs whose tread k, counted from 1, is level at k times the step height."""
    del rng

    def climbed(run: Array) -> Array:
        risers = np.clip(
            np.floor(run / terrain.step_depth + EDGE_TOLERANCE) + 1.0, 0.0, terrain.steps
        )
        return terrain.step_height * risers

    flight = (terrain.steps - 1) * terrain.step_depth
    return _along_x(terrain, _course(terrain, climbed, flight, terrain.landing))


@generates(RampTerrain)
def ramp(terrain: RampTerrain, rng: np.random.Generator) -> HeightField:
    """Return a ramp; its slope is exact in all cells that lie wholly on it."""
    del rng
    rise = math.tan(math.radians(terrain.slope_deg))

    def climbed(run: Array) -> Array:
        return np.clip(run * rise, 0.0, terrain.height)

    return _along_x(terrain, _course(terrain, climbed, terrain.height / rise, terrain.level))


@generates(DitchesTerrain)
def ditches(terrain: DitchesTerrain, rng: np.random.Generator) -> HeightField:
    """Return level ground with ditches; their floors are level."""
    end = terrain.size[0] / 2.0
    n = max(math.floor((end - terrain.start) / terrain.spacing + EDGE_TOLERANCE), 0)
    # Each thing varies by a row of its own: a longer row of ditches begins like a shorter one.
    vary = terrain.variation * np.stack([own.random(n) for own in rng.spawn(3)])
    widths = terrain.width * (1.0 - 0.5 * vary[0])
    depths = terrain.depth * (1.0 - 0.5 * vary[1])
    # Of the ground between the widest ditches, at least half is left.
    off = 0.25 * (terrain.spacing - terrain.width) * (2.0 * vary[2] - terrain.variation)
    middles = terrain.start + (np.arange(n) + 0.5) * terrain.spacing + off
    x = _columns(terrain)
    heights = np.zeros_like(x)
    for middle, width, depth in zip(middles, widths, depths, strict=True):
        heights[np.abs(x - middle) < (0.5 + EDGE_TOLERANCE) * width] = -depth
    return _along_x(terrain, heights)


def _columns(terrain: GridTerrain) -> Array:
    """Return the places (n_x + 1,) of the grid's vertices along x [m]."""
    half = terrain.size[0] / 2.0
    return np.linspace(-half, half, terrain.cells[0] + 1)


def _course(
    terrain: StairsTerrain | RampTerrain,
    climbed: Callable[[Array], Array],
    length: float,
    top: float,
) -> Array:
    """Return the heights (n_x + 1,) of a course up, down, or up and down again.

    Args:
        terrain: the terrain.
        climbed: run from the start -> height [m].
        length: length of the climb [m].
        top: length of the level top [m].
    """
    run = _columns(terrain) - terrain.start
    match terrain.course:
        case "up":
            return climbed(run)
        case "down":
            return -climbed(run)
        case "up and down":
            return np.minimum(climbed(run), climbed(2.0 * length + top - run))


def _along_x(terrain: GridTerrain, heights: Array) -> HeightField:
    """Return the field that has these heights (n_x + 1,) all along z."""
    return HeightField(np.tile(heights, (terrain.cells[1] + 1, 1)), terrain.size)


@dataclass(frozen=True, eq=False)
class StoneLayout:
    """Stepping stones: n_z rows along z of n_x stones along x.

    Attributes:
        x: (n_z, n_x) x of their middles [m].
        z: (n_z, n_x) z of their middles [m].
        tops: (n_z, n_x) heights of their tops [m].
        shape: (3, n_z, n_x) size and the two turns of their outlines, each 0 to 1.
        pit: start and end of the pit along x [m].
    """

    x: Array
    z: Array
    tops: Array
    shape: Array
    pit: tuple[float, float]


def stone_layout(terrain: StonesTerrain, rng: np.random.Generator) -> StoneLayout:
    """Return the stones; one row lies along the terrain's middle."""
    pitch = terrain.diameter + terrain.gap
    n_x = max(1, round((terrain.length - terrain.gap) / pitch))
    beside = int(terrain.size[1] / (2.0 * pitch)) + 1
    n_z = 2 * beside + 1 if terrain.rows is None else min(terrain.rows, 2 * beside + 1)
    beside = n_z // 2
    off_x, off_z, off_y = rng.uniform(-0.5, 0.5, (3, n_z, n_x))
    # At most a quarter of the gap either way, so half of a gap is left between two.
    off = 0.5 * terrain.jitter * terrain.gap
    first = terrain.start + terrain.gap + 0.5 * terrain.diameter
    return StoneLayout(
        x=first + pitch * np.arange(n_x) + off * off_x,
        z=pitch * (np.arange(n_z) - beside)[:, None] + off * off_z,
        tops=terrain.height_variation * off_y,
        shape=rng.uniform(0.0, 1.0, (3, n_z, n_x)),
        pit=(terrain.start, terrain.start + n_x * pitch + terrain.gap),
    )


def _lost(angle: Array, size: Array, turn: Array, corner: Array) -> Array:
    """Return which share of a stone's radius is missing at an angle, up to `IRREGULAR`."""
    turned = 2.0 * angle + 2.0 * np.pi * turn, 3.0 * angle + 2.0 * np.pi * corner
    narrow, cornered = (0.5 - 0.5 * np.cos(part) for part in turned)
    return np.asarray(IRREGULAR * (0.3 * size + 0.45 * narrow + 0.25 * cornered))


@generates(StonesTerrain)
def stones(terrain: StonesTerrain, rng: np.random.Generator) -> HeightField:
    """Return stepping stones; their walls take one cell."""
    stand = stone_layout(terrain, rng)
    pitch = terrain.diameter + terrain.gap
    n_z, n_x = stand.x.shape
    half_x, half_z = terrain.size[0] / 2.0, terrain.size[1] / 2.0
    x = np.linspace(-half_x, half_x, terrain.cells[0] + 1)
    z = np.linspace(-half_z, half_z, terrain.cells[1] + 1)
    heights = np.zeros((len(z), len(x)))
    over = (x > stand.pit[0]) & (x < stand.pit[1])
    # A stone, moved however, keeps to its own square of a pitch: one stone a vertex to look at.
    first = terrain.start + terrain.gap + 0.5 * terrain.diameter
    i = np.clip(np.rint((x[over] - first) / pitch).astype(np.int64), 0, n_x - 1)
    j = np.clip(np.rint(z / pitch).astype(np.int64) + n_z // 2, 0, n_z - 1)
    which = np.ix_(j, i)
    to_x, to_z = x[over] - stand.x[which], z[:, None] - stand.z[which]
    widest = np.array(0.5 + EDGE_TOLERANCE)
    if terrain.irregularity:
        shape = tuple(part[which] for part in stand.shape)
        widest = widest * (1.0 - terrain.irregularity * _lost(np.arctan2(to_z, to_x), *shape))
    on_top = to_x**2 + to_z**2 <= (widest * terrain.diameter) ** 2
    heights[:, over] = np.where(on_top, stand.tops[which], -terrain.depth)
    return HeightField(heights, terrain.size)
