"""Skins: surfaces that are seen in place of the solids of a figure's links."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.solids import Solid
from pipeline.simulation.spatial import Array


@dataclass(frozen=True, eq=False)
class Skin:
    """A closed surface that follows two links a vertex at most.

    Attributes:
        vertices: (V, 3) in the creation frame [m].
        faces: (F, 3), counter-clockwise from outside.
        links: (V, 2) numbers.
        share: (V,) of the second link; the first has the rest.
    """

    vertices: Array
    faces: NDArray[np.uint32]
    links: NDArray[np.int64]
    share: Array

    @staticmethod
    def rigid(solid: Solid, link: int) -> Skin:
        """Return a solid that follows one link."""
        count = len(solid.vertices)
        return Skin(solid.vertices, solid.faces, np.full((count, 2), link), np.zeros(count))


def together(skins: Sequence[Skin]) -> Skin:
    """Return several skins as one."""
    starts = np.cumsum([0, *(len(skin.vertices) for skin in skins)])
    faces = [skin.faces + np.uint32(start) for skin, start in zip(skins, starts, strict=False)]
    return Skin(
        np.concatenate([skin.vertices for skin in skins]),
        np.concatenate(faces),
        np.concatenate([skin.links for skin in skins]),
        np.concatenate([skin.share for skin in skins]),
    )
