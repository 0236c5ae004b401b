"""Birch bark: white, with short dark slits, dark scars at branches and a rough dark foot."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.production.scenery.branches import Skeleton
from pipeline.production.scenery.prototype import Color, Shape, across, mixed
from pipeline.production.surroundings.lattice_noise import smoothstep
from pipeline.simulation.spatial import Array

TWIG, FISSURE, SLIT = (0.105, 0.072, 0.055), (0.075, 0.062, 0.052), (0.10, 0.082, 0.070)
"""Linear colours of thin twigs, of the cracked foot and of marks on the bark."""

WHITE_FROM = (0.16, 0.34)
"""Radii relative to the foot between which brown twigs turn to white branches."""

ROUGH_UP_TO = (0.2, 0.85)
"""Heights between which the dark foot ends [m]."""

MARKED = 0.36
"""Radius relative to the foot from which branches carry marks."""

OVER = 1.035
"""Radius of marks relative to that of the trunk, so that none sinks into its flat sides."""

SLITS = (7, 4)
"""Number of slits on each piece of a trunk by level of detail; none farther away."""


def bark_colors(skeleton: Skeleton, foot: float, white: Color, rng: np.random.Generator) -> Array:
    """Return the colours (N, 3) of the nodes of a birch whose trunk has a radius at its foot."""
    share = smoothstep(*WHITE_FROM, skeleton.radii / foot)
    color = mixed(TWIG, white, share) * rng.uniform(0.92, 1.06, (len(share), 1))
    height = skeleton.nodes[:, 1] + rng.normal(0.0, 0.06, len(share))
    rough = (1.0 - smoothstep(*ROUGH_UP_TO, height)) * share
    return mixed(color, FISSURE, 0.8 * rough)


def add_marks(
    shape: Shape, skeleton: Skeleton, foot: float, level: int, rng: np.random.Generator
) -> None:
    """Add slits that go a short way round the trunk, and scars above its branches."""
    if level >= len(SLITS):
        return
    thick = (skeleton.parents >= 0) & (skeleton.radii > MARKED * foot)
    pieces = np.flatnonzero(thick & (skeleton.parents[skeleton.parents] >= 0))
    if not len(pieces):
        return
    every = np.repeat(pieces, SLITS[level]).astype(np.int64)
    n = len(every)
    turn, part = rng.uniform(0.0, 2.0 * np.pi, n), rng.uniform(size=n)
    # Few are long, none goes round.
    half = 0.12 + 0.5 * rng.uniform(size=n) ** 3
    tall = rng.uniform(0.004, 0.011, n)
    _add_spindles(shape, skeleton, every, part, turn, half, tall)
    # A branch leaves a dark scar like a chevron where it comes out of the trunk.
    above = skeleton.parents[pieces]
    sides = np.flatnonzero(
        (skeleton.parents >= 0)
        & np.isin(skeleton.parents, above)
        & (skeleton.radii < 0.8 * skeleton.radii[np.maximum(skeleton.parents, 0)])
    )
    carriers = skeleton.parents[sides]
    sides = sides[skeleton.parents[carriers] >= 0]
    carriers = skeleton.parents[sides]
    if not len(sides):
        return
    u, w = across(skeleton.ways[carriers])
    way = skeleton.ways[sides]
    facing = np.arctan2((way * w).sum(axis=1), (way * u).sum(axis=1))
    m = len(sides)
    _add_spindles(
        *(shape, skeleton, carriers, np.full(m, 0.92), facing),
        *(rng.uniform(0.45, 0.75, m), rng.uniform(0.03, 0.07, m)),
    )


def _add_spindles(
    shape: Shape,
    skeleton: Skeleton,
    pieces: NDArray[np.int64],
    part: Array,
    turn: Array,
    half: Array,
    tall: Array,
) -> None:
    """Add N marks that taper to both sides.

    Args:
        shape: to which they are added.
        skeleton: of the tree.
        pieces: (N,) numbers of the nodes at the ends of the pieces of trunk.
        part: (N,) of the way along them.
        turn: (N,) round them [rad].
        half: (N,) half the width [rad].
        tall: (N,) half the height [m].
    """
    above = skeleton.parents[pieces]
    start, end = skeleton.nodes[above], skeleton.nodes[pieces]
    middle = start + part[:, None] * (end - start)
    radius = skeleton.radii[above] + part * (skeleton.radii[pieces] - skeleton.radii[above])
    way = skeleton.ways[pieces]
    u, w = across(way)

    def out(angle: Array) -> Array:
        return np.cos(angle)[:, None] * u + np.sin(angle)[:, None] * w

    normals = np.stack([out(turn - half), out(turn), out(turn + half), out(turn)], axis=1)
    rim = middle[:, None] + (OVER * radius)[:, None, None] * normals
    rise = tall[:, None] * np.array([0.0, 1.0, 0.0, -1.0])
    corners = rim + rise[..., None] * way[:, None]
    faces = np.array([[0, 3, 1], [1, 3, 2]])[None] + 4 * np.arange(len(corners))[:, None, None]
    shape.add(corners, normals, np.asarray(SLIT), faces, thin=False)
