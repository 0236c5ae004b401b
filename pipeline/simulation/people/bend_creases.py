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
        slant: by how much the crease runs up from the inner to the outer side of the limb, per
            distance.
    """

    level: float
    inner: float
    depth: float
    bulge: float
    spacing: float
    bone: float
    slant: float = 0.0


SLEEVED_ELBOW = Hinge(0.632, 1.0, 0.0095, 0.0075, 0.0200, 0.0060, slant=0.25)
BARE_ELBOW = Hinge(0.632, 1.0, 0.0060, 0.0020, 0.0180, 0.0050)
TROUSERED_KNEE = Hinge(0.285, -1.0, 0.0120, 0.0085, 0.0280, 0.0050, slant=0.2)
BARE_KNEE = Hinge(0.285, -1.0, 0.0080, 0.0030, 0.0240, 0.0040)

SIDES = (-0.010, 0.014)
"""Places along the way a joint closes between which its outside becomes its inside."""


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
    crease = np.exp(-((up / (0.45 * hinge.spacing)) ** 2))
    far = np.abs(up) / hinge.spacing
    bulge = np.exp(-(((far - 1.0) / 0.5) ** 2))
    second = np.exp(-(((far - 1.9) / 0.42) ** 2))
    bone = np.exp(-((up / 0.017) ** 2))
    depth = inside * (hinge.bulge * bulge - hinge.depth * (crease + 0.35 * second))
    return (g * (depth + (1.0 - inside) * hinge.bone * bone))[:, None] * normals
