"""Body mesh: bare arms and hands, trousers or shorts, and bare shins."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.solids import vertex_normals
from pipeline.simulation.people.bend_creases import (
    BARE_ELBOW,
    BARE_KNEE,
    TROUSERED_KNEE,
    hinge_creases,
)
from pipeline.simulation.people.body_frames import ARM_SPREAD, FRAMES, frame_origins
from pipeline.simulation.people.cloth_folds import (
    LEG as LEG_FOLDS,
)
from pipeline.simulation.people.cloth_folds import (
    SEAM,
    SHORTS,
    fold_depth,
    fold_shade,
    folded,
    seam_depth,
    seam_shade,
)
from pipeline.simulation.people.hand_mesh import fingers, palm
from pipeline.simulation.people.proportions import BodyMeasures
from pipeline.simulation.people.signed_distance import (
    Field,
    oval_stack,
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
    symmetric_field,
    with_mirror,
)
from pipeline.simulation.people.tints import BLUSH
from pipeline.simulation.spatial import Array

ARM = (
    (0.470, 0.003, 0.0158, 0.0158, 0.0108),
    (0.486, 0.002, 0.0146, 0.0146, 0.0114),
    (0.525, 0.002, 0.0180, 0.0168, 0.0158),
    (0.585, 0.004, 0.0252, 0.0214, 0.0240),
    (0.612, 0.002, 0.0232, 0.0208, 0.0222),
    (0.632, -0.001, 0.0192, 0.0216, 0.0198),
    (0.655, 0.000, 0.0208, 0.0218, 0.0202),
    (0.695, 0.005, 0.0264, 0.0242, 0.0232),
    (0.725, 0.003, 0.0272, 0.0264, 0.0240),
    (0.745, 0.001, 0.0270, 0.0272, 0.0242),
    (0.770, 0.001, 0.0268, 0.0264, 0.0242),
)
"""Outline of a bare arm from the wrist to under the sleeve; see `BodyMeasures.outline`."""


ELBOW_REACH = 0.040
"""Distance from the elbow within which the samples of bare arms are twice as dense, in girths."""


@cached_part
def bare_arms(build: BodyMeasures, short_sleeves: bool) -> SkinnedPatch:
    """Return both hands, with the bare arms of short sleeves."""
    girth, z = build.girth, build.shoulders
    top = 0.76 if short_sleeves else 0.545
    limb = oval_stack([row for row in build.outline(ARM) if row[0] <= build.level(top)], z)
    tucked_in = _depth_between(build, SLEEVED[0] if short_sleeves else SLEEVED[1], IN_SLEEVE)
    field = smooth_union([folded(limb, tucked_in), palm(build)], 0.012 * girth)
    half_width = 0.042 * girth
    low, high = (
        (-half_width, build.level(0.395), z - half_width),
        (half_width, build.level(0.80), z + half_width),
    )
    elbow = None if not short_sleeves else (1, build.level(BARE_ELBOW.level), ELBOW_REACH * girth)
    surface = polygonise(field, low, high, 0.0092 * girth, stretch=1.7, fine=elbow)
    y, wrist = surface.vertices[:, 1], build.level(0.486)
    forearm = below_elbow(build, surface.vertices[:, 1])
    hand = 1.0 - ramp(y, wrist - 0.012 * girth, wrist + 0.012 * girth)
    by_elbow = surface.follow("upper_arm_r", "forearm_r", forearm)
    by_wrist = surface.follow("forearm_r", "hand_r", hand)
    low_part = y < 0.5 * (wrist + build.level(0.632))
    frames = np.where(low_part[:, None], by_wrist.frames, by_elbow.frames)
    normals = vertex_normals(surface.vertices, surface.faces)
    crease = hinge_creases(build, BARE_ELBOW, surface.vertices, normals, z)
    crease[low_part] = 0.0
    arm = SkinnedPatch(
        surface.vertices, surface.faces, frames, np.where(low_part, hand, forearm), crease=crease
    )
    whole = merge_patches([on_twisted_arm(build, arm), *fingers(build)])
    return with_mirror(replace(whole, tint=_flushed_arm(build, whole)))


KNUCKLES, KNUCKLE_FLUSH, ELBOW_FLUSH, HAND_FLUSH = (0.410, 0.433, 0.008), 0.75, 0.70, 0.25
"""Heights of the middle joints and of the knuckles of a hand, and how far around them it is
flushed [girths]; shares of the colour of flushed skin there, behind an elbow, and on a hand."""


def _flushed_arm(build: BodyMeasures, limb: SkinnedPatch) -> Array:
    """Return the tint (V, 2) of a bare right arm: red on hands, knuckles and elbows."""
    g, (x, y, z) = build.girth, limb.vertices.T
    *levels, reach = KNUCKLES
    hand = ramp(y, build.level(0.500), build.level(0.460))
    near = [np.exp(-(((y - build.level(one)) / (reach * g)) ** 2)) for one in levels]
    outer = ramp(z, build.shoulders - 0.004 * g, build.shoulders + 0.008 * g)
    knuckles = KNUCKLE_FLUSH * hand * outer * np.max(near, axis=0)
    elbow = np.exp(-(((y - build.level(ELBOW)) / (0.030 * g)) ** 2)) * ramp(-x / g, 0.0, 0.020)
    share = np.max([HAND_FLUSH * hand, knuckles, ELBOW_FLUSH * elbow], axis=0)
    return np.stack([np.full(len(y), float(BLUSH)), share], axis=-1)


SLEEVED, IN_SLEEVE = ((0.7115, 0.7235), (0.500, 0.512)), 0.007
"""Heights between which arms become thinner inside of short and long sleeves, and by how much, in
girths: cloth is cut off coarsely, and no skin may come through."""


def _depth_between(build: BodyMeasures, levels: tuple[float, float], most: float) -> Field:
    """Return the depth, in girths, that grows from one height to another, as a field [m]."""
    low, high = build.level(levels[0]), build.level(levels[1])

    def depth(places: Array) -> Array:
        return np.asarray(most * build.girth * ramp(places[:, 1], low, high))

    return depth


ELBOW, FOREARM_REACH = 0.632, 0.022
"""Height of the elbow of a hanging arm, and the distance from it within which the forearm's share
grows, in girths."""

TWISTED = 0.0, 0.150
"""Distances below the shoulder between which an arm takes the twist of its bone, in girths, but not
beyond the elbow: the deltoid takes little of it."""


def held_twist(build: BodyMeasures, heights: Array) -> Array:
    """Return the twist (n, 3) of places of a hanging right arm at some heights [m].

    See `SkinnedPatch.twist`.
    """
    top = frame_origins(build.proportions)[FRAMES.index("upper_arm_r"), 1]
    start, end = (share * build.girth for share in TWISTED)
    # Of a stout or short arm the forearm follows its own bone.
    end = min(end, top - build.level(ELBOW) - FOREARM_REACH * build.girth)
    share = 1.0 - ramp(top - heights, start, end)
    return share[:, None] * ARM_SPREAD


def on_twisted_arm(build: BodyMeasures, patch: SkinnedPatch) -> SkinnedPatch:
    """Return a patch of a hanging right arm that takes the twist of its bone along its length."""
    twist = held_twist(build, patch.vertices[:, 1])
    is_twisted: NDArray[np.bool_] = np.abs(twist).max(axis=1) > 0.0
    pair = [FRAMES.index("chest"), FRAMES.index("upper_arm_r")]
    return replace(
        patch,
        frames=np.where(is_twisted[:, None], pair, patch.frames),
        share=np.where(is_twisted, 1.0, patch.share),
        twist=twist,
    )


def below_elbow(build: BodyMeasures, heights: Array) -> Array:
    """Return the share (n,) of the forearm in places of a hanging arm at some heights [m]."""
    elbow, reach = build.level(ELBOW), FOREARM_REACH * build.girth
    return 1.0 - ramp(heights, elbow - reach, elbow + reach)


SEAT = (
    (0.462, 0.000, 0.038, 0.044, 0.058),
    (0.490, -0.002, 0.056, 0.064, 0.092),
    (0.525, -0.004, 0.058, 0.067, 0.094),
    (0.560, -0.003, 0.059, 0.061, 0.088),
    (0.595, 0.001, 0.056, 0.053, 0.0790),
    (0.625, 0.002, 0.048, 0.042, 0.069),
)
"""Outline of the pelvis in trousers; see `BodyMeasures.outline`."""

LEG = (
    (0.028, 0.004, 0.0450, 0.0450, 0.0405),
    (0.050, 0.000, 0.0420, 0.0430, 0.0395),
    (0.075, -0.004, 0.0375, 0.0405, 0.0380),
    (0.130, -0.006, 0.0355, 0.0400, 0.0370),
    (0.190, -0.006, 0.0355, 0.0410, 0.0370),
    (0.245, -0.003, 0.0365, 0.0385, 0.0365),
    (0.288, 0.002, 0.0385, 0.034, 0.0360),
    (0.350, 0.005, 0.042, 0.040, 0.0400),
    (0.430, 0.005, 0.049, 0.047, 0.0475),
    (0.458, 0.004, 0.051, 0.051, 0.0515),
    (0.480, 0.003, 0.052, 0.054, 0.048),
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

KNEE_REACH = 0.055
"""Distance from the knee within which the samples of trousers are twice as dense, in girths."""

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
    pelvis = oval_stack(build.outline(SEAT, build.hip_breadth * build.waisted(SEAT)))
    leg = oval_stack(build.outline(LEG), build.hips)
    depth = fold_depth(build, SHORTS if shorts else LEG_FOLDS, build.hips)
    solid = smooth_union([pelvis, leg], 0.030 * girth)
    if covered:
        solid = folded(solid, _depth_between(build, COVERED, COVERED_DEPTH))
    hem = build.level(end)
    whole = folded(folded(solid, depth), seam_depth(build, hem))

    def spread(places: Array) -> Array:
        y, z = places[:, 1], np.abs(places[:, 2])
        return whole(np.stack([places[:, 0], y, z - _spread(build, y)], axis=-1))

    half_width = build.hips + 0.075 * girth + float(_spread(build, np.array([build.level(end)]))[0])
    low = (-0.1 * girth, build.level(end), -half_width)
    high = (0.1 * girth, build.level(0.64), half_width)
    surface = polygonise(
        spread,
        low,
        high,
        0.0163 * girth,
        stretch=0.88,
        symmetric=True,
        hem=hem,
        seam=SEAM * girth,
        fine=(1, build.level(TROUSERED_KNEE.level), KNEE_REACH * girth),
    )
    places = surface.vertices.copy()
    places[:, 2] -= np.sign(places[:, 2]) * _spread(build, places[:, 1])
    shade = fold_shade(build, symmetric_field(depth), places)
    shade = shade * seam_shade(build, hem, places[:, 1])
    # Thighs shade one another.
    between = ramp(np.abs(places[:, 2]), 0.036 * girth, 0.008 * girth)
    below = ramp(places[:, 1], build.level(0.500), build.level(0.450))
    shade = shade * (1.0 - CROTCH_SHADE * between * below)
    patch = replace(_skinned_trousers(build, places, surface), shade=shade)
    if shorts:
        return patch
    return replace(patch, crease=_knee_creases(build, patch))


def _knee_creases(build: BodyMeasures, patch: SkinnedPatch) -> Array:
    """Return by how much trousers move where knees are bent (n, 3) [m]."""
    side = np.where(patch.vertices[:, 2:] < 0.0, MIRROR, 1.0)
    normals = side * vertex_normals(patch.vertices, patch.faces)
    moves = hinge_creases(build, TROUSERED_KNEE, side * patch.vertices, normals, build.hips)
    on_leg = (patch.frames[:, 0] != FRAMES.index("pelvis"))[:, None]
    return np.where(on_leg, side * moves, 0.0)


COVERED, COVERED_DEPTH = (0.365, 0.415), 0.016
"""Heights between which thighs become thinner below a coat, and by how much, in girths."""


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
    patch = surface.follow("thigh_r", "shin_r", share)
    normals = vertex_normals(patch.vertices, patch.faces)
    crease = hinge_creases(build, BARE_KNEE, patch.vertices, normals, z)
    return with_mirror(replace(patch, crease=crease, tint=_flushed_shin(build, patch)))


KNEE_FLUSH, FOOT_FLUSH = 0.70, 0.30
"""Shares of the colour of flushed skin on a bare knee and above a foot."""


def _flushed_shin(build: BodyMeasures, limb: SkinnedPatch) -> Array:
    """Return the tint (V, 2) of a bare leg: red on the knee and towards the foot."""
    g, (x, y, _) = build.girth, limb.vertices.T
    knee = np.exp(-(((y - build.level(0.292)) / (0.028 * g)) ** 2)) * ramp(x / g, 0.0, 0.028)
    foot = ramp(y, build.level(0.150), build.level(0.050))
    share = np.maximum(KNEE_FLUSH * knee, FOOT_FLUSH * foot)
    return np.stack([np.full(len(y), float(BLUSH)), share], axis=-1)
