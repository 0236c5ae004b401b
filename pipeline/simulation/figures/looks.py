"""Looks: what is seen of a figure, which may be rounder than what it weighs.

Masses and contacts go by the solids of the links, each for itself. What is seen grows
together where links of one material meet, and has feet, claws and jaws besides.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from pipeline.simulation.figures.body_skin import body_skin, stumps_of
from pipeline.simulation.figures.flesh import EYE_MATERIAL, SWELLING, Piece
from pipeline.simulation.figures.limb_skins import leaf_skin, limb_skin, runs
from pipeline.simulation.figures.network import FEELER
from pipeline.simulation.figures.skins import Skin, together
from pipeline.simulation.figures.solids import BODY_FLATNESS, Solid
from pipeline.simulation.figures.trimmings import has_face, trimmings

if TYPE_CHECKING:
    from pipeline.simulation.figures.figure import Figure


FACE_EYES = 0.55
"""Size of the eyes in a face, as a part of those of an animal."""


@dataclass(frozen=True, eq=False)
class Looks:
    """What is seen in place of a figure's pieces.

    Attributes:
        skins: by the number of the piece that they are seen in place of.
        covered: numbers of the pieces of which nothing is seen, being inside another's skin.
    """

    skins: Mapping[int, Skin]
    covered: frozenset[int]


def looks_of(figure: Figure) -> Looks:
    """Return the looks of a figure."""
    number = _piece_numbers(figure.pieces)
    skeleton = figure.skeleton
    skins, covered = dict[int, Skin](), set[int]()
    for limb in skeleton.limbs:
        if figure.style == "mammal" and limb.kind == FEELER and len(limb.links) == 1:
            link = limb.links[0]
            skins[number[link]] = leaf_skin(link, skeleton.links[link])
            continue
        for run in runs(limb, skeleton):
            swelling = SWELLING.get(limb.kind, 0.08)
            skins[number[run[0]]] = limb_skin(run, skeleton.links, swelling)
            covered.update(number[link] for link in run[1:])
    body = _body(figure)
    if body is not None:
        skins[0] = body
    bearer = {
        link: number[run[0]]
        for limb in skeleton.limbs
        for run in runs(limb, skeleton)
        for link in run
    }
    for link, more in trimmings(figure):
        place = bearer.get(link, number[link])
        own = skins.get(place) or Skin.rigid(figure.pieces[place].solid, link)
        skins[place] = together([own, *more])
    skins |= _eyes(figure)
    return Looks(skins, frozenset(covered))


def _piece_numbers(pieces: Sequence[Piece]) -> dict[int, int]:
    """Return link -> number of the piece that is its own."""
    found: dict[int, int] = {}
    for i, piece in enumerate(pieces):
        found.setdefault(piece.link, i)
    return found


def _eyes(figure: Figure) -> dict[int, Skin]:
    """Return the eyes of faces, which are smaller than those of animals."""
    found = {}
    for i, piece in enumerate(figure.pieces):
        if piece.material == EYE_MATERIAL and has_face(figure.skeleton.links[piece.link]):
            middle = piece.solid.vertices.mean(axis=0)
            small = middle + FACE_EYES * (piece.solid.vertices - middle)
            found[i] = Skin.rigid(Solid(small, piece.solid.faces), piece.link)
    return found


def _body(figure: Figure) -> Skin | None:
    """Return the skin of the body with what grows from it; None if nothing does."""
    nodes = list(figure.anatomy.body)
    radii = figure.drawing.radii[nodes] * figure.scale
    girth, material = float(radii.max()), figure.pieces[0].material
    skeleton = figure.skeleton
    stumps = stumps_of(skeleton.limbs, skeleton.links, girth, material, figure.material)
    if not stumps:
        return None
    place = {node: i for i, node in enumerate(nodes)}
    bones = [(place[a], place[b]) for a, b in figure.anatomy.bones]
    flatness = BODY_FLATNESS if figure.style == "insect" else 1.0
    return body_skin(figure.points[nodes], radii, bones or [(0, 0)], flatness, stumps)
