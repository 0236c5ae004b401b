"""Trims: cuffs, hems, collars and belts, as bands around limbs, neck and waist."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipeline.simulation.figures.solids import loft
from pipeline.simulation.people.body_mesh import ARM, LEG, on_twisted_arm
from pipeline.simulation.people.proportions import BodyMeasures
from pipeline.simulation.people.shirt_mesh import SLEEVE_THICKNESS, TORSO, torso_breadths
from pipeline.simulation.people.skinned_surface import (
    SkinnedPatch,
    Surface,
    cached_part,
    with_mirror,
)
from pipeline.simulation.spatial import Array

AROUND = 16
"""Vertices of a ring of a band."""

THICK = 0.0045
"""Thickness of a band, whose outside is that of the cloth, in girths."""

CUFF, SHORT_CUFF, TROUSER_HEM, SHORTS_HEM = (
    (0.4985, 0.5130),
    (0.7135, 0.7215),
    (0.0275, 0.0390),
    (0.3285, 0.3385),
)
"""Lower and upper edges of bands, as fractions of an adult's height."""

BELT, BELT_WORN = (0.5885, 0.6030), 0.0018
"""Edges of a belt likewise, and its distance from the outline of the shirt, in girths."""

WAISTBAND = (0.5800, 0.6080)
"""Edges of a waistband likewise."""

RIB = ((0.8420, 0.0415), (0.8430, 0.0442), (0.8565, 0.0396), (0.8565, 0.0345))
"""Rings of the ribbed neck of a shirt, from its lower inner edge around: heights and radii."""

COLLAR = ((0.8395, 0.0440), (0.8395, 0.0485), (0.8630, 0.0394), (0.8620, 0.0345))
"""Rings of a collar that is folded down."""

LOWER_RINGS, COLLAR_FRONT = 2, (np.radians((0.0, 22.5, 45.0, 90.0)), (-0.017, 0.016, 0.004, 0.0))
"""Rings of the lower edge of a folded collar; angles from the front, and by how much it lies lower
there, in girths."""

NECK_MIDDLE, NECK_FALL = -0.0095, 0.0110
"""Place of the neck along X, and by how much a collar lies lower in front than behind."""


def _ring(middle: float, reach: tuple[float, float, float], y: float, z: float) -> Array:
    """Return an oval ring (AROUND, 3) whose halves ahead and behind differ [m]."""
    angle = np.arange(AROUND) * (2.0 * np.pi / AROUND)
    c, s = np.cos(angle), np.sin(angle)
    ahead, behind, aside = reach
    x = middle + np.where(c > 0.0, ahead, behind) * c
    return np.stack([x, np.full(AROUND, y), z + aside * s], axis=-1)


def _band(
    build: BodyMeasures, outline: Array, edges: tuple[float, float], worn: float, z: float = 0.0
) -> Surface:
    """Return a band around a stack of ovals.

    Args:
        build: measures of the person.
        outline: (n, 5) of `BodyMeasures.outline` [m].
        edges: heights of its edges, as fractions of an adult's height.
        worn: distance of the cloth that it lies on from the outline, in girths.
        z: of the middle of the limb [m].
    """
    g = build.girth
    rings = []
    for level, out in (
        (edges[0], worn - THICK),
        (edges[0], worn),
        (edges[1], worn),
        (edges[1], worn - THICK),
    ):
        y = build.level(level)
        middle, *reach = (np.interp(y, outline[:, 0], outline[:, k]) for k in range(1, 5))
        ahead, behind, aside = (float(r) + out * g for r in reach)
        rings.append(_ring(float(middle), (ahead, behind, aside), y, z))
    return _closed(rings)


def _closed(rings: Sequence[Array]) -> Surface:
    """Return the surface through rings from below, closed inside of the cloth."""
    stacked = np.array(rings)
    solid = loft(stacked, stacked[[0, -1]].mean(axis=1))
    volume = np.einsum(
        "ij,ij->",
        solid.vertices[solid.faces[:, 0]],
        np.cross(solid.vertices[solid.faces[:, 1]], solid.vertices[solid.faces[:, 2]]),
    )
    faces = solid.faces if volume > 0.0 else solid.faces[:, ::-1]
    return Surface(solid.vertices, faces)


@cached_part
def cuffs(build: BodyMeasures, short_sleeves: bool) -> SkinnedPatch:
    """Return the cuffs of both sleeves."""
    outline, z = build.outline(ARM), build.shoulders
    if short_sleeves:
        band = _band(build, outline, SHORT_CUFF, SLEEVE_THICKNESS, z).follow("upper_arm_r")
        band = on_twisted_arm(build, band)
    else:
        band = _band(build, outline, CUFF, SLEEVE_THICKNESS, z).follow("forearm_r")
    return with_mirror(band)


@cached_part
def trouser_hems(build: BodyMeasures, shorts: bool) -> SkinnedPatch:
    """Return the hems of both legs."""
    outline = build.outline(LEG)
    band = _band(build, outline, SHORTS_HEM if shorts else TROUSER_HEM, 0.0, build.hips)
    return with_mirror(band.follow("thigh_r" if shorts else "shin_r"))


@cached_part
def belt(build: BodyMeasures) -> SkinnedPatch:
    """Return a belt around a tucked shirt."""
    outline = build.outline(TORSO, torso_breadths(build))
    return _band(build, outline, BELT, BELT_WORN).follow("pelvis")


@cached_part
def waistband(build: BodyMeasures) -> SkinnedPatch:
    """Return the band of the trousers of dungarees."""
    outline = build.outline(TORSO, torso_breadths(build))
    return _band(build, outline, WAISTBAND, BELT_WORN).follow("pelvis")


@cached_part
def collar(build: BodyMeasures, folded: bool) -> SkinnedPatch:
    """Return the ribbed neck of a shirt, or a collar that is folded down."""
    g = build.girth
    shape = COLLAR if folded else RIB
    angle = np.arange(AROUND) * (2.0 * np.pi / AROUND)
    aside = np.minimum(angle, 2.0 * np.pi - angle)
    rings = []
    for k, (level, radius) in enumerate(shape):
        ring = _ring(NECK_MIDDLE * g, (radius * g,) * 3, build.level(level), 0.0)
        ring[:, 1] -= NECK_FALL * g * (1.0 + (ring[:, 0] / g - NECK_MIDDLE) / radius)
        if folded and k < LOWER_RINGS:
            # It ends in two points beside a gap in the middle of the front.
            ring[:, 1] -= g * np.interp(aside, *COLLAR_FRONT)
        rings.append(ring)
    return _closed(rings).follow("chest")
