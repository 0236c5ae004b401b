"""Garments: what is worn over shirt and trousers, or in their place.

Skirts of dresses and coats follow the pelvis at the waist, and the thighs the lower the more.
"""

from __future__ import annotations

import numpy as np

from pipeline.simulation.people.body_frames import FRAMES
from pipeline.simulation.people.body_mesh import ARM, LEG, TORSO, torso_breadths
from pipeline.simulation.people.proportions import BodyMeasures
from pipeline.simulation.people.signed_distance import (
    HEM_ROUNDING,
    Field,
    ellipsoid,
    half_space,
    offset_solid,
    oval_stack,
    smooth_intersection,
)
from pipeline.simulation.people.skinned_surface import (
    SkinnedPatch,
    cached_part,
    merge_patches,
    polygonise,
    ramp,
    tube,
    with_mirror,
)
from pipeline.simulation.spatial import Array

SKIRT = (
    (0.280, 0.002, 0.096, 0.104, 0.150),
    (0.330, 0.002, 0.088, 0.097, 0.140),
    (0.400, 0.000, 0.077, 0.086, 0.123),
    (0.470, -0.002, 0.067, 0.076, 0.106),
    (0.525, -0.003, 0.062, 0.071, 0.097),
    (0.570, -0.002, 0.059, 0.061, 0.091),
    (0.605, 0.001, 0.057, 0.052, 0.084),
    (0.625, 0.002, 0.056, 0.050, 0.080),
)
"""Outline of a skirt from its hem to its waist; see `BodyMeasures.outline`."""

SKIRT_HEM, COAT_HEM = 0.300, 0.360

FOLDS, FOLD_DEPTH = 11, 0.0045
"""Number of the folds of a skirt, and their depth at its hem, in an adult's height."""

WORN = 0.0032
"""Distance between two layers of cloth, in an adult's height."""


def _skirt(build: BodyMeasures, hem: float, grown: float) -> SkinnedPatch:
    """Return a skirt down to a height, wider than the usual one by `grown` all around."""
    girth, end = build.girth, build.level(hem)
    stack = offset_solid(oval_stack(build.outline(SKIRT, build.hip_breadth)), grown * girth)
    waist = build.level(0.60)

    def folded(places: Array) -> Array:
        # Deeper towards the hem.
        down = np.clip((waist - places[:, 1]) / (waist - end), 0.0, 1.0)
        around = np.arctan2(places[:, 2], places[:, 0])
        depth = FOLD_DEPTH * girth * down * down
        result: Array = stack(places) + depth * np.cos(FOLDS * around)
        return result

    field = smooth_intersection(
        folded, half_space((0.0, end, 0.0), (0.0, -1.0, 0.0)), HEM_ROUNDING * girth
    )
    wide = build.hips + 0.15 * girth
    low = (-0.15 * girth, end - 0.02 * girth, -wide)
    high = (0.15 * girth, build.level(0.64), wide)
    net = polygonise(field, low, high, 0.0145 * girth, stretch=1.4, symmetric=True, hem=end)
    y, z = net.vertices[:, 1], net.vertices[:, 2]
    falling = 1.0 - ramp(y, build.level(0.40), build.level(0.55))
    share = falling * (0.62 + 0.26 * ramp(np.abs(z), 0.0, 0.06 * girth))
    thigh = np.where(z > 0.0, FRAMES.index("thigh_r"), FRAMES.index("thigh_l"))
    frames = np.stack([np.full(len(z), FRAMES.index("pelvis")), thigh], axis=-1)
    return SkinnedPatch(net.vertices, net.faces, frames, share)


@cached_part
def skirt(build: BodyMeasures) -> SkinnedPatch:
    """Return a skirt down to the knees."""
    return _skirt(build, SKIRT_HEM, 0.0)


@cached_part
def coat_skirt(build: BodyMeasures) -> SkinnedPatch:
    """Return the lower half of a coat, which ends above the knees."""
    return _skirt(build, COAT_HEM, 3.0 * WORN)


@cached_part
def hood(build: BodyMeasures) -> SkinnedPatch:
    """Return a hood that hangs down the back, and its rim around the neck."""
    g = build.girth
    angle = np.radians(np.linspace(-150.0, 150.0, 13))
    rim = np.stack(
        [
            -0.012 * g - 0.046 * g * np.cos(angle),
            build.level(0.838) - 0.012 * g * (1.0 - np.cos(angle)),
            0.047 * g * np.sin(angle),
        ],
        axis=-1,
    )
    thick = 0.0145 * g * (0.7 + 0.3 * np.cos(angle / 2.0))
    bag = ellipsoid((-0.066 * g, build.level(0.795), 0.0), np.array([0.026, 0.052, 0.062]) * g)
    low = (-0.12 * g, build.level(0.73), -0.09 * g)
    high = (-0.01 * g, build.level(0.86), 0.09 * g)
    hanging = polygonise(bag, low, high, 0.014 * g, symmetric=True)
    return merge_patches([tube(rim, thick, 8).follow("chest"), hanging.follow("chest")])


@cached_part
def suit_front(build: BodyMeasures) -> SkinnedPatch:
    """Return the shirt between the lapels of a jacket."""
    g = build.girth
    low, high = build.level(0.690), build.level(0.845)
    slope = 0.030 * g / (high - low)
    sides = [half_space((0.0, low, 0.0), (0.0, -slope, sign * 1.0)) for sign in (1.0, -1.0)]
    return _panel(build, [*sides, half_space((0.02 * g, 0.0, 0.0), (-1.0, 0.0, 0.0))], 2.4)


@cached_part
def tie(build: BodyMeasures) -> SkinnedPatch:
    """Return a tie, from the collar into the jacket."""
    g = build.girth
    sides = _between(0.0085 * g)
    ends = [
        half_space((0.0, build.level(0.70), 0.0), (0.0, -1.0, 0.0)),
        half_space((0.02 * g, 0.0, 0.0), (-1.0, 0.0, 0.0)),
    ]
    return _panel(build, [*sides, *ends], 3.8)


@cached_part
def bib(build: BodyMeasures) -> SkinnedPatch:
    """Return the bib of dungarees, and its straps over the shoulders."""
    g = build.girth
    sides = _between(0.056 * g)
    ends = [
        half_space((0.0, build.level(0.745), 0.0), (0.0, 1.0, 0.0)),
        half_space((0.0, build.level(0.555), 0.0), (0.0, -1.0, 0.0)),
        half_space((0.02 * g, 0.0, 0.0), (-1.0, 0.0, 0.0)),
    ]
    line = (
        (0.062, 0.740, 0.044),
        (0.064, 0.780, 0.046),
        (0.050, 0.815, 0.050),
        (0.010, 0.845, 0.053),
        (-0.036, 0.825, 0.050),
        (-0.060, 0.770, 0.036),
        (-0.062, 0.700, 0.020),
        (-0.056, 0.620, 0.010),
    )
    points = np.array([(x * g, build.level(y), z * g) for x, y, z in line])
    strap = tube(points, np.full(len(points), 0.0085 * g), 6).follow("chest")
    return merge_patches([_panel(build, [*sides, *ends], 1.0), with_mirror(strap)])


def _between(half: float) -> list[Field]:
    """Return the limits of what reaches as far to both sides [m]."""
    return [half_space((0.0, 0.0, sign * half), (0.0, 0.0, sign)) for sign in (1.0, -1.0)]


def _panel(build: BodyMeasures, limits: list[Field], worn: float) -> SkinnedPatch:
    """Return cloth on the trunk within some limits, above another cloth by `worn` layers."""
    g = build.girth
    field = offset_solid(oval_stack(build.outline(TORSO, torso_breadths(build))), worn * WORN * g)
    for limit in limits:
        field = smooth_intersection(field, limit, 0.004 * g)
    low = (0.0, build.level(0.53), -0.08 * g)
    high = (0.11 * g, build.level(0.87), 0.08 * g)
    net = polygonise(field, low, high, 0.0105 * g, stretch=1.3, symmetric=True)
    share = ramp(net.vertices[:, 1], build.level(0.585), build.level(0.70))
    return net.follow("pelvis", "chest", share)


@cached_part
def stripes(build: BodyMeasures) -> SkinnedPatch:
    """Return the stripes down the sides of a tracksuit's arms and legs."""
    g = build.girth
    patches = []
    for rows, z, place, ends, frames in (
        (LEG, build.hips, 0.285, (0.060, 0.500), ("thigh_r", "shin_r")),
        (ARM, build.shoulders, 0.632, (0.510, 0.765), ("upper_arm_r", "forearm_r")),
    ):
        outline = build.outline(rows)
        thick = 0.0042 if rows is ARM else 0.0
        levels = np.linspace(build.level(ends[0]), build.level(ends[1]), 24)
        x, side = (np.interp(levels, outline[:, 0], outline[:, k]) for k in (1, 4))
        points = np.stack([x, levels, z + side + (thick - 0.0035) * g], axis=-1)
        stripe = tube(points, np.full(len(points), 0.0060 * g), 6)
        reach, joint = 0.030 * g, build.level(place)
        share = 1.0 - ramp(stripe.vertices[:, 1], joint - reach, joint + reach)
        patches.append(stripe.follow(*frames, share))
    return with_mirror(merge_patches(patches))
