"""Trunk: the shirt's body, its sleeves apart.

A shoulder turns farther than any other joint: what hangs on it is a ball inside the sleeve,
which no turn of the arm uncovers.
"""

from __future__ import annotations

import numpy as np

from pipeline.simulation.people.build import Build
from pipeline.simulation.people.fields import HEM_ROUND, cone, half_space, stack, united, within
from pipeline.simulation.people.patches import MIRROR, Patch, kept, polygonised, ramp
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
