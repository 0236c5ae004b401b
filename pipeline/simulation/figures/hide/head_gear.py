"""What is on a skull: ears, horns, tusks, beaks, the mouth line and whiskers."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pipeline.simulation.figures.hide.head import Head
from pipeline.simulation.figures.hide.sheets import Paint, ear, horn, lay, outward, painted, tube
from pipeline.simulation.figures.hide.stance import Chain, smoothstep
from pipeline.simulation.figures.hide.trunk import spline
from pipeline.simulation.figures.solids import Solid, loft
from pipeline.simulation.spatial import UP, Array, normalized
from pipeline.spec.skin import Skin as SkinConfig


def ear_solid(head: Head, chain: Chain, side: float, config: SkinConfig) -> tuple[Solid, Array]:
    """Return an ear and the share of its inner side at each vertex."""
    skull = head.skull
    length = 1.35 * skull.ear_length * config.ear_length * chain.limb.length
    way = head.way(skull.ear_way, side)
    opening = head.way(skull.ear_opening, side)
    width = length * skull.ear_width * config.ear_width / config.ear_length
    root = head.place(skull.ear, side)
    return ear(root, way, opening, length, width, skull.ear_fold, skull.ear_point, skull.ear_wave)


MOUTH_WIDTH = 0.065
"""Half the width of the slit of a mouth, in the radius of the muzzle."""

MOUTH_SUNK = 0.1
"""Depth of the middle of the slit in the skin, in half its width."""

WHISKERS = ((0.25, 0.50), (-0.10, 0.25), (-0.30, 0.0), (-0.15, -0.22), (0.15, -0.45))
"""Directions of the whiskers ahead and up, for one to the side."""

WHISKER_RADIUS = 0.012
"""Radius of a whisker at its root, in that of the muzzle: thinner ones would sparkle."""

NOSE_RINGS, NOSE_AROUND, NOSE_DEG = 8, 18, 100.0
"""Rings of a bare nose, vertices around it, and how far it goes round [degrees]."""

NOSE_SIZE, NOSE_TAPER = 1.05, 0.35
"""Size of a bare nose in that of the flesh below, and how much narrower it is below than above."""

NOSTRIL, NOSTRIL_SIZE, NOSTRIL_DEPTH = (0.76, -0.02, 0.52), 0.26, 0.34
"""Direction ahead, up and to the side, radius and depth of a nostril, in the radius of the nose."""

GROOVE_DEPTH, GROOVE_POINTS = 0.10, 4
"""Depth of the groove between the nostrils, in the radius of the nose, and its points below it."""

NOSTRIL_COLOR = "#060404"

FOLDS, FOLD_POINTS, FOLD_DEPTH = 26, 12, 0.045
"""Folds around a trunk, vertices around it, and the depth of a fold in its radius."""

FOLD_COLOR = "#2b2622"

STUB = (1.15, 0.90, 0.72, 0.64, 0.62, 0.66, 0.78, 0.84, 0.72, 0.40)
"""Radius along a stub of horn, in that drawn."""

TUSK_POINTS, TUSK_TIP = 10, 0.12
"""Vertices around a tusk, and the radius of its tip in that of its root."""

HORN_CURVES = {
    "straight": ((0.0, 0.0, 0.0), (-0.10, 0.5, 0.06), (-0.22, 1.0, 0.10)),
    "curved": (
        *((0.0, 0.0, 0.0), (0.02, 0.22, 0.05), (-0.10, 0.48, 0.12)),
        *((-0.34, 0.70, 0.19), (-0.62, 0.80, 0.24)),
    ),
    "lyre": (
        *((0.0, 0.0, 0.0), (-0.08, 0.22, 0.10), (-0.26, 0.44, 0.26)),
        *((-0.42, 0.66, 0.34), (-0.46, 0.88, 0.26), (-0.36, 1.02, 0.16)),
    ),
    "tusks": (
        *((0.0, 0.0, 0.0), (0.22, -0.20, 0.06), (0.46, -0.33, 0.11)),
        *((0.72, -0.36, 0.14), (0.98, -0.25, 0.12)),
    ),
    "stub": ((0.0, 0.0, 0.0), (-0.05, 0.5, 0.02), (-0.08, 1.0, 0.04)),
}
"""Curves of horns along, up and to the side of the head, in their length."""


def horn_solid(head: Head, chain: Chain, side: float, shape: str) -> Solid:
    """Return a horn that is fixed to the skull."""
    length = chain.limb.length
    root = head.place(head.skull.horn, side)
    axes = head.axes * np.array([[1.0], [1.0], [side]])
    # Horns stand on the head as the head is held, so that they lean backward over the neck.
    curve = root + length * np.array(HORN_CURVES[shape]) @ axes
    radius = float(chain.radii[1:].max())
    if shape == "stub":
        # Broad at its root, with a knob at its end.
        t = np.linspace(0.0, 1.0, len(STUB))
        middle = curve[0] + t[:, None] * (curve[-1] - curve[0])
        return tube(middle, 1.15 * radius * np.array(STUB), 9)
    if shape == "tusks":
        smooth, _ = spline(curve, np.full(len(curve), radius), 4)
        sizes = radius * (TUSK_TIP + (1.0 - TUSK_TIP) * np.linspace(1.0, 0.0, len(smooth)) ** 0.8)
        return tube(smooth, sizes, TUSK_POINTS, 1.0, head.axes[1])
    return horn(curve, 1.25 * radius, 9, 0.16)


def proboscis_solid(chain: Chain) -> tuple[Solid, Paint]:
    """Return a trunk with folds around it and two nostrils at its end, and its paint."""
    curve, sizes = spline(chain.points, chain.radii, 12)
    s, t = np.linspace(0.0, 1.0, len(curve)), np.linspace(0.0, 1.0, 2 * FOLDS + 1)
    middle = np.stack([np.interp(t, s, curve[:, k]) for k in range(3)], axis=-1)
    radii = np.interp(t, s, sizes)
    in_fold = np.where(np.arange(len(t)) % 2 == 1, 1.0, 0.0)
    # Folds are deepest in the middle; the root is part of the face, the tip a ring of lips.
    deep = np.interp(t, [0.0, 0.12, 0.3, 0.8, 1.0], [0.0, 0.5, 1.0, 0.9, 0.3]) * in_fold
    shape = np.interp(t, [0.0, 0.93, 0.97, 1.0], [1.0, 1.0, 1.14, 1.02])
    solid = tube(middle, radii * shape * (1.0 - FOLD_DEPTH * deep), FOLD_POINTS, 0.92, UP)
    # The end is hollow.
    way = normalized(middle[-1] - middle[-2])
    solid.vertices[-1] = middle[-1] - 0.7 * radii[-1] * way
    share = np.concatenate([np.repeat(0.35 * deep, FOLD_POINTS), [0.0, 1.0]])
    return solid, painted(len(solid.vertices), FOLD_COLOR, share)


def beak_solid(head: Head) -> Solid:
    """Return a beak: broad and flat, with a round end and an edge where it opens."""
    r0 = head.radii[0]
    s = np.linspace(0.0, 1.0, 12)
    length = 0.98 * (head.length + head.radii[1]) - 0.30 * head.length
    wide = r0 * (0.64 * (1.0 - 0.45 * s) * (1.0 - s**5) ** 0.6 + 0.05)
    high = r0 * (0.38 * (1.0 - s) ** 0.9 + 0.08)
    angle = np.arange(12) * (2.0 * np.pi / 12)
    drop = -0.14 * r0 * s**2 - 0.12 * r0
    # Flatter below than above.
    ring_up = np.where(np.sin(angle) > 0, np.sin(angle), 0.7 * np.sin(angle))
    x = 0.28 * head.length + s * length
    rings = np.stack(
        [
            np.repeat(x[:, None], 12, axis=1),
            drop[:, None] + high[:, None] * ring_up,
            wide[:, None] * np.cos(angle),
        ],
        axis=-1,
    )
    rings = rings @ head.axes + head.back
    along = normalized(head.axes[0])
    ends = np.stack(
        [rings[0].mean(axis=0) - 0.2 * r0 * along, rings[-1].mean(axis=0) + 0.05 * r0 * along]
    )
    return outward(loft(rings, ends))


def mouth_solid(head: Head) -> Solid | None:
    """Return the slit of the mouth, which lies in the skin; None without a mouth."""
    if head.mouth is None:
        return None
    sizes = np.full(len(head.mouth), MOUTH_WIDTH * head.radii[1])
    sizes[[0, -1]] *= 0.4
    # Most of it is in the skin.
    inward = head.mouth.mean(axis=0) - head.mouth
    inward -= (inward @ head.axes[1])[:, None] * head.axes[1]
    return tube(head.mouth + MOUTH_SUNK * sizes[:, None] * normalized(inward), sizes, 5)


def lip_groove(head: Head) -> Solid | None:
    """Return the groove from a bare nose down to the mouth; None without one of them."""
    if head.mouth is None or head.nose is None:
        return None
    root = head.nose + head.nose_extent[0] * head.axes[0] - 0.4 * head.nose_extent[1] * head.axes[1]
    curve = np.linspace(root, head.mouth[len(head.mouth) // 2], GROOVE_POINTS)
    placed = [head.on_skin(point) for point in curve]
    sizes = np.full(GROOVE_POINTS, 0.7 * MOUTH_WIDTH * head.radii[1])
    return tube(np.array(placed), sizes, 5)


def nose_solid(head: Head) -> tuple[Solid, Paint] | None:
    """Return a bare nose with two nostrils and a groove between them, and its paint."""
    if head.skull.nose is None or head.nose is None:
        return None
    middle, color = head.nose, head.skull.nose[2]
    polar = np.radians(np.linspace(0.0, NOSE_DEG, NOSE_RINGS + 1)[1:])[:, None]
    azimuth = np.arange(NOSE_AROUND) * (2.0 * np.pi / NOSE_AROUND)
    x = np.cos(polar) + 0.0 * azimuth
    y, z = np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth)
    # A comma that opens to the side.
    ahead, up, out = NOSTRIL
    away = np.stack([x - ahead, 1.5 * (y - up - 0.25 * (np.abs(z) - out)), 0.8 * (np.abs(z) - out)])
    hole = np.exp(-((away**2).sum(axis=0)) / NOSTRIL_SIZE**2)
    groove = np.exp(-((z / 0.13) ** 2)) * np.clip(0.5 - 1.2 * y, 0.0, 1.0) * (x > 0.0)
    depth = 1.0 - NOSTRIL_DEPTH * hole - GROOVE_DEPTH * groove
    # Narrow below, as wide as it is above.
    wide = z * (1.0 - NOSE_TAPER * np.clip(-y, 0.0, 1.0))
    size = NOSE_SIZE * head.nose_extent
    local = np.stack([x * depth, y * depth, wide * depth], axis=-1) * size
    front, back = np.array([size[0] * (1.0 - GROOVE_DEPTH), 0.0, 0.0]), np.zeros(3)
    solid = outward(loft(local @ head.axes + middle, np.stack([front, back]) @ head.axes + middle))
    paint = painted(len(solid.vertices), color)
    lay(paint, NOSTRIL_COLOR, np.append(smoothstep((hole - 0.35) / 0.3).reshape(-1), [0.0, 0.0]))
    return solid, paint


def whisker_solids(head: Head) -> Iterator[Solid]:
    """Yield the whiskers on both sides of a muzzle."""
    length = head.skull.whiskers * head.length
    for side in (1.0, -1.0) if length else ():
        for k, (back, up) in enumerate(WHISKERS):
            root = head.place((0.90 + 0.05 * (k % 2), 0.14 * up, 0.55), side)
            way = head.way((back, up, 1.0), side)
            bow = head.way((-0.5, -0.3, 0.0), side)
            t = np.linspace(0.0, 1.0, 5)[:, None]
            curve = root + length * (t * way + 0.22 * t * t * bow)
            yield tube(curve, WHISKER_RADIUS * head.radii[1] * np.linspace(1.0, 0.3, 5), 3)
