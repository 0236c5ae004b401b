"""Footwear: shoes with a sole, a heel, a toe cap's roundness and a throat for the foot.

Lengths are in the length of a foot: X from the ankle forward, Y up from the ground, Z outward.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pipeline.simulation.figures.solids import loft
from pipeline.simulation.people.body_mesh import SHIN
from pipeline.simulation.people.proportions import BodyMeasures
from pipeline.simulation.people.signed_distance import (
    Field,
    ellipsoid,
    half_space,
    round_cone,
    smooth_difference,
    smooth_intersection,
    smooth_union,
)
from pipeline.simulation.people.skinned_surface import (
    SkinnedPatch,
    Surface,
    cached_part,
    ellipsoid_surface,
    merge_patches,
    polygonise,
    with_mirror,
)
from pipeline.simulation.people.tints import SOCK as SOCK_TINT
from pipeline.simulation.people.tints import SOLE
from pipeline.simulation.spatial import Array

SOLE_OUTLINE = (
    (-0.285, -0.005, 0.000),
    (-0.255, -0.075, 0.068),
    (-0.180, -0.115, 0.108),
    (-0.060, -0.115, 0.118),
    (0.100, -0.085, 0.125),
    (0.260, -0.100, 0.155),
    (0.400, -0.125, 0.185),
    (0.520, -0.105, 0.185),
    (0.620, -0.050, 0.155),
    (0.685, 0.010, 0.105),
    (0.705, 0.045, 0.065),
)
"""Edges of a right sole: ahead, its inner and its outer side."""

SOLE_HEIGHTS = (
    (-0.30, 0.040, 0.095),
    (-0.19, 0.000, 0.092),
    (0.06, 0.000, 0.085),
    (0.08, 0.030, 0.080),
    (0.22, 0.012, 0.058),
    (0.34, 0.000, 0.048),
    (0.46, 0.002, 0.050),
    (0.71, 0.050, 0.085),
)
"""Height of its underside and of its upper side: the heel, bevelled behind, the arch, the ball, the
spring of the toes."""

INSET = 0.014
"""By which the edges of a sole are rounded."""

WELT = 1.07
"""Size of a sole in that of the upper, beyond which it stands out."""

THROAT = 0.047
"""Height of the throat of a shoe, as a fraction of an adult's height: trousers hide it, and below
bare shins a sock shows."""

LACES = ((0.110, 0.282), (0.175, 0.257), (0.240, 0.230))
"""Places of the laces ahead, and their heights."""

LACE_RADII = (0.013, 0.022, 0.062)

SOCK = (0.038, 0.046, 0.056, 0.066, 0.0715, 0.0715)
"""Heights of the rings of a sock, as fractions of an adult's height; the last is inside."""

SOCK_WORN, SOCK_AROUND = 0.0030, 16
"""Distance of a sock from the shin, in girths, and vertices of its rings."""


@cached_part
def shoes(build: BodyMeasures, has_socks: bool) -> SkinnedPatch:
    """Return both shoes, with the socks that show below bare shins."""
    size, z = build.proportions.foot * build.proportions.height, build.hips
    top = build.level(THROAT) / size
    low, high = (-0.36, 0.0, -0.26), (0.80, top + 0.05, 0.30)
    net = polygonise(_upper(top), low, high, 0.062, stretch=0.85, hem=0.035)
    laces = [
        ellipsoid_surface(np.array([x, y, 0.008]), np.array(LACE_RADII), 2, 6) for x, y in LACES
    ]
    trims = [_tinted(part.follow("foot_r"), SOLE) for part in (_sole(), *laces)]
    shoe = merge_patches([net.follow("foot_r"), *trims])
    shoe = replace(shoe, vertices=size * shoe.vertices + [0.0, 0.0, z])
    return with_mirror(merge_patches([shoe, _sock(build)]) if has_socks else shoe)


def _tinted(patch: SkinnedPatch, tint: int) -> SkinnedPatch:
    return replace(patch, tint=np.tile([float(tint), 1.0], (len(patch.vertices), 1)))


def _sock(build: BodyMeasures) -> SkinnedPatch:
    """Return a right sock from the shoe to its cuff."""
    g, z, outline = build.girth, build.hips, build.outline(SHIN)
    heights = build.levels(np.array(SOCK))
    middle, ahead, behind, aside = (
        np.interp(heights, outline[:, 0], outline[:, k]) for k in range(1, 5)
    )
    worn = SOCK_WORN * g * np.array([1.0, 1.0, 1.0, 1.0, 1.0, -1.0])
    angle = np.arange(SOCK_AROUND) * (2.0 * np.pi / SOCK_AROUND)
    c, s = np.cos(angle), np.sin(angle)
    depth = np.where(c > 0.0, ahead[:, None], behind[:, None]) + worn[:, None]
    x = middle[:, None] + depth * c
    y = np.repeat(heights[:, None], SOCK_AROUND, axis=1)
    rings = np.stack([x, y, z + (aside + worn)[:, None] * s], axis=-1)
    solid = loft(rings[:, ::-1], rings[[0, -1]].mean(axis=1))
    return _tinted(Surface(solid.vertices, solid.faces).follow("shin_r"), SOCK_TINT)


def _upper(top: float) -> Field:
    """Return the upper of a right shoe, cut off at its throat."""
    heel = round_cone((-0.135, 0.13, -0.002), (0.06, 0.13, 0.0), 0.118, 0.112, (1.0, 1.1, 0.95))
    shaft = round_cone((-0.040, 0.16, 0.0), (-0.035, top, 0.0), 0.140, 0.128)
    instep = round_cone((0.03, 0.205, 0.002), (0.34, 0.10, 0.020), 0.125, 0.095, (1.0, 0.9, 1.05))
    ball = ellipsoid((0.42, 0.075, 0.030), (0.200, 0.088, 0.142))
    toe = ellipsoid((0.530, 0.075, 0.040), (0.155, 0.078, 0.120))
    solid = smooth_union([heel, shaft, instep, ball, toe], 0.07)
    throat = ellipsoid((-0.030, top + 0.015, 0.0), (0.110, 0.055, 0.095))
    solid = smooth_intersection(solid, half_space((0.0, top, 0.0), (0.12, 1.0, 0.0)), 0.025)
    return smooth_difference(solid, throat, 0.02)


def _sole() -> Surface:
    """Return a right sole with its heel."""
    edges, heights = np.array(SOLE_OUTLINE), np.array(SOLE_HEIGHTS)
    # Denser at the heel's breast, where the underside steps.
    edges[:, 1:] *= WELT
    x = np.unique(
        np.concatenate([edges[:, 0], [-0.23, -0.19, -0.12, 0.06, 0.08, 0.16, 0.33, 0.46]])
    )
    inner, outer = (np.interp(x, edges[:, 0], edges[:, k]) for k in (1, 2))
    under, upper = (np.interp(x, heights[:, 0], heights[:, k]) for k in (1, 2))
    middle, half = 0.5 * (inner + outer), 0.5 * (outer - inner)
    narrow = np.maximum(half - INSET, 0.3 * half)
    corners: list[tuple[Array, Array]] = [
        (under, -narrow),
        (under + INSET, -half),
        (upper - INSET, -half),
        (upper, -narrow),
        (upper, narrow),
        (upper - INSET, half),
        (under + INSET, half),
        (under, narrow),
    ]
    rings = np.stack([np.stack([x, y, middle + z], axis=-1) for y, z in corners], axis=1)
    solid = loft(rings, rings[[0, -1]].mean(axis=1))
    return Surface(solid.vertices, solid.faces)
