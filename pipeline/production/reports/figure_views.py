"""Figure views: a figure as it stands, seen from the side and from the front."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.production.shots.solid_preview import Painted, shaded
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.kinematics import JointTree
from pipeline.simulation.figures.skeleton import BODY
from pipeline.simulation.spatial import Array

SIDE = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
"""From the figure's right: it looks to the right. Rows: right, up, to the eye."""

FRONT = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
"""From before it, its own right on the left."""

FINER = 2
"""Pixels a pixel of the picture is made of, along each side."""

EYE_COLOR = np.array([0.10, 0.11, 0.13])


@dataclass(frozen=True, eq=False)
class Standing:
    """A figure in its preferred pose.

    Attributes:
        figure: any figure.
    """

    figure: Figure

    @cached_property
    def frames(self) -> Array:
        """Frames (J, 4, 4) of the joints, relative to the body."""
        skeleton = self.figure.skeleton
        return JointTree.of(skeleton).pose(skeleton.preferred)

    @cached_property
    def solids(self) -> list[tuple[int, bool, Array, NDArray[np.uint32]]]:
        """Link, whether it is an eye, vertices (V, 3) in the body's frame [m], and faces."""
        found = []
        for piece in self.figure.pieces:
            vertices = self.placed(piece.link, piece.solid.vertices)
            found.append((piece.link, ".eye_" in piece.name, vertices, piece.solid.faces))
        return found

    @cached_property
    def tips(self) -> Array:
        """(L, 3) tips of all limbs, in the body's frame [m]."""
        limbs = self.figure.skeleton.limbs
        return np.array([self.placed(limb.links[-1], limb.tip) for limb in limbs]).reshape(-1, 3)

    @property
    def ground(self) -> float:
        """Height of what it stands on, in the body's frame [m]."""
        return float(min(vertices[:, 1].min() for _, _, vertices, _ in self.solids))

    def placed(self, link: int, points: Array) -> Array:
        """Return points (..., 3) of a link, given in the creation frame, in the body's [m]."""
        skeleton = self.figure.skeleton
        joint = skeleton.links[link].joint
        if joint == BODY:
            return points
        X = self.frames[joint]
        result: Array = (points - skeleton.places[joint]) @ X[:3, :3].T + X[:3, 3]
        return result

    def bounds(self, view: Array) -> tuple[Array, Array]:
        """Return the least and greatest (2,) right and up that are seen [m]."""
        seen = np.concatenate([vertices for _, _, vertices, _ in self.solids]) @ view[:2].T
        return seen.min(axis=0), seen.max(axis=0)

    def picture(
        self,
        view: Array,
        frame: tuple[int, int],
        origin: Array,
        scale: float,
        paint: dict[int, tuple[int, Array]],
        background: Array,
    ) -> NDArray[np.uint8]:
        """Return a picture (height, width, 3) of values 0 to 255.

        Args:
            view: (3, 3) rows right, up, to the eye.
            frame: width and height [pixels].
            origin: (2,) where the body's origin is seen, from the upper left [pixels].
            scale: pixels a metre.
            paint: part and color by link; outlines run between parts.
            background: (3,) 0 to 1.
        """
        solids = []
        for link, is_eye, vertices, faces in self.solids:
            seen = vertices @ view.T * scale * [1.0, -1.0, 1.0] * FINER
            seen[:, :2] += origin * FINER
            part, color = (-2, EYE_COLOR) if is_eye else paint[link]
            solids.append(Painted(seen, faces, color, part))
        width, height = frame
        fine = shaded(solids, (width * FINER, height * FINER), background)
        coarse = fine.reshape(height, FINER, width, FINER, 3).mean(axis=(1, 3))
        result: NDArray[np.uint8] = np.rint(coarse * 255.0).astype(np.uint8)
        return result
