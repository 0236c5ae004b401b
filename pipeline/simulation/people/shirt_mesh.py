"""Shirt mesh: the cloth of trunk and arms, one surface from hem and cuffs to the collar.

It is modelled with the arms spread half way, as far from hanging as from reaching up, and then let
down: skinning takes each arm from there to where it is with the least bend of the shoulder.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.solids import vertex_normals
from pipeline.simulation.people.bend_creases import SLEEVED_ELBOW, hinge_creases
from pipeline.simulation.people.body_frames import FRAMES, frame_origins
from pipeline.simulation.people.body_mesh import ARM, below_elbow, held_twist
from pipeline.simulation.people.cloth_folds import (
    SEAM,
    SHIRT,
    SHORT_SLEEVE,
    SLEEVE,
    HangingFolds,
    fold_depth,
    fold_shade,
    folded,
    seam_depth,
    seam_shade,
)
from pipeline.simulation.people.proportions import BodyMeasures
from pipeline.simulation.people.signed_distance import (
    Field,
    ellipsoid,
    half_space,
    oval_stack,
    round_cone,
    smooth_intersection,
    smooth_union,
)
from pipeline.simulation.people.skinned_surface import (
    MIRROR,
    MIRRORED_FRAMES,
    SkinnedPatch,
    angle_around,
    cached_part,
    polygonise,
    ramp,
    symmetric_field,
)
from pipeline.simulation.spatial import Array

TORSO = (
    (0.490, -0.003, 0.0710, 0.0800, 0.1095),
    (0.520, -0.003, 0.0705, 0.0795, 0.1090),
    (0.545, -0.003, 0.0705, 0.0765, 0.1090),
    (0.570, -0.002, 0.0680, 0.0700, 0.1000),
    (0.590, 0.000, 0.0655, 0.0640, 0.0930),
    (0.605, 0.001, 0.0645, 0.0610, 0.0905),
    (0.640, 0.002, 0.0630, 0.0565, 0.0885),
    (0.680, 0.002, 0.0645, 0.0585, 0.0905),
    (0.720, 0.003, 0.0680, 0.0615, 0.0945),
    (0.755, 0.002, 0.0675, 0.0635, 0.0965),
    (0.782, -0.002, 0.0585, 0.0585, 0.0915),
    (0.808, -0.006, 0.046, 0.048, 0.068),
    (0.824, -0.009, 0.037, 0.040, 0.046),
    (0.834, -0.010, 0.034, 0.037, 0.037),
)
"""Outline of chest and waist in a shirt, from its hem to its collar; see `BodyMeasures.outline`."""

SHIRT_HEM, TUCKED_HEM = 0.520, 0.590  # heights

DRAPE, DRAPES, DRAPE_TOP, UNEVEN, STIFF = 0.0042, 6, 0.640, 1.3, 0.3
"""Depth of the folds of a free hem, in girths, their number, the height at which they begin, how
unlike they are, and the share of them that jackets have."""

HEM_WAVE, WAVE_LEVELS = 0.0028, (0.575, 0.540)
"""By how much a free hem runs up and down, in girths, and heights between which cloth does so."""
SHOULDER_RADIUS = 0.0255


SPREAD = np.radians(60.0)
"""By how much the right arm is lifted aside while a shirt is modelled."""

JOINED, CUT_EDGE = 0.030, 0.004
"""Distances over which trunk and sleeves round into each other, and the end of a sleeve, in girths.
"""

SHOULDER, LOOSE = (-0.050, 0.020), 0.045
"""Between which places along the arm cloth goes from the chest to it, and the distance from the
trunk from which it follows the arm alone, in girths."""

DRAWN, BESIDE = 0.022, (0.105, 0.045)
"""Depth of the trunk from which cloth is drawn along by an arm, and the distances from the shoulder
between which that comes about, in girths: less would fold it into itself before the chest."""

SUNK, SLOPE = 0.010, (0.045, 0.020)
"""By how much shoulders are lower with the arms let down, and the distances from the joint, to the
neck and outward, between which that comes about, in girths: letting down heaps cloth up there."""

LIFTED, LIFT_START, LIFT_LEVELS, LIFT_END = 0.016, (0.030, 0.090), (0.750, 0.790), (1.0, 0.85)
"""By how much a shoulder rises with an arm that is lifted by a right angle, the places beside the
neck between which that begins, both in girths; heights between which it comes about, and the shares
of the arm between which it ends."""

SLEEVE_THICKNESS = 0.0036
"""Of a sleeve with the air in it where it lies on the arm, in girths."""

CELL, ELBOW_REACH = 0.0120, 0.050
"""Distance of the samples of a shirt, and from an elbow within which they are twice as dense, in
girths."""

Sleeve = Literal["short", "cuffed", "straight"]
"""How sleeves end: above the elbow, gathered by a cuff, or wide at the wrist."""

SLEEVE_ENDS: Mapping[Sleeve, float] = {"short": 0.7112, "cuffed": 0.5030, "straight": 0.5070}
"""Heights of the ends of sleeves that hang, within their bands, as fractions of an adult's height.
"""

AIR: Mapping[Sleeve, tuple[tuple[float, ...], tuple[float, ...]]] = {
    "short": ((0.703, 0.730, 0.770), (0.0165, 0.0115, 0.0050)),
    "cuffed": ((0.515, 0.524, 0.545, 0.600, 0.640), (0.0030, 0.0072, 0.0090, 0.0052, 0.0036)),
    "straight": ((0.500, 0.540, 0.600, 0.640), (0.0085, 0.0075, 0.0048, 0.0036)),
}
"""Heights along sleeves, and how far they stand off the arm there, in girths."""


def sleeve_air(build: BodyMeasures, sleeve: Sleeve, heights: Array) -> Array:
    """Return how far a sleeve stands off the arm at some heights (n,), in girths."""
    levels, away = AIR[sleeve]
    return np.interp(heights, build.levels(np.array(levels)), away)


@cached_part
def shirt(build: BodyMeasures, sleeve: Sleeve, tucked: bool = False) -> SkinnedPatch:
    """Return a shirt: its trunk between pelvis and chest, and its sleeves."""
    g, hem = build.girth, build.level(TUCKED_HEM if tucked else SHIRT_HEM)
    end, short_sleeves = build.level(SLEEVE_ENDS[sleeve]), sleeve == "short"
    joint = frame_origins(build.proportions)[FRAMES.index("upper_arm_r")]
    trunk = symmetric_field(shirt_field(build))
    gathers = symmetric_field(fold_depth(build, SHIRT, 0.0))
    stiff = STIFF if sleeve == "straight" else 1.0
    most = 0.0 if tucked else stiff * DRAPE * g
    hanging_folds = HangingFolds(build.level(DRAPE_TOP), hem, DRAPES, most, UNEVEN)

    def trunk_folds(places: Array) -> Array:
        return gathers(places) + hanging_folds.depth(places)

    arm_folds = fold_depth(build, SHORT_SLEEVE if short_sleeves else SLEEVE, build.shoulders)
    arm = folded(_sleeve_field(build, sleeve, end), arm_folds)

    def spread_sleeve(places: Array) -> Array:
        return arm(_swung(places, joint, -SPREAD))

    hemmed = folded(folded(trunk, trunk_folds), seam_depth(build, hem))
    whole = smooth_union([hemmed, spread_sleeve], JOINED * g)
    wide = joint[2] + (joint[1] - end) * np.sin(SPREAD) + 0.05 * g
    low, high = (-0.1 * g, hem, -wide), (0.1 * g, build.level(0.90), wide)
    elbow = joint[2] + (joint[1] - build.level(SLEEVED_ELBOW.level)) * np.sin(SPREAD)
    fine = None if short_sleeves else (2, elbow, ELBOW_REACH * g)
    net = polygonise(whole, low, high, CELL * g, symmetric=True, hem=hem, fine=fine, seam=SEAM * g)
    side = np.where(net.vertices[:, 2:] < 0.0, MIRROR, 1.0)
    spread = side * net.vertices
    straight = _swung(spread, joint, -SPREAD)
    along = (joint[1] - straight[:, 1]) / g
    near = ramp(np.linalg.norm(spread - joint, axis=-1) / g, *BESIDE)
    # Ridges of a hem lie off the trunk, and follow no arm.
    away = (trunk(spread) + hanging_folds.depth(spread)) / g
    pull = ramp(along, *SHOULDER) * ramp(away, -DRAWN * near, LOOSE)
    # Dual quaternions turn cloth that follows two frames by this angle.
    half = 0.5 * SPREAD
    turned = 2.0 * np.arctan2(pull * np.sin(half), 1.0 - pull + pull * np.cos(half))
    hanging = _swung(spread, joint, -turned)
    hanging[:, 1] -= _slope(build, hanging)
    if not tucked:
        hanging[:, 1] += stiff * hem_rise(build, hanging)
    frames, share, twist = _followed(build, hanging, straight, pull)
    by_trunk = fold_shade(build, trunk_folds, spread)
    shade = by_trunk + pull * (fold_shade(build, arm_folds, straight) - by_trunk)
    edge = 1.0 - (1.0 - pull) * (1.0 - seam_shade(build, hem, spread[:, 1]))
    normals = side * vertex_normals(side * hanging, net.faces)
    crease = np.zeros_like(hanging)
    if not short_sleeves:
        bent = hinge_creases(build, SLEEVED_ELBOW, straight, normals, build.shoulders)
        crease = (pull >= 1.0)[:, None] * bent
    crease[:, 1] += _lift(build, hanging) * ramp(pull, *LIFT_END)
    return SkinnedPatch(
        side * hanging,
        net.faces,
        np.where(side[:, 2:] < 0.0, MIRRORED_FRAMES[frames], frames),
        share,
        shade=shade * _armpit_shade(build, hanging, pull) * edge,
        crease=side * crease,
        twist=side * twist,
    )


def hem_rise(build: BodyMeasures, places: Array) -> Array:
    """Return by how much places (n, 3) of a free hem are higher [m]: at the sides, and in waves."""
    around = angle_around(places)
    near = ramp(places[:, 1], *(build.level(level) for level in WAVE_LEVELS))
    wave = 0.55 * np.sin(5.0 * around + 0.8) - np.cos(2.0 * around)
    return HEM_WAVE * build.girth * near * wave


def _swung(places: Array, joint: Array, angle: float | Array) -> Array:
    """Return places (n, 3) turned about a joint (3,), outward where the angle is positive."""
    x, y, z = (places - joint).T
    c, s = np.cos(angle), np.sin(angle)
    return joint + np.stack([x, c * y + s * z, c * z - s * y], axis=-1)


def _slope(build: BodyMeasures, hanging: Array) -> Array:
    """Return by how much cloth (n,) is lower [m] where the shoulder of a hanging arm slopes."""
    g, y, z = build.girth, hanging[:, 1], hanging[:, 2]
    aside = ramp(z, build.shoulders - SLOPE[0] * g, build.shoulders + SLOPE[1] * g)
    return SUNK * g * aside * ramp(y, build.level(0.760), build.level(0.815))


def _lift(build: BodyMeasures, hanging: Array) -> Array:
    """Return by how much cloth (n,) rises with the shoulder of a lifted arm [m]."""
    g, y, z = build.girth, hanging[:, 1], hanging[:, 2]
    low, high = (build.level(level) for level in LIFT_LEVELS)
    return LIFTED * g * ramp(z / g, *LIFT_START) * ramp(y, low, high)


def _followed(
    build: BodyMeasures, hanging: Array, straight: Array, pull: Array
) -> tuple[NDArray[np.int64], Array, Array]:
    """Return what places of the right side follow: two frames (n, 2), and the second's share.

    The last is the twist (n, 3) of `SkinnedPatch`.

    Args:
        build: measures of the person.
        hanging: (n, 3) places at rest [m].
        straight: (n, 3) places as if they all followed the arm alone [m].
        pull: (n,) share of the upper arm, against the chest.
    """
    pelvis, chest, upper, fore = (
        FRAMES.index(name) for name in ("pelvis", "chest", "upper_arm_r", "forearm_r")
    )
    up, bent = chest_share(build, hanging[:, 1]), below_elbow(build, straight[:, 1])
    held = held_twist(build, straight[:, 1])
    is_arm = (pull >= 1.0) & ~held.any(axis=1)
    # Where nothing follows the arm, it may still lift the cloth.
    is_shoulder = ~is_arm & ((pull > 0.0) | (up >= 1.0))
    first = np.where(is_arm, upper, np.where(is_shoulder, chest, pelvis))
    second = np.where(is_arm, fore, np.where(is_shoulder, upper, chest))
    share = np.where(is_arm, bent, np.where(is_shoulder, pull, up))
    return np.stack([first, second], axis=-1), share, np.where(is_shoulder[:, None], held, 0.0)


def _armpit_shade(build: BodyMeasures, hanging: Array, pull: Array) -> Array:
    """Return the shade (n,) where sleeves hang beside the chest."""
    g, y, z = build.girth, hanging[:, 1], hanging[:, 2]
    chest = ramp(y, build.level(0.66), build.level(0.76))
    chest = chest * ramp(y, build.level(0.815), build.level(0.78)) * ramp(z, 0.065 * g, 0.090 * g)
    inner = ramp(z, build.shoulders, build.shoulders - 0.022 * g)
    arm = inner * ramp(y, build.level(0.64), build.level(0.76))
    return 1.0 - ARMPIT_SHADE * (chest + pull * (arm - chest))


ARMPIT_SHADE = 0.30
"""How dark a shirt is under the arms, and a sleeve beside the chest."""


def _sleeve_field(build: BodyMeasures, sleeve: Sleeve, end: float) -> Field:
    """Return the solid of the right sleeve, hanging, down to a height [m]."""
    g, z, top = build.girth, build.shoulders, build.level(0.818)
    bare = oval_stack(build.outline(ARM), z)

    def arm(places: Array) -> Array:
        return np.asarray(bare(places) - g * sleeve_air(build, sleeve, places[:, 1]))

    # The deltoid stands out beside the joint, and ends in a hollow above the biceps.
    shoulder = round_cone(
        (-0.001 * g, top - 0.0155 * g, z - 0.005 * g),
        (0.002 * g, top - 0.054 * g, z + 0.0005 * g),
        0.0205 * g,
        0.0245 * g,
    )
    above = half_space((0.0, end, z), (0.0, -1.0, 0.0))
    return smooth_intersection(smooth_union([arm, shoulder], 0.02 * g), above, CUT_EDGE * g)


NARROWER_CHEST = 0.04
"""By how much the chest above a bust is narrower."""

BUST, BUST_RADII = (0.024, 0.7285, 0.0405), (0.0475, 0.0430, 0.0445)
"""Middle of a bust, ahead in girths, its height, and aside; and its radii, in girths."""


def shirt_field(build: BodyMeasures) -> Field:
    """Return the solid of a trunk in a shirt, from below its hem to its collar."""
    girth, curves = build.girth, build.curves
    torso = oval_stack(build.outline(TORSO, torso_breadths(build)))
    if curves > 0.0:
        ahead, level, aside = BUST
        radii = girth * curves * np.array(BUST_RADII)
        middle = np.array([ahead * girth, build.level(level), aside * girth])
        bust = [ellipsoid(middle * m, radii) for m in (1.0, MIRROR)]
        # Cloth spans the hollow between.
        torso = smooth_union([torso, smooth_union(bust, 0.06 * girth)], 0.030 * girth)
    # The trapezius slopes down from the sides of the neck to the shoulders.
    neck = np.array([-0.014 * girth, build.level(0.826), 0.024 * girth])
    tip = np.array([0.0, build.level(0.797), build.shoulders - 0.010 * girth])
    right, left = (
        round_cone(neck * m, tip * m, 0.026 * girth, SHOULDER_RADIUS * girth) for m in (1.0, MIRROR)
    )
    return smooth_union([torso, right, left], 0.035 * girth)


def chest_share(build: BodyMeasures, heights: Array) -> Array:
    """Return the share (n,) of the chest, against the pelvis, in cloth at some heights [m]."""
    return ramp(heights, build.level(0.585), build.level(0.70))


def torso_breadths(build: BodyMeasures) -> Array:
    """Return the breadth factor of each row of a shirt, from the hips to the chest."""
    levels = np.array([row[0] for row in TORSO])
    up = ramp(levels, 0.56, 0.70)
    chest = build.shoulder_breadth * (1.0 - NARROWER_CHEST * build.curves)
    return build.waisted(TORSO) * (build.hip_breadth + up * (chest - build.hip_breadth))
