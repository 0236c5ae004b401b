"""Legs: trousers or shorts, the shins below them, and shoes."""

from __future__ import annotations

import numpy as np

from pipeline.simulation.people.build import Build
from pipeline.simulation.people.fields import (
    HEM_ROUND,
    Field,
    cone,
    half_space,
    stack,
    united,
    within,
)
from pipeline.simulation.people.frames import FRAMES
from pipeline.simulation.people.patches import Patch, Surface, both, kept, polygonised, ramp
from pipeline.simulation.spatial import Array

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
