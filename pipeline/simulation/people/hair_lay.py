"""The lay of the hair on people's heads: how it is combed by its style, and how long it is."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pipeline.simulation.combed_hair import combed
from pipeline.simulation.figures.solids import vertex_normals
from pipeline.simulation.people.head_mesh import (
    CROWN,
    KNOT,
    KNOT_RADIUS,
    LINE_NORMAL,
    PARTING,
    Head,
    before_hair_line,
)
from pipeline.simulation.people.skinned_surface import SkinnedPatch, ramp
from pipeline.simulation.spatial import UP, Array, normalized

LENGTHS: Mapping[str, float] = {"short": 0.17, "bob": 0.28, "long": 0.30, "bun": 0.17}
"""Length of the strands by style, in heads. They overlap: long hair needs no longer."""

LIFTS_DEG: Mapping[str, float] = {"short": 10.0, "bob": 2.0, "long": 2.0, "bun": 4.0}
"""How far hair stands off."""

ROUND, SKULL = 0.5, (-0.40, 0.22)
"""Radius of the skull, and heights between which hair begins to lie on it, in heads. Below, it
hangs. A strand is drawn as a bow over its chord: on a ball that chord goes into the ball by half
the angle that the strand spans, or combed hair would stand off like straw."""

CROWN_SIZE, CROWN_LIFT_DEG = 0.30, 6.0
"""Reach of the crown [heads], and how far hair stands off there: it is flatter than a ball, and
chords into it would leave it bald."""

SWEPT = 1.3
"""How far short hair is combed over from a parting."""

NAPE, NAPE_SPAN = 0.40, (0.12, -0.15)
"""Share of its length to which short hair is cut beside the ears and in the nape, and heights
between which that comes about, in heads."""

PARTED_ASIDE, PARTED = 2.2, (0.20, 0.42)
"""How far long hair goes aside from its parting, and heights between which it begins to, in heads:
below it falls."""

BROW_LENGTH = 0.021

LOCK_TURNS: Mapping[str, float] = {"short": 0.16, "bob": 0.09, "long": 0.09, "bun": 0.05}
"""How far locks turn from the lay by style, as a tangent: no outline of hair is smooth."""

LOCK_LENGTH = 0.15
"""How much longer or shorter than others locks are."""

EDGE, ABOVE_EYES = -0.38, (0.02, 0.20)
"""Place behind the hair line from which hair turns along it, and heights between which that begins,
in heads: hair that hung over the line would end in spikes on the forehead."""

LEANS: Mapping[str, float] = {"short": 0.5, "bob": 0.3, "long": 0.3, "bun": 0.0}
"""How far hair at the line leans back from it by style, as a tangent."""

FRONT_LIFT_DEG: Mapping[str, float] = {"short": 8.0, "bob": 0.0, "long": 0.0, "bun": 0.0}
"""How much farther hair stands off at the line by style."""

FRONT: Mapping[str, float] = {"short": 0.58, "bob": 0.42, "long": 0.38, "bun": 0.55}
"""Share of its length to which hair is cut over the face by style: the forehead is more round than
the skull, and longer strands would stand off it."""

FRONT_SPAN = (0.02, 0.24)
"""Where along X that comes about."""


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
        aside = SWEPT if style == "short" else PARTED_ASIDE
        off = seen[:, 2] - PARTING * parting
        # Short hair is combed over from the parting, which it has on one side or not at all.
        side = -parting * np.ones(len(off)) if style == "short" else np.where(off < 0.0, -1.0, 1.0)
        falls = ramp(seen[:, 1], *PARTED) if style != "short" else 1.0
        flow[:, 2] += aside * side * falls * np.maximum(seen[:, 0], 0.0)
    cut = 1.0 - (1.0 - FRONT[style]) * ramp(seen[:, 0], *FRONT_SPAN)
    if style == "short":
        cut = np.minimum(cut, 1.0 - (1.0 - NAPE) * ramp(seen[:, 1], *NAPE_SPAN))
    locks = _locks(seen)
    flow = normalized(flow)
    edge = ramp(before_hair_line(head.face, seen), EDGE, 0.0) * ramp(seen[:, 1], *ABOVE_EYES)
    over = np.maximum(flow @ LINE_NORMAL, 0.0) + LEANS[style]
    flow = (
        flow
        - (edge * over)[:, None] * LINE_NORMAL
        + LOCK_TURNS[style] * (1.0 - 0.6 * edge)[:, None] * locks
    )
    length = LENGTHS[style] * head.size * cut * (1.0 + LOCK_LENGTH * locks[:, 0])
    # Drawn up into a bun it lies on the nape as well.
    lies = 1.0 if style == "bun" else ramp(seen[:, 1], *SKULL)
    spanned = length / (ROUND * head.size) * lies
    near = np.exp(-((np.linalg.norm(seen - np.array(CROWN), axis=-1) / CROWN_SIZE) ** 2))
    lift = np.radians(LIFTS_DEG[style] + CROWN_LIFT_DEG * near + FRONT_LIFT_DEG[style] * edge)
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
