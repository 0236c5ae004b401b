"""Face shape: the solid of a head and the measures of its face, without ears, lips and hair.

Lengths are in heads, from the middle of the head: X forward, Y up, Z to the right.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.simulation.people.signed_distance import (
    Field,
    ellipsoid,
    round_cone,
    smooth_difference,
    smooth_union,
)
from pipeline.simulation.people.skinned_surface import symmetric_field
from pipeline.simulation.spatial import Array

NECK_TOP = np.array([-0.115, -0.22, 0.0])
"""Upper end of the neck's axis."""

LID_SIZE = 1.10
"""Radius of the lids in that of the eyeball."""

ADULT_EYE_HEIGHT, CHILD_EYE_DROP = 0.015, 0.070
"""Height of an adult's eyes, and by how much lower a child's are."""

SIDES = (1.0, -1.0)


@dataclass(frozen=True)
class FaceShape:
    """The measures of a face.

    Attributes:
        child: 0 for an adult, 1 for a child.
        neck: radius of the neck.
        neck_base: X and Y of the lower end of its axis.
    """

    child: float
    neck: float
    neck_base: tuple[float, float] = (-0.15, -0.85)

    @property
    def eye(self) -> tuple[Array, float]:
        """Middle (3,) and radius of the right eyeball."""
        c = self.child
        middle = np.array([0.290 - 0.008 * c, ADULT_EYE_HEIGHT - self.drop, 0.150])
        return middle, 0.0755 + 0.0165 * c

    @property
    def drop(self) -> float:
        """By how much the upper face is lower than an adult's."""
        return CHILD_EYE_DROP * self.child

    @property
    def mouth(self) -> tuple[Array, float]:
        """Middle (3,) of the mouth, and its half width."""
        return np.array([0.36, -0.282 + 0.012 * self.child, 0.0]), 0.108 - 0.014 * self.child


def face_field(face: FaceShape, with_lids: bool = True) -> Field:
    """Return the solid of head and neck, alike on both sides."""
    skull = smooth_difference(smooth_union(_skull(face), 0.12), _sockets(face), 0.10)
    features = smooth_union([skull, *_nose(face)], 0.034)
    neck = round_cone((*face.neck_base, 0.0), NECK_TOP, 1.08 * face.neck, face.neck)
    head = smooth_union([features, neck], 0.05)
    if with_lids:
        eye, radius = face.eye
        lids = [ellipsoid(eye * [1.0, 1.0, m], LID_SIZE * radius) for m in SIDES]
        head = smooth_union([head, *lids], 0.022)
    return symmetric_field(head)


def _skull(face: FaceShape) -> list[Field]:
    """Return skull, forehead, face, mouth, chin, cheeks, jaw and the ridges of the brows."""
    c, y = face.child, -face.drop
    jaw = 1.0 - 0.22 * c
    solids = [
        ellipsoid((-0.055, 0.115, 0.0), (0.425, 0.385, 0.338)),
        ellipsoid((0.110, 0.150, 0.0), (0.255, 0.275, 0.275)),
        ellipsoid((0.095, -0.130, 0.0), (0.262, 0.330, 0.240 + 0.02 * c)),
        ellipsoid((0.235, -0.270, 0.0), (0.115, 0.135, 0.135)),
        ellipsoid((0.262, -0.415, 0.0), (0.085 * jaw, 0.078 * jaw, 0.100 * jaw)),
    ]
    for m in SIDES:
        brow = (0.318, 0.120 + y, 0.045 * m), (0.225, 0.118 + y, 0.215 * m)
        corner, chin = (-0.03, -0.235, 0.205 * m), (0.235, -0.415, 0.055 * m)
        solids += [
            ellipsoid((0.200, -0.070 + y, 0.158 * m), (0.120, 0.085, 0.095)),
            ellipsoid((0.185, -0.200, 0.118 * m), 0.125 + 0.036 * c),
            round_cone(corner, chin, 0.075, 0.075 * jaw),
            round_cone(*brow, 0.055, 0.045),
        ]
    return solids


def _sockets(face: FaceShape) -> Field:
    y = face.eye[0][1] - 0.003
    sockets = [
        ellipsoid((0.405, y, 0.148 * m), (0.105, 0.070 + 0.012 * face.child, 0.095)) for m in SIDES
    ]
    return smooth_union(sockets, 0.02)


def _nose(face: FaceShape) -> list[Field]:
    """Return bridge, tip, septum and wings."""
    size = 1.0 - 0.48 * face.child
    bridge = (0.335, 0.075 - face.drop, 0.0), (0.362 + 0.044 * size, -0.112, 0.0)
    tip = np.array([0.046, 0.044, 0.049]) * (0.5 + 0.5 * size)
    aside = 0.050 * (0.4 + 0.6 * size)
    return [
        round_cone(*bridge, 0.026, 0.036),
        ellipsoid((0.385 + 0.033 * size, -0.140, 0.0), tip),
        ellipsoid((0.380 + 0.014 * size, -0.173, 0.0), (0.048, 0.016, 0.018)),
        *(
            ellipsoid((0.372 + 0.012 * size, -0.150, aside * m), (0.042, 0.032, 0.027))
            for m in SIDES
        ),
    ]
