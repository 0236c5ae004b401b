"""Creation: the drawn nodes in three dimensions, as the figure's style lays them.

An insect stays flat, as on the dissection table. A mammal's body may be raised at
its front, and its legs and arms are folded down from where they were drawn: the
direction from a limb's base to its tip becomes down, and what was drawn towards the
head of a sideways limb becomes forward.

Source: Sims 1987, 4.2, eq. 4.1. Its -y_c up is left-handed for a drawing seen from
above; X forward, Y up, Z right is right-handed.
"""

from __future__ import annotations

import math

import numpy as np

from pipeline.simulation.figures.drawing import Drawing
from pipeline.simulation.figures.network import ARM, LEG, Anatomy, Appendage
from pipeline.simulation.spatial import UP, Array, rotation
from pipeline.spec.figure import Figure as Words

FOLDED = (LEG, ARM)
"""Kinds of appendage that a mammal has folded down."""

SIDEWAYS = np.array([0.0, 0.0, 1.0])
"""The axis about which a mammal's limbs swing and bend."""


def create(words: Words, drawing: Drawing, anatomy: Anatomy, scale: float) -> Array:
    """Return the nodes (n, 3) in the creation frame [m].

    Its origin is the middle of the nodes that carry legs, or of the body.
    """
    points: Array = drawing.creation() * scale
    carried = [a.nodes[0] for a in anatomy.of_kind(LEG)] or list(anatomy.body)
    points = points - points[sorted(set(carried))].mean(axis=0)
    if words.style == "insect":
        return points
    points = points @ rotation(SIDEWAYS, math.radians(words.pitch_deg)).T
    for appendage in anatomy.appendages:
        if appendage.kind in FOLDED:
            _fold(points, drawing, appendage, scale)
    return points


def drawn_plane(words: Words, kind: str) -> Array:
    """Return the unit normal (3,) of the plane that appendages of a kind were drawn in.

    Upward as they were drawn; for a mammal's legs and arms it is folded down with them.
    """
    if words.style == "insect":
        return UP
    if kind in FOLDED:
        return SIDEWAYS
    return rotation(SIDEWAYS, math.radians(words.pitch_deg)) @ UP


def _fold(points: Array, drawing: Drawing, appendage: Appendage, scale: float) -> None:
    """Put the nodes of a limb, all but its base, under its base."""
    base, rest = appendage.nodes[0], list(appendage.nodes[1:])
    drawn = (drawing.places[rest] - drawing.places[base]) * scale
    # A limb that was drawn back to its base has no direction but that of its first link.
    far = drawn[-1] if np.linalg.norm(drawn[-1]) > 1e-6 * np.abs(drawn).max() else drawn[0]
    down = far / np.linalg.norm(far)
    # A quarter turn that takes sideways-out to headward on either side.
    left = drawing.places[base][0] + far[0] / scale <= 0.0
    forward = np.array([-down[1], down[0]]) if left else np.array([down[1], -down[0]])
    points[rest] = points[base]
    points[rest, 1] -= drawn @ down
    points[rest, 0] += drawn @ forward
