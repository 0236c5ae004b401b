"""Change of base: any link as the base of a figure, and limbs between any two places.

A joint moves what lies beyond it, in the creation frame, by D(q) = T(p) R(a, q) T(-p), or by T(a
q) where it slides. Seen from its other side it applies D(q)⁻¹ = T(p) R(-a, q) T(-p): the same
place, the reversed axis. So a change of base only reverses the axes of the joints between the old
base and the new one, and changes the parents. Joint values, limits and preferred values keep their
meaning.

Usually a limb runs from a hip to a foot, but any pair of places is possible: from the pelvis to
the elbow, or from one end of an inchworm to the other and back.

Source: Sims 1987, 5.2 and 5.3.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.errors import SimulationError
from pipeline.simulation.figures.kinematics import JointTree
from pipeline.simulation.figures.skeleton import BODY, Limb, Skeleton
from pipeline.simulation.spatial import Array


@dataclass(frozen=True, slots=True)
class _BaseChange:
    """The changes to a tree.

    Attributes:
        path: joints from the new base to the old one.
        mover: joint that now moves each frame on the path, which is named by its former joint.
    """

    path: tuple[int, ...]
    mover: dict[int, int]

    def of(self, frame: int) -> int:
        return self.mover.get(frame, frame)


def _base_change(skeleton: Skeleton, frame: int) -> _BaseChange:
    path = list[int]()
    mover = {frame: BODY}
    while frame != BODY:
        path.append(frame)
        above = int(skeleton.parents[frame])
        mover[above] = frame
        frame = above
    return _BaseChange(tuple(path), mover)


def reroot(skeleton: Skeleton, link: int) -> Skeleton:
    """Return the skeleton with another link as its base.

    Joints and links keep their numbers and names; the base is the link whose joint is `BODY`. A
    limb on the way to the new base is reversed to agree with the new tree; one with the new base
    in its middle keeps its outer part.

    Args:
        skeleton: may have been re-rooted before.
        link: number of the new base.
    """
    return reroot_at_joint(skeleton, skeleton.links[link].joint)


def reroot_at_joint(skeleton: Skeleton, joint: int) -> Skeleton:
    """Return the skeleton with the link beyond `joint` as its base, even if it has no solid.

    Between the three joints of a ball joint are links without extent that have no number.
    """
    change = _base_change(skeleton, joint)
    if not change.path:
        return skeleton
    axes, parents = skeleton.axes.copy(), skeleton.parents.copy()
    axes[list(change.path)] *= -1.0
    before = BODY
    for turned in change.path:
        parents[turned] = before
        before = turned
    for other in set(range(len(parents))) - set(change.path):
        parents[other] = change.of(int(parents[other]))
    return replace(
        skeleton,
        axes=axes,
        parents=parents,
        links=tuple(replace(link, joint=change.of(link.joint)) for link in skeleton.links),
        limbs=tuple(_rerooted_limb(skeleton, limb, change.path) for limb in skeleton.limbs),
    )


def _rerooted_limb(skeleton: Skeleton, limb: Limb, path: Sequence[int]) -> Limb:
    """Return a limb that agrees with the direction of the new tree."""
    kept = [i for i, j in enumerate(limb.joints) if j not in path]
    if len(kept) == len(limb.joints):
        return limb
    if not kept:
        base = skeleton.places[limb.joints[0]]
        return replace(limb, joints=limb.joints[::-1], links=limb.links[::-1], tip=base)
    joints = tuple(limb.joints[i] for i in kept)
    links = tuple(i for i in limb.links if skeleton.links[i].joint in joints)
    inner = np.linalg.norm(np.diff(skeleton.places[list(limb.joints[: kept[0] + 1])], axis=0).T)
    return replace(limb, joints=joints, links=links, length=limb.length - float(inner.sum()))


def displacement(tree: JointTree, q: Array, joint: int) -> Array:
    """Return the displacement (..., 4, 4) of the link beyond `joint` from the creation frame.

    It maps the link's creation coordinates to the base's frame.
    """
    if joint == BODY:
        return np.broadcast_to(np.eye(4), (*q.shape[:-1], 4, 4)).copy()
    return displacement_at(tree, tree.pose(q), joint)


def displacement_at(tree: JointTree, X_BJ: Array, joint: int) -> Array:
    """Return `displacement` for known poses X_BJ (..., J, 4, 4) of all joints."""
    X: Array = X_BJ[..., joint, :, :].copy()
    X[..., :3, 3] -= (X[..., :3, :3] @ tree.places[joint][:, None])[..., 0]
    return X


def base_pose(skeleton: Skeleton, link: int, q: Array, X_WB: Array) -> Array:
    """Return the pose X_WN (..., 4, 4) of the new base that leaves all links in place.

    Args:
        skeleton: before the change.
        link: number of the new base.
        q: (..., J) joint values [rad or m].
        X_WB: (..., 4, 4) pose of the old base; its frame is the creation frame.
    """
    joint = skeleton.links[link].joint
    return X_WB @ displacement(JointTree.of(skeleton), q, joint)


def link_poses(skeleton: Skeleton, q: Array) -> Array:
    """Return the poses (..., links, 4, 4) of all links relative to the base.

    A link's own frame is at its first end, parallel to the creation frame at joint values zero,
    whatever the base is.
    """
    tree = JointTree.of(skeleton)
    X = tree.pose(q)
    result = np.empty((*q.shape[:-1], len(skeleton.links), 4, 4))
    for i, link in enumerate(skeleton.links):
        if link.joint == BODY:
            result[..., i, :, :] = np.eye(4)
            result[..., i, :3, 3] = link.ends[0]
            continue
        frame = X[..., link.joint, :, :]
        inside = link.ends[0] - tree.places[link.joint]
        result[..., i, :, :] = frame
        result[..., i, :3, 3] += (frame[..., :3, :3] @ inside[:, None])[..., 0]
    return result


def limb_between(
    skeleton: Skeleton, base: str, tip: str, point: Array | None = None, name: str = ""
) -> tuple[Skeleton, Limb]:
    """Return the limb from `base` to `tip`, and the skeleton in whose tree it is.

    Both are for `LimbBatch.of`; goals and tips are then relative to the base link, in whose frame
    the figure is as created.

    Args:
        skeleton: the figure, with any base.
        base: name of a link, or of a joint, which is then the first that moves.
        tip: name of a link, or of a joint, whose place is then the tip.
        point: (3,) the tip, in the creation frame [m]; by default the second end of the link
            `tip`.
        name: of the limb; by default "base..tip".

    Raises:
        SimulationError: there is no such link or joint, or no joint between the two.
    """
    starts, _ = _frames_at(skeleton, base)
    ends, place = _frames_at(skeleton, tip)
    routes = [_route(skeleton, a, b) for a in starts for b in ends]
    # A joint at the base moves with the limb, one at the tip does not.
    last = min(routes, key=len)[-1]
    route = max((r for r in routes if r[-1] == last), key=len)
    rooted = reroot_at_joint(skeleton, route[0])
    # The joint between two frames is the one that moves the outer of them.
    joints = [
        there if there != BODY and skeleton.parents[there] == here else here
        for here, there in itertools.pairwise(route)
    ]
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


def _frames_at(skeleton: Skeleton, name: str) -> tuple[list[int], Array]:
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
    up, down = _path_to_body(skeleton, a), _path_to_body(skeleton, b)
    while len(up) > 1 and len(down) > 1 and up[-2] == down[-2]:
        up.pop()
        down.pop()
    return up + down[-2::-1]


def _path_to_body(skeleton: Skeleton, frame: int) -> list[int]:
    result = [frame]
    while result[-1] != BODY:
        result.append(int(skeleton.parents[result[-1]]))
    return result
