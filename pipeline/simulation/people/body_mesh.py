"""Body mesh."""

from __future__ import annotations

import numpy as np

from pipeline.simulation.people.body_frames import FRAMES
from pipeline.simulation.people.proportions import Build
from pipeline.simulation.people.signed_distance import (
    HEM_ROUND,
    Field,
    cone,
    grown,
    half_space,
    stack,
    united,
    within,
)
from pipeline.simulation.people.skinned_surface import (
    MIRROR,
    Patch,
    Surface,
    both,
    joined,
    kept,
    polygonised,
    ramp,
    tube,
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
"""Outline of chest and waist in a shirt, from its hem to its collar; see `Build.outline`."""

HEM = 0.520
"""Height of its hem."""

YOKE = 0.0255
"""Radius of the shoulders."""


@kept
def shirt(build: Build) -> Patch:
    """Return the body of a shirt, between pelvis and chest."""
    girth = build.girth
    torso = stack(build.outline(TORSO, _breadths(build)))
    neck = np.array([-0.008 * girth, build.level(0.832), 0.02 * girth])
    tip = np.array([0.0, build.level(0.811), build.shoulders - 0.006 * girth])
    right, left = (cone(neck * m, tip * m, 0.030 * girth, YOKE * girth) for m in (1.0, MIRROR))
    hem = half_space((0.0, build.level(HEM), 0.0), (0.0, -1.0, 0.0))
    field = within(united([torso, right, left], 0.035 * girth), hem, HEM_ROUND * girth)
    wide = build.shoulders + 0.05 * girth
    low = (-0.1 * girth, build.level(0.49), -wide)
    high = (0.1 * girth, build.level(0.87), wide)
    net = polygonised(
        field, low, high, 0.0180 * girth, stretch=1.2, symmetric=True, hem=build.level(HEM)
    )
    share = ramp(net.vertices[:, 1], build.level(0.585), build.level(0.70))
    return net.follow("pelvis", "chest", share)


def _breadths(build: Build) -> Array:
    """Return how much wider each row of a shirt is: over the hips as wide as they need it."""
    heights = np.array([row[0] for row in TORSO])
    up = ramp(heights, 0.56, 0.70)
    result: Array = build.hip_breadth + up * (build.shoulder_breadth - build.hip_breadth)
    return result


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
"""Outline of a bare arm from the wrist to under the sleeve; see `Build.outline`."""

SLEEVE = 0.0042
"""Thickness of a sleeve, with the air in it."""

FINGERS = (
    (0.0225, 0.430, 0.040, 0.0073),
    (0.0085, 0.426, 0.046, 0.0076),
    (-0.0055, 0.428, 0.043, 0.0073),
    (-0.0185, 0.434, 0.034, 0.0064),
)
"""Of each finger, from the index on: place ahead, height of its knuckle, length and radius."""

CURL = (0.10, 0.45, 0.75)
"""How far the joints of a finger are bent [rad] at ease."""


@kept
def sleeves(build: Build, short: bool) -> Patch:
    """Return both sleeves, each beginning as a ball around its shoulder."""
    girth, z = build.girth, build.shoulders
    top = build.level(0.818)
    arm = grown(stack(build.outline(ARM), z), SLEEVE * girth)
    shoulder = cone(
        (0.0, top - 0.007 * girth, z - 0.003 * girth),
        (0.002 * girth, top - 0.065 * girth, z),
        0.0250 * girth,
        0.0280 * girth,
    )
    end = build.level(0.715 if short else 0.500)
    field = united([arm, shoulder], 0.02 * girth)
    field = within(field, half_space((0.0, end, 0.0), (0.0, -1.0, 0.0)), HEM_ROUND * girth)
    wide = 0.045 * girth
    low, high = (-wide, end - 0.02 * girth, z - wide), (wide, top + 0.045 * girth, z + wide)
    net = polygonised(field, low, high, 0.0150 * girth, stretch=1.0 if short else 1.5, hem=end)
    return both(net.follow("upper_arm_r", "forearm_r", _below_elbow(build, net)))


@kept
def arms(build: Build, short: bool) -> Patch:
    """Return both hands, with as much of the arms as short sleeves show."""
    girth, z = build.girth, build.shoulders
    top = 0.76 if short else 0.545
    limb = stack([row for row in build.outline(ARM) if row[0] <= build.level(top)], z)
    field = united([limb, *_palm(build)], 0.012 * girth)
    wide = 0.042 * girth
    low, high = (
        (-wide, build.level(0.395), z - wide),
        (wide, build.level(0.80), z + wide),
    )
    net = polygonised(field, low, high, 0.0112 * girth, stretch=1.7)
    y, wrist = net.vertices[:, 1], build.level(0.486)
    elbow = _below_elbow(build, net)
    hand = 1.0 - ramp(y, wrist - 0.012 * girth, wrist + 0.012 * girth)
    by_elbow = net.follow("upper_arm_r", "forearm_r", elbow)
    by_wrist = net.follow("forearm_r", "hand_r", hand)
    low_part = y < 0.5 * (wrist + build.level(0.632))
    frames = np.where(low_part[:, None], by_wrist.frames, by_elbow.frames)
    arm = Patch(net.vertices, net.faces, frames, np.where(low_part, hand, elbow))
    return both(joined([arm, *_fingers(build)]))


def _below_elbow(build: Build, net: Surface) -> Array:
    elbow, reach = build.level(0.632), 0.022 * build.girth
    return 1.0 - ramp(net.vertices[:, 1], elbow - reach, elbow + reach)


def _palm(build: Build) -> list[Field]:
    """Return the palm and the thumb of a right hand, the palm turned to the thigh."""
    g, z = build.girth, build.shoulders
    level = build.level
    palm = cone(
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
    return [palm, cone(root, tip, 0.0098 * g, 0.0072 * g)]


def _fingers(build: Build) -> list[Patch]:
    g, z = build.girth, build.shoulders
    made = []
    for ahead, knuckle, length, radius in FINGERS:
        place = np.array([ahead * g, build.level(knuckle) + 0.006 * g, z])
        points = [place]
        # Three phalanges of falling length.
        for part, angle in zip((0.46, 0.31, 0.23), np.cumsum(CURL), strict=True):
            step = np.array([0.0, -np.cos(angle), -np.sin(angle)])
            points.append(points[-1] + part * (length + 0.006) * g * step)
        radii = radius * g * np.array([1.0, 1.0, 0.92, 0.75])
        made.append(tube(np.array(points), radii, 6).follow("hand_r"))
    return made


SEAT = (
    (0.462, 0.000, 0.038, 0.044, 0.058),
    (0.490, -0.002, 0.056, 0.064, 0.088),
    (0.525, -0.004, 0.058, 0.068, 0.093),
    (0.560, -0.003, 0.058, 0.060, 0.090),
    (0.595, 0.001, 0.055, 0.050, 0.081),
    (0.625, 0.002, 0.053, 0.047, 0.076),
)
"""Outline of the pelvis in trousers; see `Build.outline`."""

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

CROTCH = 0.468
"""Where legs part."""

APART = 0.2
"""How much legs are spread to be polygonised: thighs all but touch."""


@kept
def trousers(build: Build, short: bool) -> Patch:
    """Return trousers, or shorts, of both legs."""
    girth, end = build.girth, 0.330 if short else 0.046
    pelvis = stack(build.outline(SEAT, build.hip_breadth))
    leg = stack(build.outline(LEG), build.hips)
    if short:
        hem = half_space((0.0, build.level(end), 0.0), (0.0, -1.0, 0.0))
        leg = within(leg, hem, HEM_ROUND * girth)
    whole = united([pelvis, leg], 0.030 * girth)

    def spread(places: Array) -> Array:
        y, z = places[:, 1], np.abs(places[:, 2])
        return whole(np.stack([places[:, 0], y, z - _spread(build, y)], axis=-1))

    wide = build.hips + 0.075 * girth + float(_spread(build, np.array([build.level(end)]))[0])
    low = (-0.1 * girth, build.level(end) - 0.02 * girth, -wide)
    high = (0.1 * girth, build.level(0.64), wide)
    net = polygonised(
        spread, low, high, 0.0165 * girth, stretch=1.1, symmetric=True, hem=build.level(end)
    )
    places = net.vertices.copy()
    places[:, 2] -= np.sign(places[:, 2]) * _spread(build, places[:, 1])
    return _hung(build, places, net)


def _spread(build: Build, y: Array) -> Array:
    below = np.maximum(build.level(CROTCH) - y, 0.0)
    result: Array = APART * below * below / (below + 0.03 * build.girth)
    return result


def _hung(build: Build, places: Array, net: Surface) -> Patch:
    """Return the surface of legs between pelvis, thighs and shins."""
    x, y, z = places.T
    girth = build.girth
    right = z > 0.0
    # The groin runs upward to the outside, and lies lower behind than before.
    groin = build.level(0.475) + 0.8 * np.abs(z) + 0.3 * x
    thigh = 1.0 - ramp(y, groin - 0.060 * girth, groin + 0.048 * girth)
    # Between the legs, above where they part, trousers follow neither.
    inner = 1.0 - ramp(y, build.level(0.375), build.level(0.425))
    thigh = thigh * np.maximum(inner, ramp(np.abs(z), 0.0, 0.020 * girth))
    knee = build.level(0.285)
    shin = 1.0 - ramp(y, knee - 0.038 * girth, knee + 0.038 * girth)
    lower = y < 0.5 * (knee + build.level(CROTCH))
    sides = [
        np.where(right, FRAMES.index(f"{n}_r"), FRAMES.index(f"{n}_l")) for n in ("thigh", "shin")
    ]
    first = np.where(lower, sides[0], FRAMES.index("pelvis"))
    second = np.where(lower, sides[1], sides[0])
    frames = np.stack([first, second], axis=-1)
    return Patch(places, net.faces, frames, np.where(lower, shin, thigh))


@kept
def shins(build: Build) -> Patch:
    """Return the bare legs below shorts."""
    girth, z = build.girth, build.hips
    field = stack(build.outline(SHIN), z)
    wide = 0.045 * girth
    low = (-wide - 0.01 * girth, build.level(0.02), z - wide)
    high = (wide + 0.01 * girth, build.level(0.39), z + wide)
    net = polygonised(field, low, high, 0.017 * girth, stretch=1.7)
    knee = build.level(0.285)
    share = 1.0 - ramp(net.vertices[:, 1], knee - 0.028 * girth, knee + 0.028 * girth)
    return both(net.follow("thigh_r", "shin_r", share))


@kept
def shoes(build: Build) -> Patch:
    """Return both shoes."""
    size, z = build.proportions.foot * build.proportions.height, build.hips
    field = _shoe(size, z, build.level(0.050))
    low = (-0.40 * size, -0.06 * size, z - 0.30 * size)
    high = (0.85 * size, build.level(0.075), z + 0.30 * size)
    return both(polygonised(field, low, high, 0.080 * size).follow("foot_r"))


def _shoe(size: float, z: float, top: float) -> Field:
    """Return a right shoe, its heel behind the ankle, its toes turned out a little."""
    heel = cone(
        (-0.12 * size, 0.15 * size, z), (0.10 * size, 0.15 * size, z), 0.150 * size, 0.155 * size
    )
    shaft = cone((-0.03 * size, 0.2 * size, z), (-0.03 * size, top, z), 0.150 * size, 0.125 * size)
    toe = (0.56 * size, 0.10 * size, z + 0.05 * size)
    vamp = cone((0.05 * size, 0.20 * size, z), toe, 0.150 * size, 0.135 * size, (1.0, 0.85, 1.12))
    ball = cone(
        (0.36 * size, 0.09 * size, z + 0.03 * size),
        toe,
        0.165 * size,
        0.14 * size,
        (1.0, 0.8, 1.08),
    )
    upper = united([heel, shaft, vamp, ball], 0.08 * size)
    upper = within(upper, half_space((0.0, top, 0.0), (0.0, 1.0, 0.0)), 0.03 * size)
    return within(upper, half_space((0.0, 0.0, 0.0), (0.0, -1.0, 0.0)), 0.05 * size)
