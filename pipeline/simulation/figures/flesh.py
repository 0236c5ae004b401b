"""Flesh: the visible solids of a figure, link by link."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.network import FEELER, HEAD, LEG
from pipeline.simulation.figures.skeleton import Link
from pipeline.simulation.figures.solids import Solid, ball, link_solid
from pipeline.simulation.spatial import Array

EYE_MATERIAL = "eye"

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


def flesh(figure: Figure) -> list[Piece]:
    """Return the visible solids of `figure`, the body first."""
    links = figure.skeleton.links
    pieces = [_body(figure)]
    for number, link in enumerate(links[1:], start=1):
        swelling = SWELLING.get(link.kind, 0.08)
        length = float(np.linalg.norm(link.ends[1] - link.ends[0]))
        solid = link_solid(link, swelling)
        pieces.append(Piece(link.name, number, solid, link.material, length))
        if link.kind == HEAD and link.is_tip:
            pieces.extend(_eyes(number, link))
    return pieces


def _body(figure: Figure) -> Piece:
    nodes = figure.anatomy.body
    counts = [figure.drawing.materials[n] for n in nodes if figure.drawing.materials[n]]
    material = max(counts, key=counts.count) if len(counts) > len(nodes) / 2 else ""
    size = float(np.ptp(figure.body.vertices, axis=0).max())
    return Piece("body", 0, figure.body, material, size)


def _eyes(number: int, link: Link) -> list[Piece]:
    """Return two eyes on the last link of a head, looking forward and to the sides.

    A round head has them at its tip; a long one, which ends in a muzzle, nearer its root.
    """
    span = link.ends[1] - link.ends[0]
    length = float(np.linalg.norm(span))
    part = 1.0 if length < 1.6 * sum(link.radii) else 0.3
    girth = link.radii[0] + (link.radii[1] - link.radii[0]) * part
    middle = link.ends[0] + part * span
    ahead = 0.50 if part == 1.0 else 0.0
    pieces = []
    for side, sign in (("l", -1.0), ("r", 1.0)):
        direction: Array = np.array([ahead, 0.42, sign * 0.74]) / np.hypot(0.42, 0.74)
        centre = middle + 0.92 * girth * direction
        radius = (0.36 if part == 1.0 else 0.2) * girth
        pieces.append(Piece(f"head.eye_{side}", number, ball(centre, radius), EYE_MATERIAL, girth))
    return pieces
