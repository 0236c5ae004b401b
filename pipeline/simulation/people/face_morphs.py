"""Face morphs: by how much each unit of a face moves its skin.

Lengths are in heads, from the middle of the head: X forward, Y up, Z to the right.
Source: Ekman, Friesen and Hager 2002, for what each unit moves and where to.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.simulation.face_units import UNITS
from pipeline.simulation.people.face_shape import FaceShape
from pipeline.simulation.spatial import Array

JAW_PIVOT, JAW_TURN = np.array([-0.02, -0.16, 0.0]), np.radians(17.0)

BELOW_BROW, ABOVE_BROW = 0.05, 0.13
"""Reach of a brow's motion: the skin above follows it far, the lid below hardly."""

WIDE_LIDS, TIGHT_UPPER, TIGHT_LOWER = 0.42, 0.22, 2.4
"""Of lids in their way to closing."""


@dataclass(frozen=True, eq=False)
class FaceSkin:
    """Points of a face and what they belong to.

    Attributes:
        places: (V, 3).
        jaw: (V,) share that moves with the jaw.
        closing: (V, 3) offsets that close the lids.
        lid: (V,) share of the upper lids, negative of the lower ones.
        upper: (V,) 1 above the mouth, 0 below.
    """

    places: Array
    jaw: Array
    closing: Array
    lid: Array
    upper: Array

    @staticmethod
    def free(places: Array, jaw: float = 0.0) -> FaceSkin:
        """Return points that are no part of lids or lips, such as brows or teeth."""
        n = len(places)
        upper = np.full(n, float(jaw == 0.0))
        return FaceSkin(places, np.full(n, jaw), np.zeros((n, 3)), np.zeros(n), upper)


def unit_offsets(face: FaceShape, skin: FaceSkin) -> Array:
    """Return the offsets (units, V, 3) of points of a face at the full action of each unit."""
    p = skin.places
    y, aside = p[:, 1], np.abs(p[:, 2])
    outward = np.sign(p[:, 2])
    ahead = np.clip((p[:, 0] + 0.05) / 0.2, 0.0, 1.0)
    drop = -face.drop
    mouth, wide = face.mouth
    brow = 0.135 + drop
    found: dict[str, Array] = {}

    def near(z: float, height: float, width: float, below: float, above: float) -> Array:
        rise = y - height
        scaled = np.where(rise < 0.0, rise / below, rise / above)
        return np.exp(-(((aside - z) / width) ** 2) - scaled**2) * ahead

    def move(forward: float, up: float, out: float, share: Array) -> Array:
        return np.stack([forward * share, up * share, out * outward * share], axis=-1)

    inner = near(0.055, brow, 0.075, BELOW_BROW, ABOVE_BROW)
    outer = near(0.205, brow, 0.085, BELOW_BROW, ABOVE_BROW)
    found["brow_inner_up"] = move(0.0, 0.060, 0.0, inner)
    found["brow_outer_up"] = move(0.0, 0.052, 0.0, outer)
    frown = near(0.065, brow - 0.01, 0.105, 0.055, 0.10)
    found["brow_down"] = move(0.014, -0.056, -0.022, frown)
    upper_lid, lower_lid = np.maximum(skin.lid, 0.0) > 0, skin.lid < 0
    found["lids_wide"] = -WIDE_LIDS * skin.closing * upper_lid[:, None]
    tight = np.where(lower_lid, TIGHT_LOWER, np.where(upper_lid, TIGHT_UPPER, 0.0))
    found["lids_tight"] = tight[:, None] * skin.closing
    found["cheek_up"] = move(0.020, 0.030, 0.0, near(0.165, -0.10 + drop, 0.085, 0.07, 0.05))
    above, below = skin.upper, 1.0 - skin.upper
    nose = near(0.055, -0.145, 0.045, 0.05, 0.06)
    lip = near(0.05, mouth[1] + 0.02, 0.085, 0.07, 0.06) * above
    found["lip_up"] = move(0.012, 0.042, 0.0, lip) + move(-0.004, 0.022, 0.010, nose)
    corner = np.exp(-(((aside - wide) / 0.088) ** 2) - ((y - mouth[1]) / 0.085) ** 2) * ahead
    pouch = near(0.165, mouth[1] + 0.14, 0.075, 0.06, 0.06)
    found["smile"] = move(-0.034, 0.062, 0.046, corner) + move(0.024, 0.020, 0.008, pouch)
    found["corner_down"] = move(-0.006, -0.052, 0.006, corner)
    found["stretch"] = move(-0.026, -0.018, 0.056, corner)
    lips = np.exp(-((aside / (1.1 * wide)) ** 4) - ((y - mouth[1]) / 0.075) ** 2) * ahead
    found["press"] = np.stack(
        [-0.016 * lips, -0.55 * (y - mouth[1]) * lips, np.zeros_like(y)], axis=-1
    )
    c, s = np.cos(JAW_TURN) - 1.0, np.sin(JAW_TURN)
    x, h = p[:, 0] - JAW_PIVOT[0], y - JAW_PIVOT[1]
    # Down and back about the joint of the jaw.
    turned = np.stack([c * x + s * h, -s * x + c * h, np.zeros_like(y)], axis=-1)
    found["jaw"] = skin.jaw[:, None] * turned + move(0.0, 0.008, 0.0, lip)
    found["jaw"][:, 2] -= 0.10 * below * corner * p[:, 2]
    found["blink"] = skin.closing
    return np.stack([found[name] for name in UNITS])
