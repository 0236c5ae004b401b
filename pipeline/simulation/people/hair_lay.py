"""The lay of the hair on people's heads: how it is combed by its style, and how long it is."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pipeline.simulation.combed_hair import combed
from pipeline.simulation.figures.solids import vertex_normals
from pipeline.simulation.people.head_mesh import CROWN, KNOT, KNOT_RADIUS, Head
from pipeline.simulation.people.skinned_surface import SkinnedPatch, ramp
from pipeline.simulation.spatial import UP, Array, normalized

LENGTHS: Mapping[str, float] = {"short": 0.17, "bob": 0.34, "long": 0.40, "bun": 0.17}
"""Length of the strands by style, in heads. They overlap: long hair needs no longer."""

LIFTS_DEG: Mapping[str, float] = {"short": 12.0, "bob": 6.0, "long": 6.0, "bun": 6.0}
"""How far hair stands off."""

ROUND, SKULL = 0.5, (-0.05, 0.22)
"""Radius of the skull, and heights between which hair begins to lie on it, in heads. Below, it
hangs. A strand is drawn as a bow over its chord: on a ball that chord goes into the ball by half
the angle that the strand spans, or combed hair would stand off like straw."""

CROWN_SIZE, CROWN_LIFT_DEG = 0.30, 6.0
"""Reach of the crown [heads], and how far hair stands off there: it is flatter than a ball, and
chords into it would leave it bald."""

PARTING, SWEPT = 0.11, 1.3
"""How far a parting lies aside [heads], and how far short hair is combed over from it."""

BROW_LENGTH = 0.021

LOCK_TURNS: Mapping[str, float] = {"short": 0.20, "bob": 0.20, "long": 0.20, "bun": 0.07}
"""How far locks turn from the lay by style, as a tangent: no outline of hair is smooth."""

LOCK_LENGTH = 0.15
"""How much longer or shorter than others locks are."""

FRINGE, FRINGE_SPAN = 0.42, (0.02, 0.24)
"""Share of its length to which hair is cut over the face, and where along X that comes about."""


def head_hair(head: Head, style: str, patch: SkinnedPatch, parting: float = 0.0) -> Array:
    """Return the hair (V, 3) at the vertices of the hair's surface [m].

    Args:
        head: of the person.
        style: of the hair.
        patch: its surface.
        parting: side of the parting, -1 on the left, 1 on the right.
    """
    places, normals = patch.vertices, vertex_normals(patch.vertices, patch.faces)
    seen = (places - head.centre) / head.size
    if style == "bun":
        flow = np.array(KNOT) - seen
        # The knot itself is wound.
        near = np.linalg.norm(flow, axis=-1, keepdims=True) < 1.25 * KNOT_RADIUS
        flow = np.where(near, np.cross(normals, UP) + 0.3 * UP, flow)
    else:
        flow = seen - np.array(CROWN) - (0.2 if style == "short" else 0.9) * UP
        # Parted over the face.
        aside = SWEPT if style == "short" else 3.5
        off = seen[:, 2] - PARTING * parting
        # Short hair is combed over from the parting, which it has on one side or not at all.
        side = -parting * np.ones(len(off)) if style == "short" else np.where(off < 0.0, -1.0, 1.0)
        flow[:, 2] += aside * side * np.maximum(seen[:, 0], 0.0)
    cut = 1.0 - (1.0 - FRINGE) * ramp(seen[:, 0], *FRINGE_SPAN)
    locks = _locks(seen)
    flow = normalized(flow) + LOCK_TURNS[style] * locks
    length = LENGTHS[style] * head.size * cut * (1.0 + LOCK_LENGTH * locks[:, 0])
    # Drawn up into a bun it lies on the nape as well.
    lies = 1.0 if style == "bun" else ramp(seen[:, 1], *SKULL)
    spanned = length / (ROUND * head.size) * lies
    near = np.exp(-((np.linalg.norm(seen - np.array(CROWN), axis=-1) / CROWN_SIZE) ** 2))
    lift = np.radians(LIFTS_DEG[style] + CROWN_LIFT_DEG * near)
    return combed(flow, normals, length, lift - 0.5 * spanned)


def _locks(places: Array) -> Array:
    """Return turns of locks (V, 3) of about 1, the same for all heads; places in heads."""
    waves = np.array([[31.0, 17.0, 23.0], [19.0, 29.0, -21.0], [-27.0, 13.0, 33.0]])
    return np.asarray(np.sin(places @ waves.T) + 0.6 * np.sin(1.7 * places @ waves[::-1].T + 2.0))


def brow_hair(head: Head, patch: SkinnedPatch) -> Array:
    """Return the hair (V, 3) of the brows, which goes outward [m]."""
    normals = vertex_normals(patch.vertices, patch.faces)
    outward = np.where(patch.vertices[:, 2:] < 0.0, -1.0, 1.0) * np.array([0.0, 0.0, 1.0])
    return combed(outward + 0.4 * UP, normals, BROW_LENGTH * head.size, np.radians(14.0))
