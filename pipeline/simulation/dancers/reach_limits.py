"""Feasible: what of the words of a dance no body can do, told before anybody tries."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from pipeline.errors import Problem
from pipeline.simulation.dancers.torso import LIMITS, PALM
from pipeline.simulation.dynamics.linkage import Capsule, Link, Spot
from pipeline.simulation.people.proportions import JOINTS, Proportions
from pipeline.simulation.spatial import Array

SPREAD = 0.02
"""How much farther than its length an arm may be sent, as a part of it: hands press."""

BODY = ("pelvis", "chest", "head")
"""Links that a hand cannot be in."""

SIDES = ("_r_", "_l_")


def out_of_reach(
    who: Proportions, side: str, own: Sequence[tuple[Spot, str]], path: str, said: str = ""
) -> Iterator[Problem]:
    """Yield places that are farther from the shoulder than an arm is long.

    Args:
        who: the person.
        side: of the hand.
        own: places, with the words that they are said in.
        path: of these words in the scene.
        said: the path of the place instead, where that is none of its words.
    """
    shoulder = who.rest()[JOINTS.index(f"shoulder_{side}")]
    length = (who.upper_arm + who.forearm + PALM * who.hand) * who.height
    for spot, word in own:
        away = float(np.linalg.norm(spot.place - shoulder))
        if away > (1.0 + SPREAD) * length and word != "joints":
            message = (
                f"is {away:.2f} m from the shoulder, and the arm reaches {length:.2f} m; "
                "bring it nearer"
            )
            yield Problem(said or f"{path}.{word}", message)


def inside_body(
    links: Sequence[Link], own: Sequence[tuple[Spot, str]], path: str, said: str = ""
) -> Iterator[Problem]:
    """Yield places that lie inside the body, which hands do not go through.

    Args:
        links: of the torso; body and places as they are at rest.
        own: places that were said as positions, with the words that they are said in.
        path: of these words in the scene.
        said: the path of the place instead, where that is none of its words.
    """
    solids = [solid for link in links if link.name in BODY for solid in link.solids]
    for spot, word in own:
        depth, name = max((_depth(solid, spot.place), solid.name) for solid in solids)
        if depth > 0.0:
            message = (
                f"is inside the body, {100.0 * depth:.0f} cm deep in the {name.split('_')[0]}; "
                "bring it out, or touch a place on the body"
            )
            yield Problem(said or f"{path}.{word}", message)


def beyond_limits(angles: Mapping[str, float], path: str) -> Iterator[Problem]:
    """Yield angles that a joint does not go to.

    Args:
        angles: by the words that they are said in, such as elbow_flexion_deg or
            elbow_r_flexion_deg [degrees].
        path: of these words in the scene.
    """
    for word, angle in angles.items():
        joint = word.removesuffix("_deg")
        for side in SIDES:
            joint = joint.replace(side, "_")
        lower, upper = LIMITS[joint]
        if not lower <= angle <= upper:
            message = f"goes from {lower} to {upper} degrees; {angle:g} is beyond that"
            yield Problem(f"{path}.joints.{word}", message)


def _depth(solid: Capsule, x: Array) -> float:
    """Return how deep a place (3,) is under a solid's surface [m]; below 0 it is outside."""
    a, b = solid.ends
    along = b - a
    s = np.clip((x - a) @ along / max(float(along @ along), 1e-12), 0.0, 1.0)
    return solid.radius - float(np.linalg.norm(x - a - s * along))
