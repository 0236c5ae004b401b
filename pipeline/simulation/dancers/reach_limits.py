"""Reach limits: checks of places and angles that need no motion."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from pipeline.errors import Problem
from pipeline.simulation.dynamics.linkage import Capsule, Link, Site
from pipeline.simulation.people.joint_limits import HINGE_LIMITS
from pipeline.simulation.people.proportions import JOINTS, PALM_FRACTION, Proportions
from pipeline.simulation.spatial import Array

OVERREACH = 0.02
"""Tolerated distance beyond the arm's length, as a fraction of it: hands press on surfaces."""

BODY = ("pelvis", "chest", "head")
"""Links that a hand cannot enter."""


def out_of_reach(
    proportions: Proportions,
    side: str,
    sites: Sequence[tuple[Site, str]],
    path: str,
    place_path: str = "",
) -> Iterator[Problem]:
    """Yields a problem for each site farther from the shoulder than the arm is long.

    Args:
        proportions: of the person.
        side: of the hand.
        sites: sites, each with its key in the scene.
        path: path of the subtask in the scene.
        place_path: path of the place instead, where it is outside the subtask.
    """
    shoulder = proportions.rest()[JOINTS.index(f"shoulder_{side}")]
    length = proportions.upper_arm + proportions.forearm + PALM_FRACTION * proportions.hand
    length *= proportions.height
    for site, key in sites:
        distance = float(np.linalg.norm(site.place - shoulder))
        if distance > (1.0 + OVERREACH) * length and key != "joints":
            message = (
                f"is {distance:.2f} m from the shoulder, but the arm reaches {length:.2f} m; "
                "move it nearer"
            )
            yield Problem(place_path or f"{path}.{key}", message)


def inside_body(
    links: Sequence[Link], sites: Sequence[tuple[Site, str]], path: str, place_path: str = ""
) -> Iterator[Problem]:
    """Yields a problem for each site inside the body at rest.

    Args:
        links: links of the torso.
        sites: sites given as positions, each with its key in the scene.
        path: path of the subtask in the scene.
        place_path: path of the place instead, where it is outside the subtask.
    """
    solids = [solid for link in links if link.name in BODY for solid in link.solids]
    for site, key in sites:
        depth, name = max((_depth(solid, site.place), solid.name) for solid in solids)
        if depth > 0.0:
            message = (
                f"is inside the body, {100.0 * depth:.0f} cm deep in the {name.split('_')[0]}; "
                "move it out, or touch a place on the body"
            )
            yield Problem(place_path or f"{path}.{key}", message)


def beyond_limits(angles: Mapping[str, float], path: str) -> Iterator[Problem]:
    """Yields a problem for each angle beyond the limits of its joint.

    Args:
        angles: angles [degrees] by key, such as elbow_flexion_deg or elbow_r_flexion_deg.
        path: path of the angles' parent in the scene.
    """
    for key, angle in angles.items():
        joint = key.removesuffix("_deg").replace("_r_", "_").replace("_l_", "_")
        lower, upper = HINGE_LIMITS[joint]
        if not lower <= angle <= upper:
            message = f"is {angle:g} degrees, but the joint goes from {lower} to {upper}"
            yield Problem(f"{path}.joints.{key}", message)


def _depth(solid: Capsule, x: Array) -> float:
    """Returns the depth of a position (3,) below a capsule's surface [m]; negative outside."""
    a, b = solid.ends
    along = b - a
    s = np.clip((x - a) @ along / max(float(along @ along), 1e-12), 0.0, 1.0)
    return solid.radius - float(np.linalg.norm(x - a - s * along))
