"""Arms: sleeves, bare arms, and hands with fingers."""

from __future__ import annotations

import numpy as np

from pipeline.simulation.people.build import Build
from pipeline.simulation.people.fields import (
    HEM_ROUND,
    Field,
    cone,
    grown,
    half_space,
    stack,
    united,
    within,
)
from pipeline.simulation.people.patches import Patch, Surface, both, joined, kept, polygonised, ramp
from pipeline.simulation.people.tubes import tube
from pipeline.simulation.spatial import Array

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
