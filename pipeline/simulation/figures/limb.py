"""Limbs: chains of joints between any two places of a figure.

Usually a limb runs from a hip to a foot, but any pair will do: from the pelvis to the
elbow, or from one end of an inchworm to the other and back.

Source: Sims 1987, 5.3.
"""

from __future__ import annotations

import itertools

import numpy as np

from pipeline.errors import SimulationError
from pipeline.simulation.figures.reroot import reroot_at_joint
from pipeline.simulation.figures.skeleton import BODY, Limb, Skeleton
from pipeline.simulation.spatial import Array


def limb_between(
    skeleton: Skeleton, base: str, tip: str, point: Array | None = None, name: str = ""
) -> tuple[Skeleton, Limb]:
    """Return the limb from `base` to `tip`, and the skeleton in whose tree it stands.

    Both go to `LimbBatch.of`; its goals and tips are then relative to the base link, in
    whose frame the figure is as it was created.

    Args:
        skeleton: the figure; what its base is does not matter.
        base: name of a link, or of a joint, which is then the first that moves.
        tip: name of a link, or of a joint, whose place is then the tip.
        point: (3,) the tip, in the creation frame [m]; without it the second end of the
            link `tip`.
        name: of the limb; without it "base..tip".

    Raises:
        SimulationError: if there is no such link or joint, or no joint between the two.
    """
    starts, _ = _frames(skeleton, base)
    ends, place = _frames(skeleton, tip)
    routes = [_route(skeleton, a, b) for a in starts for b in ends]
    # A joint at the base is to move with the limb, one at the tip is not.
    last = min(routes, key=len)[-1]
    route = max((r for r in routes if r[-1] == last), key=len)
    rooted = reroot_at_joint(skeleton, route[0])
    joints = _joints(skeleton, route)
    if not joints:
        raise SimulationError(f"between '{base}' and '{tip}' there is no joint")
    places = [*rooted.places[joints], place if point is None else point]
    slides = np.abs(np.stack([rooted.lower[joints], rooted.upper[joints]])).max(axis=0)
    steps = np.linalg.norm(np.diff(places, axis=0), axis=-1)
    moving = [link for j in joints for link in rooted.links if link.joint == j]
    limb = Limb(
        name=name or f"{base}..{tip}",
        kind=moving[-1].kind if moving else "limb",
        side="m",
        joints=tuple(joints),
        links=tuple(rooted.links.index(link) for link in moving),
        tip=places[-1],
        tip_radius=float(min(moving[-1].radii)) if moving else 0.0,
        length=float(steps.sum() + slides[rooted.prismatic[joints]].sum()),
    )
    return rooted, limb


def _frames(skeleton: Skeleton, name: str) -> tuple[list[int], Array]:
    """Return the frames on either side of a joint, or that of a link, and the tip there.

    A frame is named by the joint that moves it.
    """
    for link in skeleton.links:
        if link.name == name:
            return [link.joint], link.ends[1]
    if name in skeleton.joint_names:
        joint = skeleton.joint_names.index(name)
        return [joint, int(skeleton.parents[joint])], skeleton.places[joint]
    known = ", ".join([link.name for link in skeleton.links] + list(skeleton.joint_names))
    raise SimulationError(f"there is no link or joint '{name}' here; there are {known}")


def _route(skeleton: Skeleton, a: int, b: int) -> list[int]:
    """Return the frames from `a` to `b`, both included."""
    up, down = _ancestry(skeleton, a), _ancestry(skeleton, b)
    while len(up) > 1 and len(down) > 1 and up[-2] == down[-2]:
        up.pop()
        down.pop()
    return up + down[-2::-1]


def _ancestry(skeleton: Skeleton, frame: int) -> list[int]:
    result = [frame]
    while result[-1] != BODY:
        result.append(int(skeleton.parents[result[-1]]))
    return result


def _joints(skeleton: Skeleton, route: list[int]) -> list[int]:
    """Return the joints between the frames of a route, from its base to its tip."""
    # The joint between two frames is the one that moves the outer of them.
    return [
        there if there != BODY and skeleton.parents[there] == here else here
        for here, there in itertools.pairwise(route)
    ]
