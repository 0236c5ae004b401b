"""The solids of a figure's links: one function for each shape, and the eyes of heads.

Shapes are made in the link's own frame: X along it from its first node, Y along the normal of its
drawing plane, Z across it in that plane. They extend beyond both nodes, so that no gap opens where
two of them meet at a bent joint.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.drawing import Drawing
from pipeline.simulation.figures.network import FEELER, HEAD, HORN, LEG, Anatomy
from pipeline.simulation.figures.skeleton import Link, Skeleton
from pipeline.simulation.figures.solids import Solid, ball_solid, loft, revolve
from pipeline.simulation.spatial import UP, Array, from_directions, normalized
from pipeline.spec.figure import LinkShape

PLATE_FLATNESS = 0.24
"""Thickness of a plate, in its width."""

BAR_WIDTH, BAR_HEIGHT = 0.86, 0.66
"""Width and height of a bar, in those of a round link: its edges lie about on the round link's
surface, so that they do not show through round links that it meets."""

BAR_BEVEL = 0.12
"""Width of a bar's bevels, in its radius."""

BAR_NARROWING = 0.94
"""Width of a bar at its outer end, in that of its node: sides of two bars in line must not be
coplanar, where it is arbitrary which of them is visible."""

BALL_STEM = 0.4
"""Greatest thickness of a ball's stem, in the ball's."""

ShapeMaker = Callable[[float, float, float, float], Solid]
"""Solid from length, radii at both ends, and swelling."""


EYE_MATERIAL = "eye"

EYE_SIZES = (0.20, 0.34)
"""Radius of eyes at the side of a long head and on a round one, in its girth."""

SWELLING = {LEG: 0.22, FEELER: 0.0, HORN: 0.0}
"""Swelling of links by kind; other kinds swell a little."""


def link_solid(link: Link, swelling: float) -> Solid:
    """Return the solid of a link.

    Args:
        link: with its ends, radii and shape.
        swelling: greatest thickness beyond a cone, as a fraction; for shapes that swell.
    """
    span = link.ends[1] - link.ends[0]
    solid = SHAPE_MAKERS[link.shape](float(np.linalg.norm(span)), *link.radii, swelling)
    R = _link_axes(span, UP if link.shape == "round" else link.normal)
    return Solid(solid.vertices @ R.T + link.ends[0], solid.faces)


def surface_offset(link: Link, direction: Array) -> Array:
    """Return the offset of a link's surface from its middle line in a direction, in its radius.

    Args:
        link: of any shape.
        direction: (3,) unit vector in the creation frame.
    """
    up = (direction @ link.normal) * link.normal
    if link.shape == "plate":
        return direction - (1.0 - PLATE_FLATNESS) * up
    if link.shape == "box":
        across = float(np.linalg.norm(direction - up)) / BAR_WIDTH
        return direction / max(across, float(np.linalg.norm(up)) / BAR_HEIGHT)
    return direction


def _link_axes(span: Array, up: Array) -> Array:
    """Return the axes of a link (3, 3) in the creation frame."""
    stands = abs(normalized(span) @ up) >= 0.99
    return from_directions(span, np.array([1.0, 0.0, 0.0]) if stands else up)


def _round(length: float, a: float, b: float, swelling: float) -> Solid:
    """Return a round cone with a swelling, closed by hemispheres."""
    cap = np.linspace(-np.pi / 2, 0, 6)[1:]
    s = np.linspace(0.0, 1.0, 12)[1:-1]
    # Thickest at a third of its length, like a thigh.
    belly = np.sin(np.pi * s ** (np.log(0.5) / np.log(0.36)))
    places = np.concatenate(
        [a * np.sin(cap), length * s, length + b * np.sin(-cap[::-1])],
    )
    radii = np.concatenate(
        [a * np.cos(cap), (a + (b - a) * s) * (1.0 + swelling * belly), b * np.cos(cap[::-1])]
    )
    return revolve(places, radii)


def _straight(length: float, a: float, b: float, swelling: float) -> Solid:
    """Return a round cone."""
    del swelling
    return _round(length, a, b, 0.0)


def _plate(length: float, a: float, b: float, swelling: float) -> Solid:
    """Return a flattened round cone, with a thin edge and a round outline."""
    cone = _round(length, a, b, swelling)
    return Solid(cone.vertices * [1.0, PLATE_FLATNESS, 1.0], cone.faces)


def _ball(length: float, a: float, b: float, swelling: float) -> Solid:
    """Return a ball around the second node, on a stem from the first.

    A stem that would be nearly inside the ball is left out.
    """
    del swelling
    stem = min(a, BALL_STEM * b)
    meeting = length - float(np.sqrt(b * b - stem * stem))
    bare = meeting <= 0.1 * b
    begin = -np.pi / 2 if bare else float(np.arcsin(stem / b)) - np.pi / 2
    angle = np.linspace(begin, np.pi / 2, 14)[1:-1]
    places, radii = length + b * np.sin(angle), b * np.cos(angle)
    if bare:
        return revolve(places, radii)
    cap = np.linspace(-np.pi / 2, 0, 6)[1:]
    places = np.concatenate([stem * np.sin(cap), [meeting], places])
    radii = np.concatenate([stem * np.cos(cap), [stem], radii])
    return revolve(places, radii)


def _box(length: float, a: float, b: float, swelling: float) -> Solid:
    """Return a tapered bar with bevelled edges and flat ends.

    Beside every bevel runs a second line of vertices on the side itself: smooth normals turn
    between the two, and the rest of the side looks flat.
    """
    del swelling
    radii = np.repeat([a, BAR_NARROWING * b], 4)
    cut = BAR_BEVEL * radii
    inset = cut * [2.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 2.0]
    z, y = BAR_WIDTH * radii - inset, BAR_HEIGHT * radii - inset
    x = np.repeat([-BAR_WIDTH * a, length + BAR_WIDTH * b], 4)
    x += cut * [0.0, 0.0, 1.0, 2.0, -2.0, -1.0, 0.0, 0.0]
    around = [(y, z - 2 * cut), (y, z - cut), (y - cut, z), (y - 2 * cut, z)]
    around += [(-high, across) for high, across in reversed(around)]
    around += [(-high, -across) for high, across in around]
    rings = np.stack([np.stack([x, high, across], axis=-1) for high, across in around], axis=1)
    return loft(rings, np.array([[x[0], 0.0, 0.0], [x[-1], 0.0, 0.0]]))


SHAPE_MAKERS: Mapping[LinkShape, ShapeMaker] = {
    "round": _round,
    "straight": _straight,
    "box": _box,
    "plate": _plate,
    "ball": _ball,
}
"""Solid of each link shape."""


@dataclass(frozen=True, eq=False)
class SolidPiece:
    """One solid of a figure.

    Attributes:
        name: such as "l1.2" or "head.eye_l".
        link: number of the link that it follows.
        solid: in the creation frame.
        material: name; empty for the performer's own.
        size: characteristic length [m].
    """

    name: str
    link: int
    solid: Solid
    material: str
    size: float

    @cached_property
    def vertices(self) -> NDArray[np.float32]:
        """Vertices (V, 3) for rendering, one array for all creatures of the figure."""
        return self.solid.vertices.astype(np.float32)


def build_pieces(
    skeleton: Skeleton, drawing: Drawing, anatomy: Anatomy, body: Solid, eyes: bool = True
) -> list[SolidPiece]:
    """Return the solids of a figure, the body first."""
    pieces = [_body(drawing, anatomy, body)]
    for number, link in enumerate(skeleton.links[1:], start=1):
        length = float(np.linalg.norm(link.ends[1] - link.ends[0]))
        solid = link_solid(link, SWELLING.get(link.kind, 0.08))
        pieces.append(SolidPiece(link.name, number, solid, link.material, length))
        if eyes and link.kind == HEAD and link.is_tip:
            pieces.extend(_eyes(number, link))
    return pieces


def _body(drawing: Drawing, anatomy: Anatomy, body: Solid) -> SolidPiece:
    nodes = anatomy.body
    counts = [drawing.materials[n] for n in nodes if drawing.materials[n]]
    material = max(counts, key=counts.count) if len(counts) > len(nodes) / 2 else ""
    size = float(np.ptp(body.vertices, axis=0).max())
    return SolidPiece("body", 0, body, material, size)


def _eyes(number: int, link: Link) -> list[SolidPiece]:
    """Return two eyes on the last link of a head, looking forward and sideways.

    A round head has them at its tip; a long one, which ends in a muzzle, nearer its root.
    """
    span = link.ends[1] - link.ends[0]
    length = float(np.linalg.norm(span))
    is_round = link.shape == "ball" or length < 1.6 * sum(link.radii)
    look, part = _eye_direction(span / length, is_round)
    girth = link.radii[0] + (link.radii[1] - link.radii[0]) * part
    middle = link.ends[0] + part * span
    pieces = []
    for side, sign in (("l", -1.0), ("r", 1.0)):
        direction = normalized(look * [1.0, 1.0, sign])
        centre = middle + 0.94 * girth * surface_offset(link, direction)
        radius = EYE_SIZES[part == 1.0] * girth
        pieces.append(
            SolidPiece(f"head.eye_{side}", number, ball_solid(centre, radius), EYE_MATERIAL, girth)
        )
    return pieces


def _eye_direction(along: Array, is_round: bool) -> tuple[Array, float]:
    """Return the direction of a head's right eye, and its place along the last link, 0 to 1."""
    if abs(along[1]) > 0.8:
        # The face of an upright head looks forward.
        return np.array([0.80, 0.12, 0.36]), 1.0
    if is_round:
        return np.array([0.50, 0.42, 0.74]), 1.0
    return np.array([0.0, 0.42, 0.74]), 0.3
