"""Bones: a figure as rigid bodies that hang together by its joints.

Source: Sims 1987, 9.4.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.bones import WORLD, Bone, Joint
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.inertia import Inertia
from pipeline.simulation.figures.skeleton import BODY
from pipeline.simulation.spatial import Array

AROUND = np.stack(np.meshgrid(*[np.linspace(-1.0, 1.0, 5)] * 3), axis=-1).reshape(-1, 3)
AROUND = AROUND[np.abs(AROUND).max(axis=-1) == 1.0]
"""Directions in which the corners of a hull are looked for."""


@dataclass(frozen=True, eq=False)
class Skeletal:
    """The bones of a figure.

    Attributes:
        bones: one for each of its links, numbered alike.
        joints: (J,) numbers of the figure's joints, in the order of the bones' own.
    """

    bones: tuple[Bone, ...]
    joints: NDArray[np.int64]


def bones_of(figure: Figure) -> Skeletal:
    """Return the bones of a figure; each has the hull of all that is visible of its link."""
    skeleton, masses = figure.skeleton, Inertia(figure).links
    link_of = {link.joint: i for i, link in enumerate(skeleton.links)}
    bones, order = list[Bone](), list[int]()
    for i, (link, mass) in enumerate(zip(skeleton.links, masses, strict=True)):
        corners = _corners(figure, i)
        if link.joint == BODY:
            bones.append(Bone(WORLD, np.zeros(3), (), mass, corners))
            continue
        # Joints of one ball have no links of their own between them.
        chain, above = [link.joint], int(skeleton.parents[link.joint])
        while above not in link_of:
            chain.append(above)
            above = int(skeleton.parents[above])
        chain.reverse()
        joints = tuple(
            Joint(
                skeleton.axes[j],
                bool(skeleton.prismatic[j]),
                float(skeleton.lower[j]),
                float(skeleton.upper[j]),
                float(skeleton.preferred[j]),
            )
            for j in chain
        )
        order += chain
        bones.append(Bone(link_of[above], skeleton.places[link.joint], joints, mass, corners))
    return Skeletal(tuple(bones), np.array(order, dtype=np.int64))


def _corners(figure: Figure, number: int) -> Array:
    """Return the points of a link's solids that lie farthest out (k, 3) [m]."""
    solids = [piece.solid.vertices for piece in figure.pieces if piece.link == number]
    vertices = np.concatenate(solids)
    middle = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    # By the extents of the solid, so that those of a long one are not all at its ends.
    extent = np.maximum(np.ptp(vertices, axis=0), 1e-12)
    far = ((vertices - middle) / extent) @ AROUND.T
    result: Array = vertices[np.unique(far.argmax(axis=0))]
    return result
