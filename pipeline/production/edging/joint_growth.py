"""Joint growth: moss, grass and weeds in the joints of paving, more of them towards its border."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.production.edging.border import Border
from pipeline.production.edging.floor_plan import FloorPlan
from pipeline.production.surroundings.lattice_noise import fractal, smoothstep
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain.heightfield import HeightField

PER_METRE = 20.0
"""Plants on a metre of overgrown joint."""

GROWTH = (
    ("moss cushion", 0.5, 0.55),
    ("short grass", 0.34, 0.75),
    ("daisy", 0.06, 0.6),
    ("sedge", 0.1, 0.8),
)
"""Species with their shares and sizes."""

UNTRODDEN = 0.05, 0.7
"""Distances from the cast from which something grows, and from which all does [m]."""

LEAST_JOINT = 0.75
"""Side of slabs from which the joints are wide enough to see each plant [m]."""


def grow_in_joints(border: Border, plan: FloorPlan, ground: HeightField | None = None) -> None:
    """Add plants in the joints of a paved floor.

    Args:
        border: to which they are added.
        plan: of the floor.
        ground: of a floor that is not level, None for a level one.
    """
    rng = np.random.default_rng([border.seed, 461])
    length = (plan.high - plan.low).prod() / max(plan.piece, LEAST_JOINT) * 2.0
    count = min(int(PER_METRE * length), 20_000)
    places = rng.uniform(plan.low, plan.high, (count, 2))
    # Courses run along x: their ends are at other places in each.
    courses = np.rint(places[:, 1] / plan.piece) * plan.piece
    places[:, 1] = courses + rng.normal(0.0, 0.012, count)
    out = -plan.beyond(places)
    thick = smoothstep(-0.25, 0.5, fractal(places / 1.9, border.seed + 462, 3))
    wanted = (0.3 + 0.7 * (1.0 - smoothstep(0.3, 3.6, out))) * thick
    wanted = wanted * smoothstep(*UNTRODDEN, plan.free(places))
    kept = (rng.uniform(size=count) < wanted) & (out > 0.1) & plan.has_piece(places)
    places = places[kept]
    top = np.full(len(places), plan.height)
    if ground is not None:
        top, level = _level_tops(ground, places)
        places, top = places[level], top[level]
    shares = np.array([share for _, share, _ in GROWTH])
    kinds = rng.choice(len(GROWTH), len(places), p=shares / shares.sum())
    for k, (kind, _, size) in enumerate(GROWTH):
        some = places[kinds == k]
        if len(some):
            points = np.stack([some[:, 0], top[kinds == k] - 0.012, some[:, 1]], axis=-1)
            border.add_plants(kind, points, size, rng)


def _level_tops(ground: HeightField, places: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Return the heights (N,) of the ground at places (N, 2), and where no step is near."""
    top = ground.height(*places.T)
    level = np.ones(len(places), bool)
    for way in ((0.12, 0.0), (-0.12, 0.0), (0.0, 0.12), (0.0, -0.12)):
        level &= np.abs(ground.height(*(places + way).T) - top) < 0.08
    return top, level
