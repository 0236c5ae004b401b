"""Furrowed bark: trunks nearby, with ridges that run up them, join and part.

A tube of a few sides reads as a pipe from a few metres away. Its furrows are a function of the
angle around the trunk and of the height, so that the pieces of a trunk meet without a seam.
"""

from __future__ import annotations

import numpy as np

from pipeline.production.scenery.prototype import Shape, band_faces, outward, unit
from pipeline.simulation.spatial import Array

SIDES, RINGS = 32, 6
"""Vertices around a trunk, and rings of a piece of it."""

RIDGES = 8
"""Ridges around a trunk."""

DEPTH, DARK = 0.13, 0.62
"""Depth of furrows relative to the radius, and by how much they are darker."""

BUTTRESS, BUTTRESS_HEIGHT = 0.85, 0.34
"""How far roots stand out of the foot of a trunk relative to its radius, and up to where [m]."""


def add_furrowed_bark(
    shape: Shape,
    starts: Array,
    ends: Array,
    start_radii: Array,
    end_radii: Array,
    colors: Array,
    ways: tuple[Array, Array],
) -> None:
    """Add N pieces of trunks.

    Args:
        shape: to which they are added.
        starts: (N, 3) [m].
        ends: (N, 3) [m].
        start_radii: (N,) [m].
        end_radii: (N,) [m].
        colors: (N, 2, 3) linear, of both ends.
        ways: directions (N, 3) of the rings at both ends.
    """
    angle = 2.0 * np.pi * np.arange(SIDES) / SIDES
    first, last = (outward(way, SIDES)[:, None] for way in ways)
    share = np.linspace(0.0, 1.0, RINGS)[:, None]
    out = unit(_between(first, last, share[..., None]))
    axis = _bent(starts, ends, ways, share)
    radius = _between(start_radii[:, None, None], end_radii[:, None, None], share)
    ridge = _ridges(angle, axis[..., 1:2])
    roots = BUTTRESS * np.exp(-((np.maximum(axis[..., 1:2], 0.0) / BUTTRESS_HEIGHT) ** 2))
    lobes = 0.5 + 0.5 * np.cos(5.0 * angle + 0.7)
    wide = radius * (1.0 + DEPTH * (ridge - 0.6) + roots * lobes)
    points = axis[:, :, None] + wide[..., None] * out
    around = np.roll(points, -1, axis=2) - np.roll(points, 1, axis=2)
    along = np.gradient(points, axis=1)
    normals = np.cross(along, around)
    normals *= np.sign((normals * out).sum(axis=-1, keepdims=True))
    tones = _between(colors[:, :1], colors[:, 1:], share)[:, :, None] * (
        1.0 - DARK * (1.0 - ridge[..., None])
    )
    numbers = SIDES * (np.arange(RINGS - 1) + RINGS * np.arange(len(starts))[:, None])
    faces = band_faces(SIDES) + numbers.reshape(-1, 1, 1)
    shape.add(points, normals, tones, faces, thin=False)


def _bent(starts: Array, ends: Array, ways: tuple[Array, Array], share: Array) -> Array:
    """Return the middles (N, R, 3) of rings, on curves that go on from one piece to the next.

    These are Hermite's cubics, whose ends have the directions of the rings there.
    """
    t = share[None]
    chord = (ends - starts)[:, None]
    long = np.linalg.norm(chord, axis=-1, keepdims=True)
    first, last = (long * way[:, None] for way in ways)
    rise = t * t * (3.0 - 2.0 * t)
    bend = t * (1.0 - t) * ((1.0 - t) * first - t * last)
    return np.asarray(starts[:, None] + rise * chord + bend)


def _between(first: Array, second: Array, share: Array) -> Array:
    return np.asarray(first + (second - first) * share)


def _ridges(angle: Array, height: Array) -> Array:
    """Return how high bark stands (N, R, S), 0 to 1, from angles (S,) and heights (N, R, 1) [m]."""
    sway = 0.9 * np.sin(3.1 * height + angle) + 0.6 * np.sin(7.3 * height - 2.0 * angle + 1.0)
    return np.asarray(np.abs(np.sin(0.5 * RIDGES * angle + sway)) ** 0.6)
