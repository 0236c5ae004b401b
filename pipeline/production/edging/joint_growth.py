"""Joint growth: moss, grass and weeds in the joints of paving, more of them towards its border."""

from __future__ import annotations

import numpy as np

from pipeline.production.edging.border import Border
from pipeline.production.edging.floor_plan import FloorPlan
from pipeline.production.surroundings.lattice_noise import fractal, smoothstep

PER_METRE = 9.0
"""Plants on a metre of overgrown joint."""

GROWTH = (("moss cushion", 0.55, 0.22), ("short grass", 0.35, 0.55), ("daisy", 0.05, 0.5), ("sedge", 0.05, 0.7))
"""Species with their shares and sizes."""

UNTRODDEN = 0.25
"""Distance from the cast within which nothing grows [m]."""

LEAST_JOINT = 0.75
"""Side of slabs from which the joints are wide enough to see each plant [m]."""


def grow_in_joints(border: Border, plan: FloorPlan) -> None:
    """Add plants in the joints of a paved floor."""
    rng = np.random.default_rng([border.seed, 461])
    length = (plan.high - plan.low).prod() / max(plan.piece, LEAST_JOINT) * 2.0
    count = min(int(PER_METRE * length), 9000)
    places = rng.uniform(plan.low, plan.high, (count, 2))
    axis = rng.integers(0, 2, count)
    lines = np.rint(places / plan.piece) * plan.piece + rng.normal(0.0, 0.012, (count, 2))
    places = np.where(np.arange(2) == axis[:, None], lines, places)
    out = -plan.beyond(places)
    thick = smoothstep(-0.25, 0.5, fractal(places / 1.9, border.seed + 462, 3))
    wanted = (0.08 + 0.9 * (1.0 - smoothstep(0.3, 3.6, out))) * thick
    wanted = wanted * smoothstep(UNTRODDEN, 1.6, plan.free(places))
    kept = (rng.uniform(size=count) < wanted) & (out > 0.1) & plan.has_piece(places)
    places = places[kept]
    shares = np.array([share for _, share, _ in GROWTH])
    kinds = rng.choice(len(GROWTH), len(places), p=shares / shares.sum())
    for k, (kind, _, size) in enumerate(GROWTH):
        some = places[kinds == k]
        if len(some):
            points = np.stack([some[:, 0], np.full(len(some), plan.height - 0.012), some[:, 1]], -1)
            border.add_plants(kind, points, size, rng)
