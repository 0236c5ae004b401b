"""Named points on the body and on drums that the hands of a dancer touch."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.simulation.dancers.torso import HAND_RADIUS, LINKS
from pipeline.simulation.people.proportions import ADULT, JOINTS, Proportions
from pipeline.simulation.spatial import Array, normalized
from pipeline.spec.dance import Drum

TOUCH_DEPTH = 0.004
"""Depth below the body's surface at which a touch aims, per body height: the hand presses."""

STRIKE_DEPTH = 0.012
"""Depth below a drumhead at which a strike aims, per body height."""


@dataclass(frozen=True, eq=False)
class Surface:
    """Point on a surface.

    Attributes:
        link: name of the link; empty for a static surface.
        place: (3,) rest position [m].
        normal: (3,) outward unit normal.
        aim: (3,) target of the centre of a hand that touches the point [m].
    """

    link: str
    place: Array
    normal: Array
    aim: Array


def body_surfaces(person: Proportions) -> dict[str, Surface]:
    """Returns the named points on the body of a person."""
    rest = dict(zip(JOINTS, person.rest() / person.height, strict=True))
    ribs = 0.5 * (person.spine + person.shoulder)
    points = dict[str, tuple[str, Array, float, tuple[float, float, float]]]()
    for side, z in (("r", 1.0), ("l", -1.0)):
        # On the round of the shoulder: nearer to the neck a forearm would lie on the throat.
        top = rest[f"shoulder_{side}"] + [0.0, -0.006, -0.038 * z]
        points[f"shoulder_{side}"] = ("chest", top, 0.030, (0.35, 1.0, 0.0))
        middle = np.array([0.0, ribs, 0.030 * z])
        points[f"ribs_{side}"] = ("chest", middle, 0.061, (1.0, 0.2, 0.3 * z))
        points[f"low_ribs_{side}"] = ("chest", middle, 0.061, (1.0, -0.55, 0.3 * z))
        head = np.array([0.004, 0.938, 0.0])
        points[f"head_back_{side}"] = ("head", head, 0.050, (-1.0, 0.0, 0.75 * z))
        hip = np.array([0.0, person.hip + 0.015, 0.038 * z])
        points[f"hip_{side}"] = ("pelvis", hip, 0.060, (0.35, 0.35, z))
    head = np.array([0.004, 0.94, 0.0])
    points["head_back"] = ("head", head, 0.050, (-1.0, 0.0, 0.0))
    points["head_top"] = ("head", np.array([0.004, 0.948, 0.0]), 0.050, (0.0, 1.0, 0.0))
    nape = np.array([0.002, person.shoulder + 0.045, 0.0])
    points["nape"] = ("chest", nape, 0.031, (-1.0, 0.1, 0.0))
    breast = np.array([0.0, person.shoulder - 0.043, 0.0])
    points["chest"] = ("chest", breast, 0.059, (1.0, 0.1, 0.0))
    points["belly"] = ("chest", np.array([0.0, person.spine + 0.02, 0.0]), 0.058, (1.0, 0.0, 0.0))
    return {name: _surface(person, *point) for name, point in points.items()}


def _surface(
    person: Proportions, link: str, middle: Array, radius: float, out: tuple[float, float, float]
) -> Surface:
    """Returns the point of a sphere in direction `out`; `middle`, `radius` per body height."""
    normal = normalized(np.array(out))
    aim = middle + (radius + HAND_RADIUS - TOUCH_DEPTH) * normal
    place = middle + radius * normal
    return Surface(link, person.height * place, normal, person.height * aim)


def drum_surface(person: Proportions, drum: Drum) -> Surface:
    """Returns the centre of a drumhead."""
    place, up = np.array(drum.at), np.array([0.0, 1.0, 0.0])
    return Surface("", place, up, place + person.height * (HAND_RADIUS - STRIKE_DEPTH) * up)


def scaled_position(person: Proportions, place: tuple[float, float, float]) -> Array:
    """Returns a position (3,) given for an adult, scaled to a person's height [m]."""
    return np.array(place) * (person.height / ADULT.height)


def link_number(surface: Surface) -> int:
    """Returns the number of a surface's link, or -1 for a static surface."""
    return LINKS.index(surface.link) if surface.link else -1
