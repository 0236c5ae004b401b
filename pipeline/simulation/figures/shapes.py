"""Shapes: the solids that a link may be, one function each.

All are made in the link's own frame: X along it from its first node, Y along the normal of
the plane it was drawn in, Z across it in that plane. They reach beyond both nodes, so that
no gap opens where two of them meet in a joint that bends.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from pipeline.simulation.figures.skeleton import Link
from pipeline.simulation.figures.solids import Solid, lofted, revolve
from pipeline.simulation.spatial import UP, Array, from_directions, normalized
from pipeline.spec.figure import LinkShape

FLATNESS = 0.24
"""Thickness of a plate as a part of its width."""

WIDTH, HEIGHT = 0.86, 0.66
"""Of a bar, as parts of a round link's: its edges lie about on the round one's surface, so
that they come through no round link that it meets."""

BEVEL = 0.12
"""Width of a bar's bevels, as a part of its radius."""

NARROWING = 0.94
"""Width of a bar at its outer end, as a part of its node's, so that the sides of two bars in
line do not lie in one plane, where it is chance which of them is seen."""

STEM = 0.4
"""Thickness of a ball's stem, at most, as a part of the ball's."""

Shape = Callable[[float, float, float, float], Solid]
"""From length, radii at both ends, and swelling."""


def link_solid(link: Link, swelling: float) -> Solid:
    """Return the solid of a link.

    Args:
        link: with its ends, radii and shape.
        swelling: how much thicker than a cone it is in its thickest place, as a part; for
            the shapes that swell.
    """
    span = link.ends[1] - link.ends[0]
    solid = SHAPES[link.shape](float(np.linalg.norm(span)), *link.radii, swelling)
    R = _frame(span, UP if link.shape == "round" else link.normal)
    return Solid(solid.vertices @ R.T + link.ends[0], solid.faces)


def towards(link: Link, direction: Array) -> Array:
    """Return where the surface of a link is, from its middle line, in parts of its radius.

    Args:
        link: of any shape.
        direction: (3,) in the creation frame, of length one.
    """
    up = (direction @ link.normal) * link.normal
    if link.shape == "plate":
        return direction - (1.0 - FLATNESS) * up
    if link.shape == "box":
        across = float(np.linalg.norm(direction - up)) / WIDTH
        return direction / max(across, float(np.linalg.norm(up)) / HEIGHT)
    return direction


def _frame(span: Array, up: Array) -> Array:
    """Return the axes of a link (3, 3) in the creation frame."""
    stands = abs(normalized(span) @ up) >= 0.99
    return from_directions(span, np.array([1.0, 0.0, 0.0]) if stands else up)


def _round(length: float, a: float, b: float, swelling: float) -> Solid:
    """Return a round cone with a swelling, closed by half balls."""
    cap = np.linspace(-np.pi / 2, 0, 6)[1:]
    s = np.linspace(0.0, 1.0, 12)[1:-1]
    # Thickest at a third of the way, as a thigh is.
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
    """Return a round cone pressed flat; its edge is thin, its outline as round as it was."""
    cone = _round(length, a, b, swelling)
    return Solid(cone.vertices * [1.0, FLATNESS, 1.0], cone.faces)


def _ball(length: float, a: float, b: float, swelling: float) -> Solid:
    """Return a ball around the second node, on a stem from the first if it is outside.

    A stem that would be all but inside the ball is left out.
    """
    del swelling
    stem = min(a, STEM * b)
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
    """Return a tapered bar; its edges are bevelled, its ends flat.

    Beside every bevel runs a second line of vertices on the side itself: smooth normals turn
    between the two, and the rest of the side is seen flat.
    """
    del swelling
    radii = np.repeat([a, NARROWING * b], 4)
    cut = BEVEL * radii
    inset = cut * [2.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 2.0]
    z, y = WIDTH * radii - inset, HEIGHT * radii - inset
    x = np.repeat([-WIDTH * a, length + WIDTH * b], 4)
    x += cut * [0.0, 0.0, 1.0, 2.0, -2.0, -1.0, 0.0, 0.0]
    around = [(y, z - 2 * cut), (y, z - cut), (y - cut, z), (y - 2 * cut, z)]
    around += [(-high, across) for high, across in reversed(around)]
    around += [(-high, -across) for high, across in around]
    rings = np.stack([np.stack([x, high, across], axis=-1) for high, across in around], axis=1)
    return lofted(rings, np.array([[x[0], 0.0, 0.0], [x[-1], 0.0, 0.0]]))


SHAPES: Mapping[LinkShape, Shape] = {
    "round": _round,
    "straight": _straight,
    "box": _box,
    "plate": _plate,
    "ball": _ball,
}
"""All shapes."""
