"""Posing of inchworms: from where the feet are to where all their parts are.

One foot is the base of the chain and does not move, the other one is its tip and goes its
way. Between them inverse kinematics finds the joint values nearest to those of a loop, so
a pose is a function of the two feet alone, as smooth as their ways are: there is nothing
to drift, and it does not matter from which end it is worked out. Poses of many moments
can be found at once.

Source: Sims 1987, 5.3, 6.2 and B.2.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pipeline.simulation.curves import bump, ease
from pipeline.simulation.figures.goals import Placement
from pipeline.simulation.figures.inverse import TOLERANCE, iterate
from pipeline.simulation.figures.kinematics import LimbBatch, LimbPose
from pipeline.simulation.figures.reach import reach
from pipeline.simulation.figures.reroot import link_poses
from pipeline.simulation.locomotion.inching.chain import REAR, Chain
from pipeline.simulation.locomotion.inching.footing import Track, chord_of
from pipeline.simulation.locomotion.inching.loop import bends
from pipeline.simulation.spatial import Array, turn, unturn

GAINS = (1.0,) * 10 + (0.0, 0.0)
"""Gain of the pull towards the loop, iteration by iteration; at the end the tip is only
brought home. Enough for nanometres: the loop already ends near where the feet are."""

DAMPING = 1e-12
"""λ² where errors are lengths of the limb and radians. It is there because a chain in its
plane cannot move sideways in every way, and asks for nothing there."""

RAISES = (0.22, 0.75)
"""How far the rear and the front foot point up at most while they are in the air [rad]."""

LATE = 1.4
"""How much later than in the middle of its way a foot is raised the most; 1 is not later."""

ALONG = (0.0, 0.25, 0.5, 0.75)
"""Parts of a link's length at which the ground under it is looked at."""


def swung(end: int, start: Array, finish: Array, height: Array, s: Array) -> Array:
    """Return the poses (n, 3) of a foot at parts `s` (n,) of its way through the air.

    It begins and ends at rest, leaves the ground upward, and looks up before it is set down.

    Args:
        end: which foot.
        start: (n, 3) pose from which it lifts.
        finish: (n, 3) pose in which it comes down.
        height: (n,) of the arch [m].
        s: (n,) 0 to 1.
    """
    poses = start + ease(s)[:, None] * (finish - start)
    poses[:, 1] += height * bump(s)
    # bump at s^LATE leaves the ground faster than quadratic and comes back quadratic.
    poses[:, 2] += RAISES[end] * bump(s**LATE)
    return poses


@dataclass(frozen=True, eq=False)
class Posed:
    """One worm at n moments.

    Attributes:
        positions: (n, links, 3) [m].
        rotations: (n, links, 3, 3).
        q: (n, J) joint values [rad].
        residual: (n,) distance of the moving foot from where it is to be [m].
    """

    positions: Array
    rotations: Array
    q: Array
    residual: Array


def posed(chain: Chain, track: Track, base: int, rear: Array, front: Array) -> Posed:
    """Return where all links of a worm are.

    Args:
        chain: the worm.
        track: where it goes.
        base: which foot the others hang on.
        rear: (n, 3) poses of the rear foot.
        front: (n, 3) poses of the front foot.
    """
    R_WF, p_WF = zip(track.pose(rear), track.pose(front), strict=True)
    R_WB = R_WF[base]
    p_WB = p_WF[base] - turn(R_WB, chain.feet[base].middle)
    goals = unturn(R_WB, p_WF[1 - base] - p_WB)
    turned = R_WB.transpose(0, 2, 1) @ R_WF[1 - base]
    pose, residual = _joined(chain, base, rear, front, Placement(goals, turned))
    q = np.zeros((len(rear), len(chain.figure.skeleton.parents)))
    q[:, list(chain.limbs[base].joints)] = pose.q
    X_BN = link_poses(chain.rooted[base], q)
    return Posed(
        positions=p_WB[:, None] + turn(R_WB[:, None], X_BN[..., :3, 3]),
        rotations=R_WB[:, None] @ X_BN[..., :3, :3],
        q=q,
        residual=residual,
    )


def _joined(
    chain: Chain, base: int, rear: Array, front: Array, aim: Placement
) -> tuple[LimbPose, Array]:
    """Bring the tip of the chain to where it is to be, as near to a loop as can be."""
    wished = chain.joint_values(
        bends(chain, *chord_of(chain, rear, front), rear[:, 2], front[:, 2])
    )
    if base != REAR:
        wished = wished[:, ::-1]
    n = len(rear)
    batch = chain.batches[base].rows(np.zeros(n, dtype=np.int64))
    batch = replace(batch, preferred=np.clip(wished, batch.lower, batch.upper))
    pose, damping = batch.pose(batch.preferred), np.broadcast_to(DAMPING * np.eye(6), (n, 6, 6))
    for gain in GAINS:
        task = aim.task(batch, pose)
        placed = replace(pose, jacobian=task.jacobian.transpose(0, 2, 1))
        pose = batch.pose(iterate(batch, placed, task.velocity, np.full(n, gain), damping))
    return _brought_home(batch, pose, aim)


def _brought_home(batch: LimbBatch, pose: LimbPose, aim: Placement) -> tuple[LimbPose, Array]:
    """Let those whose joints have come to their limits take the longer way."""
    left = np.linalg.norm(aim.task(batch, pose).velocity, axis=-1)
    far = np.flatnonzero(left > TOLERANCE)
    residual: Array = left * batch.lengths
    if len(far):
        found = reach(batch.rows(far), pose.rows(far), aim.places[far], aim.rows(far).orientations)
        for field in ("q", "X_BJ", "tips", "jacobian"):
            getattr(pose, field)[far] = getattr(found.pose, field)
        residual[far] = found.residual
    return pose, residual


def sunk(chain: Chain, track: Track, rear: Array, front: Array) -> Array:
    """Return how deep the links between the feet are in the ground (n,), 0 if they are not [m].

    A chain with a joint at its limit, which cannot give way, counts as sunk by its length.

    Args:
        chain: the worm.
        track: where it goes.
        rear: (n, 3) poses of the rear foot.
        front: (n, 3) poses of the front foot.
    """
    whole = posed(chain, track, REAR, rear, front)
    skeleton = chain.figure.skeleton
    held = ((whole.q <= skeleton.lower) | (whole.q >= skeleton.upper)).any(axis=1)
    depth = np.where(held, chain.length, 0.0)
    feet = [foot.number for foot in chain.feet]
    for number, link in enumerate(skeleton.links):
        if number in feet:
            continue
        for part in ALONG:
            inside = part * (link.ends[1] - link.ends[0])
            p = whole.positions[:, number] + turn(whole.rotations[:, number], inside)
            radius = link.radii[0] + part * (link.radii[1] - link.radii[0])
            up = track.ground.normal(p[:, 0], p[:, 2])[:, 1]
            over = track.ground.height(p[:, 0], p[:, 2]) + radius / up - p[:, 1]
            depth = np.maximum(depth, over)
    return depth
