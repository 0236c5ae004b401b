"""Trunk: the shirt's body, its sleeves apart.

A shoulder turns farther than any other joint: what hangs on it is a ball inside the sleeve,
which no turn of the arm uncovers.
"""

from __future__ import annotations

from pipeline.simulation.people.build import Build
from pipeline.simulation.people.fields import cone, stack, united
from pipeline.simulation.people.patches import Patch, polygonised, ramp

TORSO = (
    (0.528, -0.002, 0.070, 0.075, 0.106),
    (0.560, -0.002, 0.069, 0.071, 0.103),
    (0.600, 0.001, 0.066, 0.062, 0.095),
    (0.640, 0.002, 0.064, 0.057, 0.088),
    (0.680, 0.002, 0.066, 0.059, 0.089),
    (0.720, 0.003, 0.070, 0.062, 0.094),
    (0.755, 0.002, 0.070, 0.064, 0.098),
    (0.790, -0.002, 0.061, 0.060, 0.095),
    (0.815, -0.005, 0.048, 0.052, 0.080),
    (0.838, -0.008, 0.038, 0.040, 0.048),
    (0.848, -0.008, 0.036, 0.038, 0.042),
)
"""Outline of chest and waist in a shirt, from its hem to its collar; see `Build.outline`."""

YOKE = 0.032
"""Radius of the shoulders."""


def shirt(build: Build) -> Patch:
    """Return the body of a shirt, between pelvis and chest."""
    girth = build.girth
    torso = stack(build.outline(TORSO, build.shoulder_breadth))
    neck = (-0.008 * girth, float(build.level(0.822)), 0.03 * girth)
    tip = (0.0, float(build.level(0.814)), build.shoulders - 0.002 * girth)
    yoke = [cone(neck, (x, y, z * side), 0.034 * girth, YOKE * girth) for side in (1, -1) for x, y, z in [tip]]
    mirrored = cone((neck[0], neck[1], -neck[2]), (tip[0], tip[1], -tip[2]), 0.034 * girth, YOKE * girth)
    field = united([torso, yoke[0], mirrored], 0.035 * girth)
    wide = build.shoulders + 0.05 * girth
    low = (-0.1 * girth, float(build.level(0.51)), -wide)
    high = (0.1 * girth, float(build.level(0.87)), wide)
    net = polygonised(field, low, high, 0.0145 * girth, stretch=1.2, symmetric=True)
    share = ramp(net.vertices[:, 1], float(build.level(0.585)), float(build.level(0.70)))
    return net.follow("pelvis", "chest", share)
