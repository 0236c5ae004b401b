"""Inertia: what a figure weighs, link by link, from its visible solids and its density.

Several solids may follow one link, as eyes do a head. Where solids overlap, what they have
in common counts in each of them: a link's mass is its own, whatever stands beside it. The
whole is too heavy by that, a little in every joint, and more where a thick neck or tail
begins deep in the body.

Source: Sims 1987, 7.1.1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from pipeline.simulation.dynamics.mass import MassProperties, joined, mass_of_solid, volume_of_solid
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.kinematics import Tree
from pipeline.simulation.figures.reroot import displaced
from pipeline.simulation.figures.skeleton import BODY
from pipeline.simulation.spatial import Array


@dataclass(frozen=True, eq=False)
class Inertia:
    """Mass properties of a figure; what is not asked for is not computed.

    Attributes:
        figure: any.
    """

    figure: Figure

    @cached_property
    def links(self) -> tuple[MassProperties, ...]:
        """Of each link, in the creation frame."""
        return tuple(map(self.of_link, range(len(self.figure.skeleton.links))))

    def of_link(self, number: int) -> MassProperties:
        """Return those of one link, in the creation frame."""
        solids = [piece.solid for piece in self.figure.pieces if piece.link == number]
        return joined(mass_of_solid(s.vertices, s.faces, self.figure.density) for s in solids)

    def mass_of(self, links: Sequence[int]) -> float:
        """Return the mass of some links together [kg]."""
        solids = (piece.solid for piece in self.figure.pieces if piece.link in links)
        return self.figure.density * sum(volume_of_solid(s.vertices, s.faces) for s in solids)

    def at(self, q: Array) -> MassProperties:
        """Return those of the whole figure, its links held as they are, in the body's frame.

        Args:
            q: (J,) joint values [rad or m].
        """
        skeleton = self.figure.skeleton
        tree = Tree.of(skeleton)
        X_BJ = tree.pose(q)
        return joined(
            mass if link.joint == BODY else mass.in_frame(displaced(tree, X_BJ, link.joint))
            for link, mass in zip(skeleton.links, self.links, strict=True)
        )

    @cached_property
    def at_rest(self) -> MassProperties:
        """Of the whole figure in its preferred pose, in the body's frame."""
        return self.at(self.figure.skeleton.preferred)
