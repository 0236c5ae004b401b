"""Body mesh: shirt, sleeves, bare arms and hands, trousers or shorts, shins and shoes.

A shoulder turns farther than any other joint: each sleeve starts as a ball, which no turn of the
arm uncovers.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pipeline.simulation.people.body_frames import FRAMES
from pipeline.simulation.people.cloth_folds import (
    LEG as LEG_FOLDS,
)
from pipeline.simulation.people.cloth_folds import (
    SHIRT as SHIRT_FOLDS,
)
from pipeline.simulation.people.cloth_folds import (
    SHORT_SLEEVE,
    SHORTS,
    SLEEVE,
    fold_depth,
    fold_shade,
    folded,
)
from pipeline.simulation.people.hand_mesh import fingers, palm
from pipeline.simulation.people.proportions import BodyMeasures
from pipeline.simulation.people.signed_distance import (
    Field,
    offset_solid,
    oval_stack,
    round_cone,
    smooth_union,
)
from pipeline.simulation.people.skinned_surface import (
    MIRROR,
    MIRRORED_FRAMES,
    SkinnedPatch,
    Surface,
    cached_part,
    merge_patches,
    polygonise,
    ramp,
    symmetric_field,
    with_mirror,
)
from pipeline.simulation.spatial import Array

TORSO = (
    (0.490, -0.003, 0.074, 0.083, 0.113),
    (0.520, -0.003, 0.073, 0.081, 0.112),
    (0.545, -0.003, 0.071, 0.077, 0.109),
    (0.570, -0.002, 0.068, 0.071, 0.102),
    (0.605, 0.001, 0.064, 0.060, 0.091),
    (0.640, 0.002, 0.061, 0.054, 0.084),
    (0.680, 0.002, 0.063, 0.056, 0.086),
    (0.720, 0.003, 0.067, 0.060, 0.091),
    (0.755, 0.002, 0.066, 0.062, 0.093),
    (0.782, -0.002, 0.057, 0.057, 0.088),
    (0.808, -0.006, 0.046, 0.048, 0.068),
    (0.824, -0.009, 0.037, 0.040, 0.046),
    (0.834, -0.010, 0.034, 0.037, 0.037),
)
"""Outline of chest and waist in a shirt, from its hem to its collar; see `BodyMeasures.outline`."""

SHIRT_HEM, TUCKED_HEM = 0.520, 0.590  # heights
SHOULDER_RADIUS = 0.0255


@cached_part
def shirt(build: BodyMeasures, tucked: bool = False) -> SkinnedPatch:
    """Return the trunk of a shirt, between pelvis and chest."""
    girth, end = build.girth, build.level(TUCKED_HEM if tucked else SHIRT_HEM)
    wide = build.shoulders + 0.05 * girth
    low = (-0.1 * girth, end, -wide)
    high = (0.1 * girth, build.level(0.90), wide)
    depth = fold_depth(build, SHIRT_FOLDS, 0.0)
    field = folded(shirt_field(build), symmetric_field(depth))
    net = polygonise(field, low, high, 0.0180 * girth, stretch=0.95, symmetric=True, hem=end)
    by_pelvis = net.follow("pelvis", "chest", chest_share(build, net.vertices[:, 1]))
    aside = np.abs(net.vertices[:, 2])
    pull = SHIRT_PULL * ramp(aside, build.shoulders - 0.030 * girth, build.shoulders)
    by_arm = net.follow("chest", "upper_arm_r", pull)
    arms = np.where(net.vertices[:, 2:] < 0.0, MIRRORED_FRAMES[by_arm.frames], by_arm.frames)
    is_shoulder = (pull > 0.0) & (by_pelvis.share == 1.0)
    frames = np.where(is_shoulder[:, None], arms, by_pelvis.frames)
    share = np.where(is_shoulder, pull, by_pelvis.share)
    shade = fold_shade(build, symmetric_field(depth), net.vertices)
    # Arms hang beside it.
    chest = ramp(net.vertices[:, 1], build.level(0.66), build.level(0.76))
    under = chest * ramp(net.vertices[:, 1], build.level(0.815), build.level(0.78))
    shade = shade * (1.0 - ARMPIT_SHADE * under * ramp(aside, 0.065 * girth, 0.090 * girth))
    return replace(SkinnedPatch(net.vertices, net.faces, frames, share), shade=shade)


ARMPIT_SHADE = 0.35
"""How dark a shirt is under the arms, and a sleeve beside the chest."""


def shirt_field(build: BodyMeasures) -> Field:
    """Return the solid of a trunk in a shirt, from below its hem to its collar."""
    girth = build.girth
    torso = oval_stack(build.outline(TORSO, torso_breadths(build)))
    # The trapezius slopes down from the sides of the neck to the shoulders.
    neck = np.array([-0.014 * girth, build.level(0.838), 0.022 * girth])
    tip = np.array([0.0, build.level(0.794), build.shoulders - 0.010 * girth])
    right, left = (
        round_cone(neck * m, tip * m, 0.026 * girth, SHOULDER_RADIUS * girth) for m in (1.0, MIRROR)
    )
    return smooth_union([torso, right, left], 0.035 * girth)


def chest_share(build: BodyMeasures, heights: Array) -> Array:
    """Return the share (n,) of the chest, against the pelvis, in cloth at some heights [m]."""
    return ramp(heights, build.level(0.585), build.level(0.70))


def torso_breadths(build: BodyMeasures) -> Array:
    """Return the breadth factor of each row of a shirt, from the hips to the chest."""
    up = ramp(np.array([row[0] for row in TORSO]), 0.56, 0.70)
    return build.hip_breadth + up * (build.shoulder_breadth - build.hip_breadth)


ARM = (
    (0.470, 0.003, 0.0158, 0.0158, 0.0108),
    (0.486, 0.002, 0.0146, 0.0146, 0.0114),
    (0.525, 0.002, 0.0180, 0.0168, 0.0158),
    (0.585, 0.004, 0.0252, 0.0214, 0.0240),
    (0.612, 0.002, 0.0232, 0.0222, 0.0226),
    (0.632, -0.002, 0.0196, 0.0240, 0.0202),
    (0.655, 0.000, 0.0202, 0.0220, 0.0198),
    (0.695, 0.005, 0.0252, 0.0230, 0.0222),
    (0.725, 0.003, 0.0252, 0.0246, 0.0224),
    (0.745, 0.001, 0.0238, 0.0243, 0.0220),
    (0.770, 0.001, 0.0236, 0.0232, 0.0222),
)
"""Outline of a bare arm from the wrist to under the sleeve; see `BodyMeasures.outline`."""

SLEEVE_THICKNESS = 0.0036  # with the air in it


@cached_part
def sleeves(build: BodyMeasures, short_sleeves: bool) -> SkinnedPatch:
    """Return both sleeves, each starting as a ball around its shoulder."""
    girth, z = build.girth, build.shoulders
    top = build.level(0.818)
    arm = offset_solid(oval_stack(build.outline(ARM), z), SLEEVE_THICKNESS * girth)
    # The deltoid stands out beside the joint, and ends in a hollow above the biceps.
    shoulder = round_cone(
        (-0.001 * girth, top - 0.020 * girth, z - 0.005 * girth),
        (0.002 * girth, top - 0.052 * girth, z + 0.0005 * girth),
        0.0222 * girth,
        0.0244 * girth,
    )
    end = build.level(0.715 if short_sleeves else 0.500)
    depth = fold_depth(build, SHORT_SLEEVE if short_sleeves else SLEEVE, z)
    field = folded(smooth_union([arm, shoulder], 0.02 * girth), depth)
    half_width = 0.045 * girth
    low, high = (
        (-half_width, end, z - half_width),
        (half_width, top + 0.045 * girth, z + half_width),
    )
    surface = polygonise(
        field, low, high, 0.0150 * girth, stretch=1.0 if short_sleeves else 0.95, hem=end
    )
    inner = ramp(surface.vertices[:, 2], z, z - 0.022 * girth)
    high_up = ramp(surface.vertices[:, 1], build.level(0.64), build.level(0.76))
    shade = fold_shade(build, depth, surface.vertices) * (1.0 - ARMPIT_SHADE * inner * high_up)
    return with_mirror(replace(_skinned_sleeve(build, surface), shade=shade))


SLEEVE_PULL, SHIRT_PULL, PULL_REACH = 0.12, 0.30, 0.040
"""Share of the chest in the top of a sleeve, that of the arm in the shoulder of a shirt, and how
far below the joint the first ends, in girths.

Where neither follows the other, a raised arm bulges beside a shoulder that stays."""


def _skinned_sleeve(build: BodyMeasures, net: Surface) -> SkinnedPatch:
    y, joint, reach = net.vertices[:, 1], build.level(0.818), PULL_REACH * build.girth
    elbow = net.follow("upper_arm_r", "forearm_r", _below_elbow(build, net))
    pull = SLEEVE_PULL * ramp(y, joint - reach, joint + 0.3 * reach)
    by_chest = net.follow("upper_arm_r", "chest", pull)
    upper = y > joint - reach
    frames = np.where(upper[:, None], by_chest.frames, elbow.frames)
    return SkinnedPatch(net.vertices, net.faces, frames, np.where(upper, pull, elbow.share))


@cached_part
def bare_arms(build: BodyMeasures, short_sleeves: bool) -> SkinnedPatch:
    """Return both hands, with the bare arms of short sleeves."""
    girth, z = build.girth, build.shoulders
    top = 0.76 if short_sleeves else 0.545
    limb = oval_stack([row for row in build.outline(ARM) if row[0] <= build.level(top)], z)
    field = smooth_union([limb, palm(build)], 0.012 * girth)
    half_width = 0.042 * girth
    low, high = (
        (-half_width, build.level(0.395), z - half_width),
        (half_width, build.level(0.80), z + half_width),
    )
    surface = polygonise(field, low, high, 0.0092 * girth, stretch=1.7)
    y, wrist = surface.vertices[:, 1], build.level(0.486)
    elbow = _below_elbow(build, surface)
    hand = 1.0 - ramp(y, wrist - 0.012 * girth, wrist + 0.012 * girth)
    by_elbow = surface.follow("upper_arm_r", "forearm_r", elbow)
    by_wrist = surface.follow("forearm_r", "hand_r", hand)
    low_part = y < 0.5 * (wrist + build.level(0.632))
    frames = np.where(low_part[:, None], by_wrist.frames, by_elbow.frames)
    arm = SkinnedPatch(surface.vertices, surface.faces, frames, np.where(low_part, hand, elbow))
    return with_mirror(merge_patches([arm, *fingers(build)]))


def _below_elbow(build: BodyMeasures, net: Surface) -> Array:
    elbow, reach = build.level(0.632), 0.022 * build.girth
    return 1.0 - ramp(net.vertices[:, 1], elbow - reach, elbow + reach)


SEAT = (
    (0.462, 0.000, 0.038, 0.044, 0.058),
    (0.490, -0.002, 0.056, 0.064, 0.088),
    (0.525, -0.004, 0.058, 0.068, 0.093),
    (0.560, -0.003, 0.058, 0.060, 0.090),
    (0.595, 0.001, 0.055, 0.050, 0.081),
    (0.625, 0.002, 0.053, 0.047, 0.076),
)
"""Outline of the pelvis in trousers; see `BodyMeasures.outline`."""

LEG = (
    (0.028, 0.001, 0.038, 0.040, 0.034),
    (0.050, -0.003, 0.035, 0.038, 0.0335),
    (0.075, -0.007, 0.031, 0.036, 0.0325),
    (0.130, -0.008, 0.031, 0.037, 0.0330),
    (0.190, -0.007, 0.033, 0.040, 0.0345),
    (0.245, -0.003, 0.0355, 0.038, 0.0350),
    (0.288, 0.002, 0.0385, 0.034, 0.0360),
    (0.350, 0.005, 0.042, 0.040, 0.0400),
    (0.430, 0.005, 0.049, 0.047, 0.046),
    (0.480, 0.003, 0.052, 0.054, 0.047),
    (0.530, 0.000, 0.038, 0.043, 0.032),
)
"""Outline of a leg in trousers."""

SHIN = (
    (0.030, -0.004, 0.0195, 0.0240, 0.0180),
    (0.060, -0.004, 0.0185, 0.0225, 0.0170),
    (0.100, -0.003, 0.0205, 0.0245, 0.0200),
    (0.150, -0.006, 0.0245, 0.0330, 0.0275),
    (0.195, -0.008, 0.0290, 0.0395, 0.0325),
    (0.235, -0.004, 0.0300, 0.0360, 0.0315),
    (0.262, -0.001, 0.0305, 0.0325, 0.0298),
    (0.288, 0.003, 0.0355, 0.0310, 0.0335),
    (0.312, 0.003, 0.0335, 0.0325, 0.0322),
    (0.345, 0.004, 0.0365, 0.0340, 0.0345),
    (0.380, 0.004, 0.0350, 0.0330, 0.0335),
)
"""Outline of a bare leg up to where shorts hide it, thinner in them: none may come through."""

TROUSER_END = 0.029
"""Height of the hem of trousers, on the shoe."""

CROTCH_LEVEL = 0.468
LEG_SPREAD = 0.2  # of the legs while they are polygonised: thighs all but touch


@cached_part
def trousers(build: BodyMeasures, shorts: bool, covered: bool = False) -> SkinnedPatch:
    """Return trousers, or shorts, of both legs.

    Args:
        build: measures of the person.
        shorts: whether they end above the knee.
        covered: whether a coat hangs over them; thighs are thinner then and stay below it.
    """
    girth, end = build.girth, 0.330 if shorts else TROUSER_END
    pelvis = oval_stack(build.outline(SEAT, build.hip_breadth))
    leg = oval_stack(build.outline(LEG), build.hips)
    depth = fold_depth(build, SHORTS if shorts else LEG_FOLDS, build.hips)
    solid = smooth_union([pelvis, leg], 0.030 * girth)
    if covered:
        solid = folded(solid, _covered_depth(build))
    whole = folded(solid, depth)

    def spread(places: Array) -> Array:
        y, z = places[:, 1], np.abs(places[:, 2])
        return whole(np.stack([places[:, 0], y, z - _spread(build, y)], axis=-1))

    half_width = build.hips + 0.075 * girth + float(_spread(build, np.array([build.level(end)]))[0])
    low = (-0.1 * girth, build.level(end), -half_width)
    high = (0.1 * girth, build.level(0.64), half_width)
    surface = polygonise(
        spread, low, high, 0.0163 * girth, stretch=0.88, symmetric=True, hem=build.level(end)
    )
    places = surface.vertices.copy()
    places[:, 2] -= np.sign(places[:, 2]) * _spread(build, places[:, 1])
    shade = fold_shade(build, symmetric_field(depth), places)
    # Thighs shade one another.
    between = ramp(np.abs(places[:, 2]), 0.036 * girth, 0.008 * girth)
    below = ramp(places[:, 1], build.level(0.500), build.level(0.450))
    shade = shade * (1.0 - CROTCH_SHADE * between * below)
    return replace(_skinned_trousers(build, places, surface), shade=shade)


COVERED_DEPTH = 0.009
"""By how much thighs are thinner below a coat, in girths."""


def _covered_depth(build: BodyMeasures) -> Field:
    low, high = build.level(0.365), build.level(0.410)

    def depth(places: Array) -> Array:
        return np.asarray(COVERED_DEPTH * build.girth * ramp(places[:, 1], low, high))

    return depth


CROTCH_SHADE = 0.40
"""How dark trousers are between the legs."""


def _spread(build: BodyMeasures, y: Array) -> Array:
    below = np.maximum(build.level(CROTCH_LEVEL) - y, 0.0)
    return LEG_SPREAD * below * below / (below + 0.03 * build.girth)


def _skinned_trousers(build: BodyMeasures, places: Array, surface: Surface) -> SkinnedPatch:
    x, y, z = places.T
    girth = build.girth
    right = z > 0.0
    # The groin runs upward to the outside, and lies lower behind than in front.
    groin = build.level(0.475) + 0.8 * np.abs(z) + 0.3 * x
    thigh = 1.0 - ramp(y, groin - 0.060 * girth, groin + 0.048 * girth)
    # Between the legs, above the crotch, trousers follow neither.
    inner = 1.0 - ramp(y, build.level(0.375), build.level(0.425))
    thigh = thigh * np.maximum(inner, ramp(np.abs(z), 0.0, 0.020 * girth))
    knee = build.level(0.285)
    shin = 1.0 - ramp(y, knee - 0.038 * girth, knee + 0.038 * girth)
    lower = y < 0.5 * (knee + build.level(CROTCH_LEVEL))
    sides = [
        np.where(right, FRAMES.index(f"{n}_r"), FRAMES.index(f"{n}_l")) for n in ("thigh", "shin")
    ]
    first = np.where(lower, sides[0], FRAMES.index("pelvis"))
    frames = np.stack([first, np.where(lower, sides[1], sides[0])], axis=-1)
    return SkinnedPatch(places, surface.faces, frames, np.where(lower, shin, thigh))


@cached_part
def bare_shins(build: BodyMeasures) -> SkinnedPatch:
    """Return the bare legs below shorts."""
    girth, z = build.girth, build.hips
    field = oval_stack(build.outline(SHIN), z)
    half_width = 0.045 * girth
    low = (-half_width - 0.01 * girth, build.level(0.02), z - half_width)
    high = (half_width + 0.01 * girth, build.level(0.39), z + half_width)
    surface = polygonise(field, low, high, 0.0170 * girth, stretch=1.45)
    knee = build.level(0.285)
    share = 1.0 - ramp(surface.vertices[:, 1], knee - 0.028 * girth, knee + 0.028 * girth)
    return with_mirror(surface.follow("thigh_r", "shin_r", share))
