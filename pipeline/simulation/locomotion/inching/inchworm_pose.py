"""Poses of inchworms: from poses of the feet on a track to all links.

A worm stays in the vertical plane through its heading. In it a foot's pose is three numbers:
distance of its middle from the start, height, and inclination.

One foot is the base of the chain and does not move, the other is its tip. Between them inverse
kinematics finds the joint values nearest to those of a loop, so a pose is a function of the two
feet alone and as smooth as their paths; nothing drifts, and either end may be the base. Many
moments are solved at once.

Source: Sims 1987, 5.3, 6.2 and B.2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.curves import bump, ease
from pipeline.simulation.figures.base_change import link_poses
from pipeline.simulation.figures.ik_goals import TipPlacement
from pipeline.simulation.figures.inverse_kinematics import TIP_ITERATION, damped_step
from pipeline.simulation.figures.kinematics import LimbBatch, LimbPose
from pipeline.simulation.figures.reach_ik import reach
from pipeline.simulation.locomotion.inching.inchworm_chain import (
    FRONT,
    REAR,
    EndFoot,
    InchwormChain,
    loop_bends,
)
from pipeline.simulation.spatial import Array, heading, rotation, turn, turn_inverse
from pipeline.simulation.terrain import Ground

CANDIDATE_FRACTIONS = np.linspace(0.0, 1.0, 41)
"""Candidate places, from the wished one back to the present one."""

FOOT_SAMPLES = np.linspace(-0.5, 0.5, 5)
"""Samples of the ground under a foot, in its length."""

SIDEWAYS = np.array([0.0, 0.0, 1.0])


LOOP_GAINS = (1.0,) * 10 + (0.0, 0.0)
"""Gain of the pull towards the loop by iteration; the last ones only solve for the tip. Enough for
nanometres: the loop already ends near the feet."""

DAMPING = 1e-12
"""λ² with errors in limb lengths and radians. A planar chain cannot move sideways in every way."""

MAX_FOOT_PITCH = (0.22, 0.75)
"""Greatest pitch of the rear and the front foot in the air [rad]."""

PITCH_DELAY = 1.4
"""Exponent that delays the greatest pitch beyond the middle of the step; 1 does not."""

LINK_SAMPLES = (0.0, 0.25, 0.5, 0.75)
"""Samples along a link at which the ground under it is tested, in its length."""


@dataclass(frozen=True, eq=False)
class InchwormTrack:
    """The plane in which one worm walks.

    Attributes:
        ground: that it walks on.
        start: (2,) x and z of its start [m].
        heading: [rad].
    """

    ground: Ground
    start: Array
    heading: float

    def places(self, ways: Array) -> tuple[Array, Array]:
        """Return x and z (...) at distances `ways` (...) [m]."""
        return (
            self.start[0] + ways * math.cos(self.heading),
            self.start[1] - ways * math.sin(self.heading),
        )

    def height(self, ways: Array) -> Array:
        """Return the height of the ground (...) at distances `ways` (...) [m]."""
        return self.ground.height(*self.places(ways))

    def pose(self, feet: Array) -> tuple[Array, Array]:
        """Return rotations (n, 3, 3) and middles (n, 3) [m] of feet (n, 3)."""
        x, z = self.places(feet[:, 0])
        R = heading(self.heading) @ rotation(SIDEWAYS, feet[:, 2])
        return R, np.stack([x, feet[:, 1], z], axis=-1)

    def rise(self, foot: EndFoot, poses: Array) -> Array:
        """Return how far feet (n, 3) are in the ground (n,), negative above it [m]."""
        R, p = self.pose(poses)
        solid = (foot.solid - foot.middle) @ R.transpose(0, 2, 1) + p[:, None]
        over = self.ground.height(solid[..., 0], solid[..., 2]) - solid[..., 1]
        return over.max(axis=-1)

    def lie(self, foot: EndFoot, ways: Array) -> Array:
        """Return the poses (n, 3) of a foot lying on the ground at distances `ways` (n,) [m].

        Its underside takes the slope of the ground under it and touches it.
        """
        under = self.height(ways[:, None] + foot.length * FOOT_SAMPLES)
        middle = under - under.mean(axis=1, keepdims=True)
        slope = (middle * FOOT_SAMPLES).sum(axis=1) / ((FOOT_SAMPLES**2).sum() * foot.length)
        poses = np.stack([ways, under.mean(axis=1), np.arctan(slope) + foot.taper], axis=-1)
        poses[:, 1] += self.rise(foot, poses)
        return poses

    def safe(self, foot: EndFoot, ways: Array) -> NDArray[np.bool_]:
        """Return where (n,) all of the ground under a foot is steppable."""
        x, z = self.places(ways[:, None] + foot.length * FOOT_SAMPLES)
        return np.all(self.ground.steppable(x, z), axis=1)


def foot_chord(chain: InchwormChain, rear: Array, front: Array) -> tuple[Array, Array]:
    """Return length [m] and inclination [rad] of the line between the feet's inner ends (n,)."""
    back, fore = 0.5 * chain.feet[REAR].length, 0.5 * chain.feet[FRONT].length
    along = front[:, 0] - rear[:, 0] - fore * np.cos(front[:, 2]) - back * np.cos(rear[:, 2])
    up = front[:, 1] - rear[:, 1] - fore * np.sin(front[:, 2]) - back * np.sin(rear[:, 2])
    return np.hypot(along, up), np.arctan2(up, along)


def candidate_poses(
    chain: InchwormChain,
    track: InchwormTrack,
    feet: tuple[Array, Array],
    end: int,
    wished: float,
    bounds: tuple[float, float],
) -> Array:
    """Return poses (n, 3) in which a foot may be put down next, the best first.

    These are the wished one, then those on the way back to the foot.

    Args:
        chain: the worm.
        track: that it walks on.
        feet: (3,) poses of the rear and the front foot.
        end: number of the foot that moves.
        wished: best distance along the track [m].
        bounds: shortest and longest chord between the feet [m].
    """
    ways = wished + CANDIDATE_FRACTIONS * (float(feet[end][0]) - wished)
    poses = track.lie(chain.feet[end], ways)
    other = np.broadcast_to(feet[1 - end], poses.shape)
    chords, _ = foot_chord(chain, *((other, poses) if end == FRONT else (poses, other)))
    good = track.safe(chain.feet[end], ways) & (chords >= bounds[0]) & (chords <= bounds[1])
    return poses[good]


def swing_poses(end: int, start: Array, finish: Array, height: Array, s: Array) -> Array:
    """Return the poses (n, 3) of a foot at fractions `s` (n,) of its step.

    It starts and ends at rest, leaves the ground upward, and pitches up before it is set down.

    Args:
        end: number of the foot.
        start: (n, 3) pose from which it lifts.
        finish: (n, 3) pose in which it lands.
        height: (n,) of the arch [m].
        s: (n,) 0 to 1.
    """
    poses = start + ease(s)[:, None] * (finish - start)
    poses[:, 1] += height * bump(s)
    # bump at s^LATE leaves the ground faster than quadratic and comes back quadratic.
    poses[:, 2] += MAX_FOOT_PITCH[end] * bump(s**PITCH_DELAY)
    return poses


@dataclass(frozen=True, eq=False)
class InchwormPose:
    """One worm at n moments.

    Attributes:
        positions: (n, links, 3) [m].
        rotations: (n, links, 3, 3).
        q: (n, J) joint values [rad].
        residual: (n,) distance of the moving foot from its goal [m].
    """

    positions: Array
    rotations: Array
    q: Array
    residual: Array


def solve_pose(
    chain: InchwormChain, track: InchwormTrack, base: int, rear: Array, front: Array
) -> InchwormPose:
    """Return the pose of all links of a worm.

    Args:
        chain: the worm.
        track: that it walks on.
        base: number of the foot that is the base of the chain.
        rear: (n, 3) poses of the rear foot.
        front: (n, 3) poses of the front foot.
    """
    R_WF, p_WF = zip(track.pose(rear), track.pose(front), strict=True)
    R_WB = R_WF[base]
    p_WB = p_WF[base] - turn(R_WB, chain.feet[base].middle)
    goals = turn_inverse(R_WB, p_WF[1 - base] - p_WB)
    turned = R_WB.transpose(0, 2, 1) @ R_WF[1 - base]
    pose, residual = _solve_joints(chain, base, rear, front, TipPlacement(goals, turned))
    q = np.zeros((len(rear), len(chain.figure.skeleton.parents)))
    q[:, list(chain.limbs[base].joints)] = pose.q
    X_BN = link_poses(chain.rooted[base], q)
    return InchwormPose(
        positions=p_WB[:, None] + turn(R_WB[:, None], X_BN[..., :3, 3]),
        rotations=R_WB[:, None] @ X_BN[..., :3, :3],
        q=q,
        residual=residual,
    )


def _solve_joints(
    chain: InchwormChain, base: int, rear: Array, front: Array, goal: TipPlacement
) -> tuple[LimbPose, Array]:
    """Return the chain with its tip at the goal, as near to a loop as possible, and residuals."""
    loop = chain.joint_values(
        loop_bends(chain, *foot_chord(chain, rear, front), rear[:, 2], front[:, 2])
    )
    if base != REAR:
        loop = loop[:, ::-1]
    n = len(rear)
    batch = chain.batches[base].rows(np.zeros(n, dtype=np.int64))
    batch = replace(batch, preferred=np.clip(loop, batch.lower, batch.upper))
    pose, damping = batch.pose(batch.preferred), np.broadcast_to(DAMPING * np.eye(6), (n, 6, 6))
    for gain in LOOP_GAINS:
        task = goal.task(batch, pose)
        placed = replace(pose, jacobian=task.jacobian.transpose(0, 2, 1))
        pose = batch.pose(damped_step(batch, placed, task.velocity, np.full(n, gain), damping))
    return _finish_reach(batch, pose, goal)


def _finish_reach(batch: LimbBatch, pose: LimbPose, goal: TipPlacement) -> tuple[LimbPose, Array]:
    """Solve limbs whose joints reached their limits with the full inverse kinematics."""
    error = np.linalg.norm(goal.task(batch, pose).velocity, axis=-1)
    far = np.flatnonzero(error > TIP_ITERATION.tolerance)
    residual: Array = error * batch.lengths
    if len(far):
        solution = reach(
            batch.rows(far), pose.rows(far), goal.places[far], goal.rows(far).orientations
        )
        for field in ("q", "X_BJ", "tips", "jacobian"):
            getattr(pose, field)[far] = getattr(solution.pose, field)
        residual[far] = solution.residual
    return pose, residual


def ground_penetration(
    chain: InchwormChain, track: InchwormTrack, rear: Array, front: Array
) -> Array:
    """Return how deep the links between the feet are in the ground (n,), 0 above it [m].

    A chain with a joint at its limit, which cannot give way, counts as sunk by its length.

    Args:
        chain: the worm.
        track: that it walks on.
        rear: (n, 3) poses of the rear foot.
        front: (n, 3) poses of the front foot.
    """
    pose = solve_pose(chain, track, REAR, rear, front)
    skeleton = chain.figure.skeleton
    at_limit = ((pose.q <= skeleton.lower) | (pose.q >= skeleton.upper)).any(axis=1)
    depth = np.where(at_limit, chain.length, 0.0)
    feet = [foot.number for foot in chain.feet]
    for number, link in enumerate(skeleton.links):
        if number in feet:
            continue
        for part in LINK_SAMPLES:
            inside = part * (link.ends[1] - link.ends[0])
            p = pose.positions[:, number] + turn(pose.rotations[:, number], inside)
            radius = link.radii[0] + part * (link.radii[1] - link.radii[0])
            up = track.ground.normal(p[:, 0], p[:, 2])[:, 1]
            link_depth = track.ground.height(p[:, 0], p[:, 2]) + radius / up - p[:, 1]
            depth = np.maximum(depth, link_depth)
    return depth
