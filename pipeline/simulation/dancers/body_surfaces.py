"""Places: where on one's own body a hand touches, and other places that dances name."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.simulation.dancers.torso import HAND_RADIUS, LINKS
from pipeline.simulation.people.proportions import ADULT, JOINTS, Proportions
from pipeline.simulation.spatial import Array, normalized
from pipeline.spec.dance import Drum

PRESS = 0.004
"""How far a hand that touches aims under the surface, in heights: so it comes to press on it."""


@dataclass(frozen=True, eq=False)
class Surface:
    """A place on a surface.

    Attributes:
        link: that it is on.
        place: (3,) at rest [m].
        normal: (3,) out of it.
        aim: (3,) where the middle of a hand goes that touches it [m].
    """

    link: str
    place: Array
    normal: Array
    aim: Array


def body_surfaces(who: Proportions) -> dict[str, Surface]:
    """Returns the places on the body of a person, by their names."""
    rest = dict(zip(JOINTS, who.rest() / who.height, strict=True))
    ribs = 0.5 * (who.spine + who.shoulder)
    found = dict[str, tuple[str, Array, float, tuple[float, float, float]]]()
    for side, z in (("r", 1.0), ("l", -1.0)):
        top = rest[f"shoulder_{side}"] + [0.0, -0.006, -0.05 * z]
        found[f"shoulder_{side}"] = ("chest", top, 0.030, (0.35, 1.0, 0.0))
        middle = np.array([0.0, ribs, 0.030 * z])
        found[f"ribs_{side}"] = ("chest", middle, 0.061, (1.0, 0.2, 0.3 * z))
        found[f"low_ribs_{side}"] = ("chest", middle, 0.061, (1.0, -0.55, 0.3 * z))
        head = np.array([0.004, 0.938, 0.0])
        found[f"head_back_{side}"] = ("head", head, 0.050, (-1.0, 0.0, 0.75 * z))
        hip = np.array([0.0, who.hip + 0.015, 0.038 * z])
        found[f"hip_{side}"] = ("pelvis", hip, 0.060, (0.35, 0.35, z))
    head = np.array([0.004, 0.94, 0.0])
    found["head_back"] = ("head", head, 0.050, (-1.0, 0.0, 0.0))
    found["head_top"] = ("head", np.array([0.004, 0.948, 0.0]), 0.050, (0.0, 1.0, 0.0))
    nape = np.array([0.002, who.shoulder + 0.045, 0.0])
    found["nape"] = ("chest", nape, 0.031, (-1.0, 0.1, 0.0))
    breast = np.array([0.0, who.shoulder - 0.043, 0.0])
    found["chest"] = ("chest", breast, 0.059, (1.0, 0.1, 0.0))
    found["belly"] = ("chest", np.array([0.0, who.spine + 0.02, 0.0]), 0.058, (1.0, 0.0, 0.0))
    return {name: _surface(who, *words) for name, words in found.items()}


def _surface(
    who: Proportions, link: str, middle: Array, radius: float, out: tuple[float, float, float]
) -> Surface:
    """Returns the place on a round solid where it faces `out`, given in heights."""
    normal = normalized(np.array(out))
    aim = middle + (radius + HAND_RADIUS - PRESS) * normal
    place = middle + radius * normal
    return Surface(link, who.height * place, normal, who.height * aim)


STRIKE = 0.012
"""Likewise of a hand that strikes a drum."""


def drum_surface(who: Proportions, drum: Drum) -> Surface:
    """Returns the middle of a drum's top."""
    place, up = np.array(drum.at), np.array([0.0, 1.0, 0.0])
    return Surface("", place, up, place + who.height * (HAND_RADIUS - STRIKE) * up)


def scaled_place(who: Proportions, place: tuple[float, float, float]) -> Array:
    """Returns a place (3,) that was given for a grown-up [m]."""
    return np.array(place) * (who.height / ADULT.height)


def link_number(surface: Surface) -> int:
    """Returns the number of the link that a surface is on, -1 for what stands still."""
    return LINKS.index(surface.link) if surface.link else -1
