"""Features: by how much the face of a person differs from the mean one.

Lengths are in heads, from the middle of the head: X forward, Y up, Z to the right.
"""

from __future__ import annotations

from dataclasses import astuple, dataclass, replace

import numpy as np

from pipeline.simulation.people.skinned_surface import SkinnedPatch, ramp
from pipeline.simulation.spatial import Array

GREATEST = 1.7
"""Greatest deviation, in standard ones: beyond it a face is a caricature."""

BEARDED = 0.45
"""Share of those who may have a beard, or the stubble of one."""

WIDTH, JAW, CHIN = 0.030, 0.055, 0.016
"""Standard deviation of the breadths of head and jaw, and of the length of the chin."""

NOSE_WIDTH, NOSE_LENGTH, NOSE_DROP = 0.16, 0.009, 0.011
"""Standard deviation of breadth and length of a nose, and of the height of its tip."""

BROW, CHEEKS, LIPS = 0.009, 0.011, 0.008
"""Standard deviation of how far brows, cheeks and lips stand out."""

SKEW = 0.007
"""Standard deviation of how far nose and mouth lie aside, and of how much higher one corner is."""

NECK_TOP, NECK_END = -0.42, -0.56
"""Heights between which the deviations end: necks fit collars."""


@dataclass(frozen=True, slots=True)
class Features:
    """Deviations of a face from the mean one, in standard ones, and its beard.

    Attributes:
        width: breadth of the head.
        jaw: breadth of the jaw.
        chin: length of the chin.
        nose_width: breadth of the nose.
        nose_length: by how much it stands out.
        nose_drop: by how much its tip is lower.
        brow: by how much the ridge of the brows stands out.
        cheeks: by how much the cheeks stand out.
        lips: by how much the lips stand out.
        skew: to the right.
        parting: of the hair, -1 on the left, 1 on the right.
        beard: share of the colour of hair on chin and lip, 0 to 1.
    """

    width: float = 0.0
    jaw: float = 0.0
    chin: float = 0.0
    nose_width: float = 0.0
    nose_length: float = 0.0
    nose_drop: float = 0.0
    brow: float = 0.0
    cheeks: float = 0.0
    lips: float = 0.0
    skew: float = 0.0
    parting: float = 0.0
    beard: float = 0.0


def draw_features(rng: np.random.Generator, may_have_beard: bool) -> Features:
    """Return random features."""
    count = len(astuple(Features())) - 2
    drawn = np.clip(rng.normal(size=count), -GREATEST, GREATEST).round(2).tolist()
    parting = float(rng.choice([-1.0, 0.0, 1.0]))
    beard = round(float(rng.uniform(0.25, 0.9)), 2) if rng.random() < BEARDED else 0.0
    mean = Features(*drawn)
    return replace(mean, parting=parting, beard=beard if may_have_beard else 0.0)


MEAN_FEATURES = Features()


def with_features(
    patch: SkinnedPatch, features: Features, centre: Array, size: float
) -> SkinnedPatch:
    """Return a part of a head moved by the features of its face.

    Args:
        patch: such as skin, eyes or hair.
        features: of the face.
        centre: (3,) middle of the head [m].
        size: distance from chin to crown [m].
    """
    places = (patch.vertices - centre) / size
    return replace(patch, vertices=centre + size * _moved(features, places))


def _moved(features: Features, places: Array) -> Array:
    """Return places (V, 3) moved by features."""
    f, (x, y, z) = features, places.T
    aside, side = np.abs(z), np.sign(z)
    ahead = ramp(x, 0.05, 0.22)

    def near(height: float, high: float, out: float, wide: float) -> Array:
        return ahead * np.exp(-(((y - height) / high) ** 2) - ((aside - out) / wide) ** 2)

    nose, tip = near(-0.13, 0.075, 0.0, 0.075), near(-0.145, 0.055, 0.0, 0.06)
    brow = near(0.115, 0.045, 0.12, 0.11)
    cheek = near(-0.15, 0.065, 0.17, 0.075)
    mouth = near(-0.28, 0.05, 0.0, 0.10)
    low = ramp(y, -0.08, -0.34)
    forward = NOSE_LENGTH * f.nose_length * tip + BROW * f.brow * brow
    forward = forward + 0.7 * CHEEKS * f.cheeks * cheek + LIPS * f.lips * mouth
    up = -NOSE_DROP * f.nose_drop * tip - CHIN * f.chin * ramp(y, -0.30, -0.48) * ahead
    up = up + SKEW * f.skew * mouth * np.clip(z / 0.10, -1.0, 1.0)
    breadth = WIDTH * f.width + JAW * f.jaw * low + NOSE_WIDTH * f.nose_width * nose
    outward = z * breadth + side * CHEEKS * f.cheeks * cheek
    outward = outward + SKEW * f.skew * (nose + 0.6 * mouth)
    kept = ramp(y, NECK_END, NECK_TOP)[:, None]
    moved: Array = places + kept * np.stack([forward, up, outward], axis=-1)
    return moved
