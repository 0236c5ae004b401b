"""Mass properties of a figure, from its solids and density, and the bones of its ragdoll.

Several solids may follow one link, such as the eyes of a head. Where solids overlap, their common
part counts in each of them, so a link's mass does not depend on its neighbours. The total is too
high by that, a little at every joint, and more where a thick neck or tail starts deep in the body.

Source: Sims 1987, 7.1.1; 9.4 for falling.
"""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.mass import MassProperties, joined, mass_of_solid, volume_of_solid
from pipeline.simulation.dynamics.ragdoll_model import WORLD, Bone, Joint
from pipeline.simulation.figures.base_change import displacement_at
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.kinematics import JointTree
from pipeline.simulation.figures.skeleton import BODY
from pipeline.simulation.obstacles import directions
from pipeline.simulation.spatial import Array

HULL_DIRECTIONS = np.stack(np.meshgrid(*[np.linspace(-1.0, 1.0, 5)] * 3), axis=-1).reshape(-1, 3)
"""Directions in which the corners of a hull are looked for."""

HULL_DIRECTIONS = HULL_DIRECTIONS[np.abs(HULL_DIRECTIONS).max(axis=-1) == 1.0]
"""Directions in which the corners of a hull are looked for."""

CHECKED_DIRECTIONS = 800
"""Number of directions in which no point may stand out of a hull."""

HULL_TOLERANCE = 0.004
"""Distance by which points may stand out of a hull, relative to the figure's extent: a bone sinks
that far into the ground."""


@dataclass(frozen=True, eq=False)
class FigureMass:
    """Mass properties of a figure, computed on demand.

    Attributes:
        figure: any.
    """

    figure: Figure

    @cached_property
    def links(self) -> tuple[MassProperties, ...]:
        """Of each link, in the creation frame."""
        return tuple(map(self.of_link, range(len(self.figure.skeleton.links))))

    def of_link(self, number: int) -> MassProperties:
        """Return the mass properties of one link, in the creation frame."""
        density = self.density_of(self.figure.skeleton.links[number].limb)
        solids = [piece.solid for piece in self.figure.pieces if piece.link == number]
        return joined(mass_of_solid(s.vertices, s.faces, density) for s in solids)

    def mass_of(self, links: Sequence[int]) -> float:
        """Return the total mass of some links [kg]."""
        if not self.figure.masses:
            return self.figure.density * self._volume(links)
        return sum(self.of_link(number).mass for number in links)

    def density_of(self, limb: str) -> float:
        """Return the density of a limb, or of the body [kg/m³]."""
        mass = self.figure.masses.get(limb)
        if mass is None:
            return self.figure.density
        links = [i for i, link in enumerate(self.figure.skeleton.links) if link.limb == limb]
        # As drawn: a figure that is twice as large weighs eight times as much.
        return mass * self.figure.scale**3 / self._volume(links)

    def _volume(self, links: Container[int]) -> float:
        """Return the volume of some links [m³]."""
        solids = (piece.solid for piece in self.figure.pieces if piece.link in links)
        return sum(volume_of_solid(s.vertices, s.faces) for s in solids)

    def at(self, q: Array) -> MassProperties:
        """Return the mass properties of the whole figure as one rigid body, in the body's frame.

        Args:
            q: (J,) joint values [rad or m].
        """
        skeleton = self.figure.skeleton
        tree = JointTree.of(skeleton)
        X_BJ = tree.pose(q)
        return joined(
            mass if link.joint == BODY else mass.in_frame(displacement_at(tree, X_BJ, link.joint))
            for link, mass in zip(skeleton.links, self.links, strict=True)
        )

    @cached_property
    def at_rest(self) -> MassProperties:
        """Of the whole figure in its preferred pose, in the body's frame."""
        return self.at(self.figure.skeleton.preferred)


@dataclass(frozen=True, eq=False)
class FigureBones:
    """The ragdoll bones of a figure.

    Attributes:
        bones: one for each link, in the same order.
        joints: (J,) numbers of the figure's joints, in the order of the bones' joints.
    """

    bones: tuple[Bone, ...]
    joints: NDArray[np.int64]


def build_bones(figure: Figure) -> FigureBones:
    """Return the ragdoll bones of a figure; each has the hull of all solids of its link."""
    skeleton, masses = figure.skeleton, FigureMass(figure).links
    link_of = {link.joint: i for i, link in enumerate(skeleton.links)}
    everything = np.concatenate([piece.solid.vertices for piece in figure.pieces])
    tolerance = HULL_TOLERANCE * float(np.ptp(everything, axis=0).max())
    bones, order = list[Bone](), list[int]()
    for i, (link, mass) in enumerate(zip(skeleton.links, masses, strict=True)):
        solids = [piece.solid.vertices for piece in figure.pieces if piece.link == i]
        corners = _hull_corners(np.concatenate(solids), tolerance)
        if link.joint == BODY:
            bones.append(Bone(WORLD, np.zeros(3), (), mass, corners))
            continue
        # There are no links between the joints of a ball joint.
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
    return FigureBones(tuple(bones), np.array(order, dtype=np.int64))


def _hull_corners(vertices: Array, tolerance: float) -> Array:
    """Return the vertices (k, 3) that span the hull of a solid.

    Args:
        vertices: (n, 3) [m].
        tolerance: distance by which others may stand out of the hull [m].
    """
    middle = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    # Scaled by the extents; the corners of a long solid would else all be at its ends.
    extent = np.maximum(np.ptp(vertices, axis=0), 1e-12)
    far = ((vertices - middle) / extent) @ HULL_DIRECTIONS.T
    corners = np.unique(far.argmax(axis=0)).tolist()
    # A solid that slants, such as an upright trunk, has corners between these.
    reach = vertices @ directions(CHECKED_DIRECTIONS).T
    most = reach.max(axis=0)
    outside = most - reach[corners].max(axis=0)
    while outside.max() > tolerance:
        farthest = int(reach[:, outside.argmax()].argmax())
        outside = np.minimum(outside, most - reach[farthest])
        corners.append(farthest)
    return vertices[np.sort(corners)]
