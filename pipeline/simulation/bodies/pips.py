"""Pips: the points on the faces of a die, opposite ones adding up to seven."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.solids import Solid
from pipeline.simulation.spatial import Array

MATERIAL = "rubber"

RADIUS, SPREAD, RAISED = 0.085, 0.25, 0.003
"""Of a pip, of its place from the middle of the face, and how far it stands out, in edges."""

AROUND = 20

PLACES = {
    1: [(0, 0)],
    2: [(-1, -1), (1, 1)],
    3: [(-1, -1), (0, 0), (1, 1)],
    4: [(-1, -1), (-1, 1), (1, -1), (1, 1)],
    5: [(-1, -1), (-1, 1), (0, 0), (1, -1), (1, 1)],
    6: [(-1, -1), (-1, 0), (-1, 1), (1, -1), (1, 0), (1, 1)],
}

AXES = {1: (1, 1.0), 6: (1, -1.0), 2: (0, 1.0), 5: (0, -1.0), 3: (2, 1.0), 4: (2, -1.0)}
"""The axis that looks out of each face, and its sign."""


def pips(edge: float) -> Solid:
    """Return the pips of a die of this edge about its middle [m]."""
    angle = np.arange(AROUND) * (2.0 * np.pi / AROUND)
    vertices, faces = list[Array](), list[NDArray[np.int64]]()
    for number, (axis, sign) in AXES.items():
        out = np.zeros(3)
        out[axis] = sign
        a = np.roll(out, 1) * sign
        b = np.cross(out, a)
        rim = RADIUS * (np.cos(angle)[:, None] * a + np.sin(angle)[:, None] * b)
        for u, v in PLACES[number]:
            middle = 0.5 * out + SPREAD * (u * a + v * b)
            disc = np.concatenate([[middle + RAISED * out], middle + 0.001 * out + rim])
            first = sum(len(one) for one in vertices)
            k = np.arange(AROUND)
            turn = np.column_stack([np.zeros_like(k), 1 + k, 1 + (k + 1) % AROUND])
            vertices.append(edge * disc)
            faces.append(first + turn)
    return Solid(np.concatenate(vertices), np.concatenate(faces).astype(np.uint32))
