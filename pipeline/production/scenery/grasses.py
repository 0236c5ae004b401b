"""Grasses, reeds and crops: clumps of blades."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.production.scenery.prototype import Color, Prototype, Shape, add_blades, add_leaves
from pipeline.simulation.spatial import Array


@dataclass(frozen=True)
class Clump:
    """A clump of blades.

    Attributes:
        blades: their number, nearby.
        height: of the tallest blades [m].
        width: of a blade [m].
        spread: radius of the clump at its foot [m].
        lean: by how much tips hang over, relative to the height.
        root: linear colour of the foot.
        tip: linear colour of the tips.
        dry: share of dry blades.
        straw: colour of dry tips.
        outward: whether blades bend away from the middle of the clump.
        ears: number of stalks with a head of seeds.
        ear: colour of the heads.
        ear_length: relative to the height.
        plump: width of the scales of a head relative to their length.
        clover: number of leaves of clover between the blades of every third clump.
        segments: of a blade, nearby.
        wave: by how much blades wind sidewards, relative to their heights.
        shortest: height of the shortest blades relative to that of the tallest.
    """

    blades: int
    height: float
    width: float
    spread: float
    lean: float
    root: Color
    tip: Color
    dry: float = 0.1
    straw: Color = (0.34, 0.27, 0.12)
    outward: bool = False
    ears: int = 0
    ear: Color = (0.3, 0.24, 0.11)
    ear_length: float = 0.2
    plump: float = 0.16
    clover: int = 0
    segments: int = 2
    wave: float = 0.0
    shortest: float = 0.3


CLUMPS: dict[str, Clump] = {
    "short grass": Clump(
        34, 0.100, 0.0052, 0.100, 0.60, (0.026, 0.046, 0.010), (0.200, 0.300, 0.066), 0.08, clover=9
    ),
    "meadow grass": Clump(
        32, 0.21, 0.0048, 0.10, 0.70, (0.026, 0.044, 0.010), (0.200, 0.290, 0.068), 0.10, ears=1
    ),
    "tall grass": Clump(
        26, 0.46, 0.0052, 0.10, 0.60, (0.028, 0.046, 0.011), (0.275, 0.285, 0.095), 0.26,
        ears=3, ear_length=0.13, plump=0.13, segments=3,
    ),
    "dry grass": Clump(
        40, 0.26, 0.0042, 0.06, 0.65, (0.150, 0.112, 0.050), (0.48, 0.375, 0.185), 0.35,
        outward=True, ears=1, ear=(0.45, 0.36, 0.20), ear_length=0.15,
    ),
    "tussock": Clump(
        80, 0.34, 0.0042, 0.07, 1.0, (0.095, 0.090, 0.036), (0.350, 0.305, 0.130), 0.35,
        outward=True, ears=2,
    ),
    "beach grass": Clump(
        30, 0.55, 0.0055, 0.09, 0.65, (0.085, 0.100, 0.042), (0.325, 0.335, 0.165), 0.25,
        straw=(0.45, 0.37, 0.21), outward=True, ears=1, ear=(0.42, 0.34, 0.18),
    ),
    "sedge": Clump(
        40, 0.13, 0.0040, 0.06, 0.85, (0.085, 0.066, 0.024), (0.270, 0.195, 0.075), 0.3,
        straw=(0.33, 0.20, 0.085), outward=True,
    ),
    "reeds": Clump(
        12, 1.5, 0.022, 0.18, 0.25, (0.075, 0.088, 0.028), (0.205, 0.240, 0.080), 0.2,
        ears=3, ear=(0.100, 0.055, 0.025), ear_length=0.12, plump=0.28,
    ),
    "water weed": Clump(
        16, 0.85, 0.026, 0.20, 0.55, (0.045, 0.075, 0.022), (0.150, 0.190, 0.050), 0.15,
        straw=(0.200, 0.140, 0.050), wave=0.11, shortest=0.12,
    ),
    "wheat": Clump(
        12, 0.72, 0.010, 0.08, 0.28, (0.20, 0.145, 0.055), (0.50, 0.370, 0.150), 0.3,
        ears=10, ear=(0.55, 0.400, 0.165), ear_length=0.14, plump=0.28,
    ),
}  # fmt: skip
"""Kinds of grass."""

LEVELS = ((1.0, 1.0), (0.6, 1.5), (0.25, 2.7))
"""Levels of detail: share of the blades, factor on their width."""

SEGMENTS_BEYOND = (1, 1)
"""Segments of a blade at all levels but the first."""

WAVY_SEGMENTS = (6, 4, 3)
"""Segments of blades that wind."""

CALM = (0.0, 0.05, 0.5)
"""How much of the contrast between the feet and the tips of blades is gone, by level."""


def clump(kind: str, seed: int, level: int) -> Prototype:
    """Return a clump of grass at a level of detail."""
    config = CLUMPS[kind]
    rng = np.random.default_rng([seed, 17])
    share, wide = LEVELS[level]
    segments = (config.segments, *SEGMENTS_BEYOND)[level]
    n = max(round(config.blades * share), 3)
    angle, out = rng.uniform(0, 2 * np.pi, n), config.spread * np.sqrt(rng.uniform(size=n))
    roots = np.stack([out * np.cos(angle), np.full(n, -0.01), out * np.sin(angle)], axis=-1)
    # Few blades are tall; outer ones are shorter and hang over more.
    tall = rng.uniform(config.shortest, 1.0, n)
    heights = config.height * tall * (1.0 - 0.25 * out / config.spread)
    leans = heights * config.lean * rng.uniform(0.3, 1.25, n)
    headings = angle + rng.normal(0.0, 0.45, n) if config.outward else None
    # Short blades are narrow, too.
    slim = 0.6 + 0.55 * heights / config.height
    widths = wide * config.width * slim * rng.uniform(0.75, 1.25, n)
    if config.wave:
        segments = WAVY_SEGMENTS[level]
    shape = Shape()
    add_blades(
        *(shape, rng, roots, heights, leans, widths, _calmed(config, level)),
        segments=segments,
        headings=headings,
        dry=(config.dry, config.straw),
        wave=config.wave,
    )
    if config.clover and seed % 3 == 0:
        _add_clover(shape, rng, config, max(round(config.clover * share), 2), level)
    if config.ears:
        _add_ears(shape, rng, config, max(round(config.ears * share), 1), level)
    return shape.prototype()


def _add_clover(
    shape: Shape, rng: np.random.Generator, config: Clump, count: int, level: int
) -> None:
    """Add leaves of three leaflets, as of clover, that lie open between the blades."""
    angle, out = rng.uniform(0, 2 * np.pi, count), config.spread * np.sqrt(rng.uniform(size=count))
    height = config.height * rng.uniform(0.25, 0.6, count)
    middle = np.stack([out * np.cos(angle), height, out * np.sin(angle)], axis=-1)
    turn = rng.uniform(0, 2 * np.pi, (count, 1)) + 2 * np.pi * np.arange(3) / 3
    way = np.stack([np.cos(turn), np.full_like(turn, 0.15), np.sin(turn)], axis=-1)
    face = np.array([0.0, 1.0, 0.0]) + 0.3 * rng.normal(size=(count, 3))
    size = np.repeat(0.017 * rng.uniform(0.7, 1.2, count) * (1.0, 1.3, 1.9)[level], 3)
    color = np.array([0.105, 0.190, 0.045]) * rng.uniform(0.8, 1.2, (count, 1))
    add_leaves(
        *(shape, np.repeat(middle, 3, axis=0), way.reshape(-1, 3), np.repeat(face, 3, axis=0)),
        *(size, 0.9 * size, np.repeat(color, 3, axis=0)),
        triangles=2 if level == 0 else 1,
    )


def _calmed(config: Clump, level: int) -> tuple[Color, Color]:
    """Return the colours of feet and tips, nearer to their mean where a blade is below a pixel."""
    root, tip = np.array(config.root), np.array(config.tip)
    toward = CALM[level] * (0.45 * root + 0.55 * tip - root)
    back = 0.5 * CALM[level] * (0.45 * root + 0.55 * tip - tip)
    return _color(root + toward), _color(tip + back)


def _color(values: Array) -> Color:
    red, green, blue = values.tolist()
    return red, green, blue


def _add_ears(
    shape: Shape, rng: np.random.Generator, config: Clump, count: int, level: int
) -> None:
    """Add stalks with heads of seeds."""
    angle = rng.uniform(0, 2 * np.pi, count)
    out = 0.6 * config.spread * rng.uniform(size=count)
    roots = np.stack([out * np.cos(angle), np.zeros(count), out * np.sin(angle)], axis=-1)
    heights = config.height * rng.uniform(1.15, 1.5, count)
    straw = tuple(0.55 * np.add(config.tip, config.straw))
    thin = config.width * (0.45, 0.7, 1.0)[level]
    tips = add_blades(
        *(shape, rng, roots, heights, 0.22 * heights, np.full(count, thin)),
        (config.root, straw),
        segments=2 if level < 2 else 1,
        blunt=0.5,
    )
    length = config.ear_length * config.height
    # A head is a panicle: slim scales along the stalk, the upper ones nearer to it.
    each = (8, 4, 1)[level]
    around = rng.uniform(0, 2 * np.pi, (count, each))
    out = np.broadcast_to(np.linspace(0.55, 0.15, each), around.shape)
    way = np.stack([out * np.cos(around), np.ones_like(around), out * np.sin(around)], axis=-1)
    where = np.linspace(-0.85, 0.0, each)[None, :, None] * length * np.array([0.0, 1.0, 0.0])
    base = (tips[:, None] + where).reshape(-1, 3)
    way = way.reshape(-1, 3)
    size = length * (0.34, 0.45, 1.0)[level] * rng.uniform(0.75, 1.15, len(base))
    colors = np.asarray(config.ear) * rng.uniform(0.8, 1.2, (len(base), 1))
    face: Array = rng.normal(size=(len(base), 3))
    slim = config.plump * (1.0, 1.0, 0.55)[level]
    add_leaves(shape, base, way, face, size, slim * size, colors, fold=0.3, triangles=1)
