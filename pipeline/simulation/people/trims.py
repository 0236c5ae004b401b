"""Trims: cuffs, hems, collars and belts, as bands around limbs, neck and waist."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from pipeline.simulation.figures.solids import loft
from pipeline.simulation.people.body_mesh import ARM, on_twisted_arm
from pipeline.simulation.people.proportions import BodyMeasures
from pipeline.simulation.people.shirt_mesh import (
    SLEEVE_THICKNESS,
    TORSO,
    Sleeve,
    sleeve_air,
    torso_breadths,
)
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

CUFFS: Mapping[Sleeve, tuple[float, float]] = {
    "short": (0.7030, 0.7175),
    "cuffed": (0.4955, 0.5190),
    "straight": (0.4985, 0.5100),
}
"""Lower and upper edges of the bands of sleeves, as fractions of an adult's height."""

SHIRT_CUFF = (0.4915, 0.5060)
"""Edges of a cuff that shows below the sleeve of a jacket likewise."""

CUFF_WORN: Mapping[Sleeve, float] = {"short": 0.0014, "cuffed": 0.0012, "straight": 0.0012}
"""Distance of a cuff from the sleeve that it ends, in girths."""

HOLLOW = 0.0080
"""Height up to which one looks into a band from below, as a fraction of an adult's height."""

BAND_SHADES = (0.20, 0.40, 1.0, 1.0, 0.45)
"""Shades of the rings of a band: inside, at its edges, and where it lies on cloth."""

BELT, BELT_WORN = (0.5885, 0.6030), (0.0018, 0.0018)
"""Edges of a belt likewise, and the distances of both from the outline of the shirt, in girths."""

WAISTBAND = (0.5800, 0.6080)
"""Edges of a waistband likewise."""

RIB = ((0.8420, 0.0415), (0.8430, 0.0442), (0.8565, 0.0396), (0.8565, 0.0345))
"""Rings of the ribbed neck of a shirt, from its lower inner edge around: heights and radii."""

COLLAR = ((0.8395, 0.0440), (0.8395, 0.0485), (0.8630, 0.0394), (0.8620, 0.0345))
"""Rings of a collar that is folded down."""

COLLAR_SHADES = (0.45, 0.85, 1.0, 0.55)
"""Shades of the rings of a neck: where it lies on the shirt, and inside."""

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
    build: BodyMeasures,
    outline: Array,
    edges: tuple[float, float],
    worn: tuple[float, float],
    frame: str,
    z: float = 0.0,
) -> SkinnedPatch:
    """Return a band around a stack of ovals, dark inside and where it lies on cloth.

    Args:
        build: measures of the person.
        outline: (n, 5) of `BodyMeasures.outline` [m].
        edges: heights of its edges, as fractions of an adult's height.
        worn: distances of its outside from the outline at these, in girths.
        frame: that it follows.
        z: of the middle of the limb [m].
    """
    g = build.girth
    rings = []
    low, high = worn
    for level, out in (
        (edges[0] + HOLLOW, low - THICK),
        (edges[0], low - THICK),
        (edges[0], low),
        (edges[1], high),
        (edges[1], high - THICK),
    ):
        y = build.level(level)
        middle, *reach = (np.interp(y, outline[:, 0], outline[:, k]) for k in range(1, 5))
        ahead, behind, aside = (float(r) + out * g for r in reach)
        rings.append(_ring(float(middle), (ahead, behind, aside), y, z))
    return replace(_closed(rings).follow(frame), shade=_ring_shade(BAND_SHADES))


def _ring_shade(shades: Sequence[float]) -> Array:
    """Return the shade of the vertices of `_closed`, whose last two are the ends."""
    return np.concatenate([np.repeat(shades, AROUND), [shades[0], shades[-1]]])


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
def cuffs(build: BodyMeasures, sleeve: Sleeve) -> SkinnedPatch:
    """Return the cuffs of both sleeves, or the edges of those without."""
    edges = CUFFS[sleeve]
    air = sleeve_air(build, sleeve, build.levels(np.array(edges)))
    low, high = (air + CUFF_WORN[sleeve]).tolist()
    frame = "upper_arm_r" if sleeve == "short" else "forearm_r"
    band = _band(build, build.outline(ARM), edges, (low, high), frame, build.shoulders)
    return with_mirror(on_twisted_arm(build, band) if sleeve == "short" else band)


@cached_part
def shirt_cuffs(build: BodyMeasures) -> SkinnedPatch:
    """Return the cuffs of a shirt below the sleeves of a jacket."""
    outline, worn = build.outline(ARM), (SLEEVE_THICKNESS, SLEEVE_THICKNESS)
    return with_mirror(_band(build, outline, SHIRT_CUFF, worn, "forearm_r", build.shoulders))


@cached_part
def belt(build: BodyMeasures) -> SkinnedPatch:
    """Return a belt around a tucked shirt."""
    outline = build.outline(TORSO, torso_breadths(build))
    return _band(build, outline, BELT, BELT_WORN, "pelvis")


@cached_part
def waistband(build: BodyMeasures) -> SkinnedPatch:
    """Return the band of the trousers of dungarees."""
    outline = build.outline(TORSO, torso_breadths(build))
    return _band(build, outline, WAISTBAND, BELT_WORN, "pelvis")


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
    return replace(_closed(rings).follow("chest"), shade=_ring_shade(COLLAR_SHADES))
