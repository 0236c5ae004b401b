"""Body mesh: shirt, sleeves, bare arms and hands, trousers or shorts, shins and shoes.

A shoulder turns farther than any other joint: each sleeve starts as a ball, which no turn of the
arm uncovers.
"""

from __future__ import annotations

import numpy as np

from pipeline.simulation.people.body_frames import FRAMES
from pipeline.simulation.people.proportions import BodyMeasures
from pipeline.simulation.people.signed_distance import (
    HEM_ROUNDING,
    Field,
    half_space,
    offset_solid,
    oval_stack,
    round_cone,
    smooth_intersection,
    smooth_union,
)
from pipeline.simulation.people.skinned_surface import (
    MIRROR,
    SkinnedPatch,
    Surface,
    cached_part,
    merge_patches,
    polygonise,
    ramp,
    tube,
    with_mirror,
)
from pipeline.simulation.spatial import Array

TORSO = (
    (0.490, -0.003, 0.074, 0.083, 0.113),
    (0.520, -0.003, 0.073, 0.081, 0.112),
    (0.545, -0.003, 0.071, 0.077, 0.109),
    (0.570, -0.002, 0.068, 0.071, 0.102),
    (0.605, 0.001, 0.063, 0.059, 0.090),
    (0.640, 0.002, 0.061, 0.054, 0.084),
    (0.680, 0.002, 0.063, 0.055, 0.085),
    (0.720, 0.003, 0.066, 0.058, 0.089),
    (0.755, 0.002, 0.065, 0.060, 0.092),
    (0.785, -0.002, 0.057, 0.056, 0.090),
    (0.812, -0.006, 0.046, 0.048, 0.070),
    (0.832, -0.009, 0.037, 0.039, 0.046),
    (0.844, -0.010, 0.034, 0.036, 0.037),
)
"""Outline of chest and waist in a shirt, from its hem to its collar; see `BodyMeasures.outline`."""

SHIRT_HEM, TUCKED_HEM = 0.520, 0.590  # heights
SHOULDER_RADIUS = 0.0255


@cached_part
def shirt(build: BodyMeasures, tucked: bool = False) -> SkinnedPatch:
    """Return the trunk of a shirt, between pelvis and chest."""
    girth, end = build.girth, build.level(TUCKED_HEM if tucked else SHIRT_HEM)
    torso = oval_stack(build.outline(TORSO, torso_breadths(build)))
    neck = np.array([-0.008 * girth, build.level(0.832), 0.02 * girth])
    tip = np.array([0.0, build.level(0.811), build.shoulders - 0.006 * girth])
    right, left = (
        round_cone(neck * m, tip * m, 0.030 * girth, SHOULDER_RADIUS * girth) for m in (1.0, MIRROR)
    )
    hem = half_space((0.0, end, 0.0), (0.0, -1.0, 0.0))
    field = smooth_intersection(
        smooth_union([torso, right, left], 0.035 * girth), hem, HEM_ROUNDING * girth
    )
    wide = build.shoulders + 0.05 * girth
    low = (-0.1 * girth, end - 0.03 * girth, -wide)
    high = (0.1 * girth, build.level(0.87), wide)
    net = polygonise(field, low, high, 0.0180 * girth, stretch=1.2, symmetric=True, hem=end)
    share = ramp(net.vertices[:, 1], build.level(0.585), build.level(0.70))
    return net.follow("pelvis", "chest", share)


def torso_breadths(build: BodyMeasures) -> Array:
    """Return the breadth factor of each row of a shirt, from the hips to the chest."""
    up = ramp(np.array([row[0] for row in TORSO]), 0.56, 0.70)
    return build.hip_breadth + up * (build.shoulder_breadth - build.hip_breadth)


ARM = (
    (0.470, 0.003, 0.0160, 0.0160, 0.0110),
    (0.486, 0.002, 0.0155, 0.0155, 0.0120),
    (0.530, 0.002, 0.0185, 0.0175, 0.0160),
    (0.590, 0.002, 0.0230, 0.0215, 0.0220),
    (0.632, 0.000, 0.0215, 0.0230, 0.0215),
    (0.680, 0.002, 0.0230, 0.0230, 0.0220),
    (0.740, 0.003, 0.0255, 0.0245, 0.0235),
    (0.770, 0.001, 0.0240, 0.0235, 0.0225),
)
"""Outline of a bare arm from the wrist to under the sleeve; see `BodyMeasures.outline`."""

SLEEVE_THICKNESS = 0.0042  # with the air in it

FINGERS = (
    (0.0225, 0.430, 0.040, 0.0073),
    (0.0085, 0.426, 0.046, 0.0076),
    (-0.0055, 0.428, 0.043, 0.0073),
    (-0.0185, 0.434, 0.034, 0.0064),
)
"""From the index on: place ahead, height of the knuckle, length, radius."""

FINGER_CURL = (0.10, 0.45, 0.75)  # bend of a relaxed finger's joints [rad]


@cached_part
def sleeves(build: BodyMeasures, short_sleeves: bool) -> SkinnedPatch:
    """Return both sleeves, each starting as a ball around its shoulder."""
    girth, z = build.girth, build.shoulders
    top = build.level(0.818)
    arm = offset_solid(oval_stack(build.outline(ARM), z), SLEEVE_THICKNESS * girth)
    shoulder = round_cone(
        (0.0, top - 0.007 * girth, z - 0.003 * girth),
        (0.002 * girth, top - 0.065 * girth, z),
        0.0250 * girth,
        0.0280 * girth,
    )
    end = build.level(0.715 if short_sleeves else 0.500)
    field = smooth_union([arm, shoulder], 0.02 * girth)
    field = smooth_intersection(
        field, half_space((0.0, end, 0.0), (0.0, -1.0, 0.0)), HEM_ROUNDING * girth
    )
    half_width = 0.045 * girth
    low, high = (
        (-half_width, end - 0.02 * girth, z - half_width),
        (half_width, top + 0.045 * girth, z + half_width),
    )
    surface = polygonise(
        field, low, high, 0.0150 * girth, stretch=1.0 if short_sleeves else 1.5, hem=end
    )
    return with_mirror(surface.follow("upper_arm_r", "forearm_r", _below_elbow(build, surface)))


@cached_part
def bare_arms(build: BodyMeasures, short_sleeves: bool) -> SkinnedPatch:
    """Return both hands, with the bare arms of short sleeves."""
    girth, z = build.girth, build.shoulders
    top = 0.76 if short_sleeves else 0.545
    limb = oval_stack([row for row in build.outline(ARM) if row[0] <= build.level(top)], z)
    field = smooth_union([limb, *_palm(build)], 0.012 * girth)
    half_width = 0.042 * girth
    low, high = (
        (-half_width, build.level(0.395), z - half_width),
        (half_width, build.level(0.80), z + half_width),
    )
    surface = polygonise(field, low, high, 0.0112 * girth, stretch=1.7)
    y, wrist = surface.vertices[:, 1], build.level(0.486)
    elbow = _below_elbow(build, surface)
    hand = 1.0 - ramp(y, wrist - 0.012 * girth, wrist + 0.012 * girth)
    by_elbow = surface.follow("upper_arm_r", "forearm_r", elbow)
    by_wrist = surface.follow("forearm_r", "hand_r", hand)
    low_part = y < 0.5 * (wrist + build.level(0.632))
    frames = np.where(low_part[:, None], by_wrist.frames, by_elbow.frames)
    arm = SkinnedPatch(surface.vertices, surface.faces, frames, np.where(low_part, hand, elbow))
    return with_mirror(merge_patches([arm, *_fingers(build)]))


def _below_elbow(build: BodyMeasures, net: Surface) -> Array:
    elbow, reach = build.level(0.632), 0.022 * build.girth
    return 1.0 - ramp(net.vertices[:, 1], elbow - reach, elbow + reach)


def _palm(build: BodyMeasures) -> list[Field]:
    g, z = build.girth, build.shoulders
    level = build.level
    palm = round_cone(
        (0.003 * g, level(0.468), z),
        (0.002 * g, level(0.436), z),
        0.0150 * g,
        0.0185 * g,
        (1.35, 1.0, 0.62),
    )
    root, tip = (
        (0.014 * g, level(0.466), z - 0.004 * g),
        (0.034 * g, level(0.432), z - 0.010 * g),
    )
    return [palm, round_cone(root, tip, 0.0098 * g, 0.0072 * g)]


def _fingers(build: BodyMeasures) -> list[SkinnedPatch]:
    g, z = build.girth, build.shoulders
    patches = []
    for ahead, knuckle, length, radius in FINGERS:
        points = [np.array([ahead * g, build.level(knuckle) + 0.006 * g, z])]
        # Three phalanges of falling length.
        for part, angle in zip((0.46, 0.31, 0.23), np.cumsum(FINGER_CURL), strict=True):
            step = np.array([0.0, -np.cos(angle), -np.sin(angle)])
            points.append(points[-1] + part * (length + 0.006) * g * step)
        radii = radius * g * np.array([1.0, 1.0, 0.92, 0.75])
        patches.append(tube(np.array(points), radii, 6).follow("hand_r"))
    return patches


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
    (0.046, -0.005, 0.028, 0.031, 0.028),
    (0.100, -0.008, 0.027, 0.031, 0.028),
    (0.190, -0.008, 0.031, 0.039, 0.033),
    (0.245, -0.004, 0.034, 0.037, 0.034),
    (0.285, 0.001, 0.036, 0.034, 0.035),
    (0.350, 0.005, 0.041, 0.038, 0.039),
    (0.430, 0.005, 0.049, 0.047, 0.046),
    (0.480, 0.003, 0.052, 0.054, 0.047),
    (0.530, 0.000, 0.038, 0.043, 0.032),
)
"""Outline of a leg in trousers."""

SHIN = (
    (0.030, -0.004, 0.020, 0.024, 0.019),
    (0.060, -0.004, 0.020, 0.023, 0.019),
    (0.110, -0.003, 0.022, 0.026, 0.022),
    (0.190, -0.007, 0.028, 0.038, 0.031),
    (0.245, -0.003, 0.031, 0.036, 0.032),
    (0.285, 0.002, 0.034, 0.032, 0.033),
    (0.340, 0.004, 0.038, 0.037, 0.037),
    (0.380, 0.004, 0.040, 0.040, 0.040),
)
"""Outline of a bare leg up to where shorts hide it."""

CROTCH_LEVEL = 0.468
LEG_SPREAD = 0.2  # of the legs while they are polygonised: thighs all but touch


@cached_part
def trousers(build: BodyMeasures, shorts: bool) -> SkinnedPatch:
    """Return trousers, or shorts, of both legs."""
    girth, end = build.girth, 0.330 if shorts else 0.046
    pelvis = oval_stack(build.outline(SEAT, build.hip_breadth))
    leg = oval_stack(build.outline(LEG), build.hips)
    if shorts:
        hem = half_space((0.0, build.level(end), 0.0), (0.0, -1.0, 0.0))
        leg = smooth_intersection(leg, hem, HEM_ROUNDING * girth)
    whole = smooth_union([pelvis, leg], 0.030 * girth)

    def spread(places: Array) -> Array:
        y, z = places[:, 1], np.abs(places[:, 2])
        return whole(np.stack([places[:, 0], y, z - _spread(build, y)], axis=-1))

    half_width = build.hips + 0.075 * girth + float(_spread(build, np.array([build.level(end)]))[0])
    low = (-0.1 * girth, build.level(end) - 0.02 * girth, -half_width)
    high = (0.1 * girth, build.level(0.64), half_width)
    surface = polygonise(
        spread, low, high, 0.0165 * girth, stretch=1.1, symmetric=True, hem=build.level(end)
    )
    places = surface.vertices.copy()
    places[:, 2] -= np.sign(places[:, 2]) * _spread(build, places[:, 1])
    return _skinned_trousers(build, places, surface)


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
    surface = polygonise(field, low, high, 0.017 * girth, stretch=1.7)
    knee = build.level(0.285)
    share = 1.0 - ramp(surface.vertices[:, 1], knee - 0.028 * girth, knee + 0.028 * girth)
    return with_mirror(surface.follow("thigh_r", "shin_r", share))


@cached_part
def shoes(build: BodyMeasures) -> SkinnedPatch:
    """Return both shoes."""
    size, z = build.proportions.foot * build.proportions.height, build.hips
    field = _shoe_field(size, z, build.level(0.050))
    low = (-0.40 * size, -0.06 * size, z - 0.30 * size)
    high = (0.85 * size, build.level(0.075), z + 0.30 * size)
    return with_mirror(polygonise(field, low, high, 0.080 * size).follow("foot_r"))


def _shoe_field(size: float, z: float, top: float) -> Field:
    """Return a right shoe, its heel behind the ankle, its toes turned out a little."""
    heel = round_cone(
        (-0.12 * size, 0.15 * size, z), (0.10 * size, 0.15 * size, z), 0.150 * size, 0.155 * size
    )
    shaft = round_cone(
        (-0.03 * size, 0.2 * size, z), (-0.03 * size, top, z), 0.150 * size, 0.125 * size
    )
    toe = (0.56 * size, 0.10 * size, z + 0.05 * size)
    vamp = round_cone(
        (0.05 * size, 0.20 * size, z), toe, 0.150 * size, 0.135 * size, (1.0, 0.85, 1.12)
    )
    ball = round_cone(
        (0.36 * size, 0.09 * size, z + 0.03 * size),
        toe,
        0.165 * size,
        0.14 * size,
        (1.0, 0.8, 1.08),
    )
    upper = smooth_union([heel, shaft, vamp, ball], 0.08 * size)
    upper = smooth_intersection(upper, half_space((0.0, top, 0.0), (0.0, 1.0, 0.0)), 0.03 * size)
    return smooth_intersection(upper, half_space((0.0, 0.0, 0.0), (0.0, -1.0, 0.0)), 0.05 * size)
