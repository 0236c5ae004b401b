"""Hand mesh: palm, thumb and fingers, at ease, and as they move to grip, to a fist, and flat.

Lengths are in girths (`BodyMeasures.girth`): X forward, from the little finger to the thumb, Y up
along the hanging hand, Z out of its back.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pipeline.simulation.face_units import HAND_SHAPES, hand_unit
from pipeline.simulation.figures.solids import vertex_normals
from pipeline.simulation.people.proportions import BodyMeasures
from pipeline.simulation.people.signed_distance import Field, ellipsoid, round_cone, smooth_union
from pipeline.simulation.people.skinned_surface import SkinnedPatch, ramp, tube
from pipeline.simulation.spatial import Array, normalized

WRIST = 0.476
"""Height from which the bones of the palm spread, as a fraction of an adult's height."""

FINGERS = (
    (0.0172, 0.4325, 0.0490, 0.0051),
    (0.0056, 0.4305, 0.0545, 0.0053),
    (-0.0060, 0.4325, 0.0505, 0.0050),
    (-0.0170, 0.4370, 0.0410, 0.0043),
)
"""From the index on: place ahead, height of the knuckle, length, radius."""

FAN = {"ease": 0.10, "grip": 0.03, "fist": 0.0, "flat": 0.16}
"""By how much the index and the little finger spread, by the shape of the hand [rad]."""

GAP_SHADE = 0.42
"""How dark fingers are on the sides of their neighbours."""

PHALANGES = (0.46, 0.31, 0.23)
"""Lengths of a finger's bones in its own."""

CURLS = {
    "ease": (0.16, 0.38, 0.30),
    "grip": (0.75, 0.85, 0.50),
    "fist": (1.45, 1.60, 0.95),
    "flat": (0.02, 0.03, 0.02),
}
"""Bend of a finger's joints by the shape of the hand [rad]."""

THUMBS = {
    "ease": ((0.0130, -0.012, -0.004), (0.0235, -0.027, -0.011), (0.0275, -0.043, -0.016)),
    "grip": ((0.0130, -0.012, -0.005), (0.0190, -0.029, -0.020), (0.0120, -0.043, -0.028)),
    "fist": ((0.0130, -0.012, -0.005), (0.0185, -0.031, -0.020), (0.0030, -0.042, -0.026)),
    "flat": ((0.0130, -0.012, -0.003), (0.0300, -0.022, -0.006), (0.0390, -0.035, -0.007)),
}
"""Joints and end of the thumb by the shape of the hand: ahead, above the wrist, outward."""

THUMB_RADII = (0.0082, 0.0072, 0.0054)

AROUND = 6
"""Vertices of a ring of a finger."""


def palm(build: BodyMeasures) -> Field:
    """Return the solid of a right palm, with the balls of thumb and little finger."""
    g, z, wrist = build.girth, build.shoulders, build.level(WRIST)
    bones = [
        round_cone(
            (0.45 * ahead * g, wrist, z),
            (ahead * g, build.level(knuckle), z),
            0.0085 * g,
            1.04 * radius * g,
        )
        for ahead, knuckle, _, radius in FINGERS
    ]
    thumb = ellipsoid(
        (0.0120 * g, wrist - 0.020 * g, z - 0.0075 * g), g * np.array([0.011, 0.018, 0.0095])
    )
    heel = ellipsoid(
        (-0.0110 * g, wrist - 0.022 * g, z - 0.0060 * g), g * np.array([0.009, 0.020, 0.0080])
    )
    return smooth_union([smooth_union(bones, 0.006 * g), thumb, heel], 0.009 * g)


def fingers(build: BodyMeasures) -> list[SkinnedPatch]:
    """Return the thumb and the fingers of a right hand, which the shapes of hands move."""
    shapes = {name: _digits(build, name) for name in CURLS}
    digits = [
        _shaped(tube(points, radii, AROUND).follow("hand_r"), moved)
        for (points, radii), moved in zip(
            shapes["ease"],
            zip(*(shapes[name] for name in HAND_SHAPES), strict=True),
            strict=True,
        )
    ]
    thumb, own = digits[0], digits[1:]
    return [thumb, *(_parted(finger, k) for k, finger in enumerate(own))]


def _parted(finger: SkinnedPatch, k: int) -> SkinnedPatch:
    """Return the finger of a number from the index on, shaded on the sides of its neighbours."""
    aside = vertex_normals(finger.vertices, finger.faces)[:, 0]
    before = ramp(aside, 0.25, 0.9) if k > 0 else np.zeros(len(aside))
    behind = ramp(-aside, 0.25, 0.9) if k < len(FINGERS) - 1 else np.zeros(len(aside))
    return replace(finger, shade=1.0 - GAP_SHADE * np.maximum(before, behind))


def _shaped(patch: SkinnedPatch, moved: tuple[tuple[Array, Array], ...]) -> SkinnedPatch:
    """Return a digit at ease with its moves to all shapes of a hand."""
    count = len(patch.vertices)
    offsets = [tube(*digit, AROUND).vertices - patch.vertices for digit in moved]
    units = [np.full(count, hand_unit(name, "r")) for name in HAND_SHAPES]
    targets = np.stack([np.tile(np.arange(count), len(units)), np.concatenate(units)], axis=-1)
    return replace(patch, targets=targets, offsets=np.concatenate(offsets))


def _digits(build: BodyMeasures, shape: str) -> list[tuple[Array, Array]]:
    """Return the lines (n, 3) [m] and radii (n,) [m] of thumb and fingers."""
    g = build.girth
    wrist = np.array([0.0, build.level(WRIST), build.shoulders])
    thumb = _rounded(wrist + g * np.array(THUMBS[shape]))
    found = [(thumb, g * np.interp(np.linspace(0, 2, len(thumb)), (0, 1, 2), THUMB_RADII))]
    for ahead, knuckle, length, radius in FINGERS:
        points = [np.array([ahead * g, build.level(knuckle) + 0.004 * g, build.shoulders])]
        # At ease the little finger is bent more than the index.
        more = 1.0 + (0.25 if shape == "ease" else 0.0) * (0.0172 - ahead) / 0.0344
        aside = np.sin(FAN[shape] * ahead / FINGERS[0][0])
        for part, angle in zip(PHALANGES, more * np.cumsum(CURLS[shape]), strict=True):
            step = normalized(np.array([aside, -np.cos(angle), -np.sin(angle)]))
            points.append(points[-1] + part * length * g * step)
        line = _rounded(np.array(points))
        taper = np.interp(np.linspace(0, 3, len(line)), (0, 1, 2, 3), (1.04, 0.98, 0.90, 0.72))
        found.append((line, radius * g * taper))
    return found


def _rounded(points: Array) -> Array:
    """Return a bent line with two points for each inner joint, so that it bends roundly."""
    rows = [points[0]]
    for before, here, after in zip(points[:-2], points[1:-1], points[2:], strict=True):
        reach = 0.22 * min(np.linalg.norm(here - before), np.linalg.norm(after - here))
        rows += [here + reach * normalized(before - here), here + reach * normalized(after - here)]
    return np.array([*rows, points[-1]])
