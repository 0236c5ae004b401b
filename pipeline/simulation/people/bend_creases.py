"""Bend creases: how cloth and skin gather where a joint bends, beyond what skinning does.

Inside of an elbow or a knee cloth is pressed into a crease between two bulges; outside, the bone
stands out. Lengths are in girths (`BodyMeasures.girth`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.simulation.people.proportions import BodyMeasures
from pipeline.simulation.people.skinned_surface import ramp
from pipeline.simulation.spatial import Array


@dataclass(frozen=True)
class Hinge:
    """The creases of a joint that is bent by a right angle.

    Attributes:
        level: height of the joint, as a fraction of an adult's height.
        inner: side on which it closes: 1 ahead, an elbow; -1 behind, a knee.
        depth: of the crease.
        bulge: height of the cloth on both sides of it.
        spacing: distance of a bulge from the crease.
        bone: by how much the bone stands out on the other side.
        fold: depth of the folds that fan out from the crease over the sides.
        slant: by how much the crease runs up from the inner to the outer side of the limb, per
            distance.
    """

    level: float
    inner: float
    depth: float
    bulge: float
    spacing: float
    bone: float
    fold: float = 0.0
    slant: float = 0.0


SLEEVED_ELBOW = Hinge(0.632, 1.0, 0.0060, 0.0030, 0.0180, 0.0012, fold=0.0052, slant=0.25)
BARE_ELBOW = Hinge(0.632, 1.0, 0.0050, 0.0018, 0.0180, 0.0035)
TROUSERED_KNEE = Hinge(0.285, -1.0, 0.0080, 0.0040, 0.0260, 0.0015, fold=0.0060, slant=0.2)
BARE_KNEE = Hinge(0.285, -1.0, 0.0070, 0.0025, 0.0240, 0.0030)

SIDES = (-0.014, 0.018)
"""Places along the way a joint closes between which its outside becomes its inside."""

BONE_REACH = 0.026
"""Distance along the limb in which a bone stands out."""

FAN, FAN_REACH = (0.55, 1.25), 2.2
"""Distance of folds on the inside and on the outside, and how far from the joint they reach, in
that of the bulges."""


def hinge_creases(
    build: BodyMeasures, hinge: Hinge, places: Array, normals: Array, z: float
) -> Array:
    """Return by how much places of a straight limb move where its joint is bent (n, 3) [m].

    Args:
        build: measures of the person.
        hinge: the joint.
        places: (n, 3) on the right limb [m].
        normals: (n, 3) there.
        z: of the middle of the limb [m].
    """
    g = build.girth
    aside = (places[:, 2] - z) / g
    up = (places[:, 1] - build.level(hinge.level)) / g - hinge.slant * aside
    inside = ramp(hinge.inner * places[:, 0] / g, *SIDES)
    far = np.abs(up) / hinge.spacing
    crease = np.exp(-((far / 0.45) ** 2))
    bulge = np.exp(-(((far - 1.0) / 0.55) ** 2))
    # Cloth lies on the limb between narrow ridges, which run together in the crease.
    apart = FAN[1] + (FAN[0] - FAN[1]) * inside
    ridge = (0.5 + 0.5 * np.cos(2.0 * np.pi * (far / apart - 0.5))) ** 2
    sides = 4.0 * inside * (1.0 - inside) + 0.35 * inside
    fold = sides * (ridge - 0.4) * np.exp(-((far / FAN_REACH) ** 4))
    bone = (1.0 - inside) * np.exp(-((up / BONE_REACH) ** 2))
    depth = inside * inside * (hinge.bulge * bulge - hinge.depth * crease)
    return (g * (depth + hinge.fold * fold + hinge.bone * bone))[:, None] * normals
