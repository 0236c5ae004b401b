"""Flesh: the visible solids of a figure, link by link."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.drawing import Drawing
from pipeline.simulation.figures.network import FEELER, HEAD, LEG, Anatomy
from pipeline.simulation.figures.shapes import link_solid, towards
from pipeline.simulation.figures.skeleton import Link, Skeleton
from pipeline.simulation.figures.solids import Solid, ball
from pipeline.simulation.spatial import Array, normalized

EYE_MATERIAL = "eye"

EYES = (0.20, 0.34)
"""Size of eyes beside a long head and on a round one, as a part of its girth."""

SWELLING = {LEG: 0.22, FEELER: 0.0}
"""How much thicker than a cone a link is; what is not named swells a little."""


@dataclass(frozen=True, eq=False)
class Piece:
    """One visible solid.

    Attributes:
        name: such as "l1.2" or "head.eye_l".
        link: number of the link that it follows.
        solid: in the creation frame.
        material: name, empty for the performer's own.
        size: characteristic length [m].
    """

    name: str
    link: int
    solid: Solid
    material: str
    size: float

    @cached_property
    def vertices(self) -> NDArray[np.float32]:
        """Those of the solid (V, 3), as a picture needs them: one array for all who have it."""
        return self.solid.vertices.astype(np.float32)


def flesh(
    skeleton: Skeleton, drawing: Drawing, anatomy: Anatomy, body: Solid, eyes: bool = True
) -> list[Piece]:
    """Return the solids of a figure, the body first."""
    pieces = [_body(drawing, anatomy, body)]
    for number, link in enumerate(skeleton.links[1:], start=1):
        length = float(np.linalg.norm(link.ends[1] - link.ends[0]))
        solid = link_solid(link, SWELLING.get(link.kind, 0.08))
        pieces.append(Piece(link.name, number, solid, link.material, length))
        if eyes and link.kind == HEAD and link.is_tip:
            pieces.extend(_eyes(number, link))
    return pieces


def _body(drawing: Drawing, anatomy: Anatomy, body: Solid) -> Piece:
    nodes = anatomy.body
    counts = [drawing.materials[n] for n in nodes if drawing.materials[n]]
    material = max(counts, key=counts.count) if len(counts) > len(nodes) / 2 else ""
    size = float(np.ptp(body.vertices, axis=0).max())
    return Piece("body", 0, body, material, size)


def _eyes(number: int, link: Link) -> list[Piece]:
    """Return two eyes on the last link of a head, looking forward and to the sides.

    A round head has them at its tip; a long one, which ends in a muzzle, nearer its root.
    """
    span = link.ends[1] - link.ends[0]
    length = float(np.linalg.norm(span))
    is_round = link.shape == "ball" or length < 1.6 * sum(link.radii)
    look, part = _look(span / length, is_round)
    girth = link.radii[0] + (link.radii[1] - link.radii[0]) * part
    middle = link.ends[0] + part * span
    pieces = []
    for side, sign in (("l", -1.0), ("r", 1.0)):
        direction = normalized(look * [1.0, 1.0, sign])
        centre = middle + 0.94 * girth * towards(link, direction)
        radius = EYES[part == 1.0] * girth
        pieces.append(Piece(f"head.eye_{side}", number, ball(centre, radius), EYE_MATERIAL, girth))
    return pieces


def _look(along: Array, is_round: bool) -> tuple[Array, float]:
    """Return where the right eye of a head looks, and at what part of its last link it is."""
    if abs(along[1]) > 0.8:
        # A face on an upright head looks forward.
        return np.array([0.80, 0.12, 0.36]), 1.0
    if is_round:
        return np.array([0.50, 0.42, 0.74]), 1.0
    return np.array([0.0, 0.42, 0.74]), 0.3
