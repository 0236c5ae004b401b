"""Inverse dynamics: joint torques of a given motion, and motions from rows of poses.

Recursive Newton-Euler: outward from the body, each link's velocity and acceleration follow from
the one before; inward, each joint carries what the links beyond it need,

    F = m (a_C - g),   N = I α + ω × I ω,

and the part along its axis is the torque of a muscle; bearings carry the rest. Vectors are in
world axes, so no frame turns under its derivatives.

Arrays of frames (..., J + 1, ...) have the body as their last, at index `BODY`.

Source: Luh, Walker and Paul 1980; Sims 1987, 7.3.1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.mass import MassProperties, joined
from pipeline.simulation.figures.ik_goals import rotation_vector
from pipeline.simulation.figures.kinematics import JointTree
from pipeline.simulation.figures.skeleton import BODY, Skeleton
from pipeline.simulation.spatial import UP, Array, cross, turn


@dataclass(frozen=True, eq=False)
class FrameMasses:
    """Masses fixed to the frames of J joints, and to the body, the last.

    Attributes:
        mass: (J + 1,), zero between the joints of a ball joint [kg].
        centre: (J + 1, 3) centres of mass from the joints' places, in the creation frame [m].
        inertia: (J + 1, 3, 3) about them [kg m²].
    """

    mass: Array
    centre: Array
    inertia: Array

    @staticmethod
    def of(skeleton: Skeleton, links: Sequence[MassProperties]) -> FrameMasses:
        """Return the masses of a skeleton's links, given in the creation frame."""
        n = len(skeleton.parents)
        mass, centre, inertia = np.zeros(n + 1), np.zeros((n + 1, 3)), np.zeros((n + 1, 3, 3))
        places = np.concatenate([skeleton.places, np.zeros((1, 3))])
        for frame in (*range(n), BODY):
            own = [m for m, link in zip(links, skeleton.links, strict=True) if link.joint == frame]
            if own:
                whole = joined(own)
                mass[frame], inertia[frame] = whole.mass, whole.inertia
                centre[frame] = whole.centre - places[frame]
        return FrameMasses(mass, centre, inertia)

    def limb(self, joints: Sequence[int], count: int) -> FrameMasses:
        """Return the masses of some joints alone, on a massless body.

        Args:
            joints: their numbers.
            count: number of joints in the result; those beyond `joints` are massless.
        """
        rows, lacking = list(joints), count - len(joints) + 1
        return FrameMasses(
            np.concatenate([self.mass[rows], np.zeros(lacking)]),
            np.concatenate([self.centre[rows], np.zeros((lacking, 3))]),
            np.concatenate([self.inertia[rows], np.zeros((lacking, 3, 3))]),
        )


@dataclass(frozen=True, eq=False)
class FigureMotion:
    """The motion of a figure at some moments.

    Attributes:
        q: (..., J) joint values [rad or m].
        speeds, accelerations: (..., J) their derivatives.
        X_WB: (..., 4, 4) pose of the body.
        spin, spin_rate: (..., 3) its angular velocity and acceleration ω, α [rad/s, rad/s²].
        acceleration: (..., 3) of the body's origin [m/s²].
    """

    q: Array
    speeds: Array
    accelerations: Array
    X_WB: Array
    spin: Array
    spin_rate: Array
    acceleration: Array


@dataclass(frozen=True, eq=False)
class ExternalForces:
    """External forces on points of links, such as those of the ground on feet.

    Attributes:
        frames: (m,) joints of the links; `BODY` for the body.
        points: (..., m, 3) in the world [m].
        forces: (..., m, 3) [N].
    """

    frames: Sequence[int]
    points: Array
    forces: Array


@dataclass(frozen=True, eq=False)
class JointLoad:
    """The load of a motion.

    Attributes:
        torques: (..., J) of the joints; forces where they slide [N m or N].
        force: (..., 3) still needed on the body beside all external forces [N].
        moment: (..., 3) likewise, about the body's origin [N m].
    """

    torques: Array
    force: Array
    moment: Array


def inverse_dynamics(
    tree: JointTree,
    masses: FrameMasses,
    motion: FigureMotion,
    push: ExternalForces | None = None,
    gravity: float = GRAVITY,
) -> JointLoad:
    """Return the load of a motion.

    Args:
        tree: the joints.
        masses: that they move.
        motion: at any number of moments.
        push: external forces.
        gravity: [m/s²].
    """
    X_WB = motion.X_WB[..., None, :, :]
    X = X_WB @ tree.pose(motion.q)
    X = np.concatenate([X, np.broadcast_to(X_WB, (*X.shape[:-3], 1, 4, 4))], axis=-3)
    R, p = X[..., :3, :3], X[..., :3, 3]
    axes = turn(R[..., :-1, :, :], tree.axes)
    force, moment = _link_wrenches(tree, masses, motion, (R, p, axes), gravity)
    if push is not None:
        for i, frame in enumerate(push.frames):
            f = push.forces[..., i, :]
            force[frame] = force[frame] - f
            moment[frame] = moment[frame] - cross(push.points[..., i, :] - p[..., frame, :], f)
    torques = np.empty(motion.q.shape)
    for j in reversed(tree.outward):
        f, n, above = force[j], moment[j], tree.parents[j]
        carried = f if tree.prismatic[j] else n
        torques[..., j] = (axes[..., j, :] * carried).sum(axis=-1)
        force[above] = force[above] + f
        moment[above] = moment[above] + n + cross(p[..., j, :] - p[..., above, :], f)
    return JointLoad(torques, force[BODY], moment[BODY])


def _link_wrenches(
    tree: JointTree,
    masses: FrameMasses,
    motion: FigureMotion,
    frames: tuple[Array, Array, Array],
    g: float,
) -> tuple[list[Array], list[Array]]:
    """Return the force, and the moment about its joint, that each link alone needs, by frame."""
    R, p, axes = frames
    J = len(tree.parents)
    nothing = np.zeros((*p.shape[:-2], 3))
    ω, α, a = ([nothing] * (J + 1) for _ in range(3))
    # An upward acceleration g of the body is equivalent to gravity.
    ω[BODY], α[BODY], a[BODY] = motion.spin, motion.spin_rate, motion.acceleration + g * UP
    for j in tree.outward:
        above = tree.parents[j]
        arm, axis = p[..., j, :] - p[..., above, :], axes[..., j, :]
        rate, change = (v[..., j, None] * axis for v in (motion.speeds, motion.accelerations))
        spin = ω[above]
        a[j] = a[above] + cross(α[above], arm) + cross(spin, cross(spin, arm))
        if tree.prismatic[j]:
            ω[j], α[j] = spin, α[above]
            a[j] = a[j] + 2.0 * cross(spin, rate) + change
        else:
            ω[j], α[j] = spin + rate, α[above] + change + cross(spin, rate)
    force, moment = [nothing] * (J + 1), [nothing] * (J + 1)
    for j in np.flatnonzero(masses.mass).tolist():
        turned = R[..., j, :, :]
        c = turn(turned, masses.centre[j])
        force[j] = masses.mass[j] * (a[j] + cross(α[j], c) + cross(ω[j], cross(ω[j], c)))
        inertia = turned @ masses.inertia[j] @ np.swapaxes(turned, -1, -2)
        own = turn(inertia, α[j]) + cross(ω[j], turn(inertia, ω[j]))
        moment[j] = own + cross(c, force[j])
    return force, moment


def finite_difference_motion(q: Array, R_WB: Array, p_WB: Array, dt: float) -> FigureMotion:
    """Return the motion in all rows but the first and the last, by central differences.

    Changes within a row count as their mean.

    Args:
        q: (K, ..., J) joint values [rad or m].
        R_WB: (K, ..., 3, 3) orientation of the body.
        p_WB: (K, ..., 3) its place [m].
        dt: time between two rows [s].
    """
    X = np.zeros((*p_WB[1:-1].shape[:-1], 4, 4))
    X[..., :3, :3], X[..., :3, 3], X[..., 3, 3] = R_WB[1:-1], p_WB[1:-1], 1.0
    spins = rotation_between(R_WB[:-1], R_WB[1:]) / dt
    return FigureMotion(
        q[1:-1],
        (q[2:] - q[:-2]) / (2.0 * dt),
        _second_difference(q, dt),
        X,
        0.5 * (spins[1:] + spins[:-1]),
        (spins[1:] - spins[:-1]) / dt,
        _second_difference(p_WB, dt),
    )


def rotation_between(before: Array, after: Array) -> Array:
    """Return the rotation vectors (..., 3) from `before` to `after` (..., 3, 3), in the world."""
    return rotation_vector(after @ np.swapaxes(before, -1, -2))


def _second_difference(v: Array, dt: float) -> Array:
    return (v[2:] - 2.0 * v[1:-1] + v[:-2]) / (dt * dt)
