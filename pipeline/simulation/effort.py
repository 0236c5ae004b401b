"""Effort: joint torques of a take's creatures and the cost of their transport.

Derivatives of the rows are central differences, so the first and the last row have none. Feet
that rest on the ground carry the force and moment of the motion (see `ground_reaction`); with
them and gravity, inverse dynamics gives the torque τ of every joint, and

    power   P = Σ |τ q̇|               over all joints
    energy  E = ∫ P dt                   by trapezoids
    cost of transport  E / (m g d)       d is the path length of the body over the ground.

This is mechanical work: braking costs as much as driving, and holding still costs nothing.
(The thesis takes force times time for work.)

Source: Sims 1987, 7.3.1 and 7.3.2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.ground_reaction import ground_reaction
from pipeline.simulation.figures.inverse_dynamics import (
    ExternalForces,
    FrameMasses,
    finite_difference_motion,
    inverse_dynamics,
)
from pipeline.simulation.figures.kinematics import JointTree
from pipeline.simulation.mechanism import Leg, Mechanism
from pipeline.simulation.spatial import Array, cross, matrix
from pipeline.simulation.stance_detection import (
    first_node,
    foot_path,
    ground_below,
    resting_rows,
)
from pipeline.simulation.take import Take

MIN_ROWS = 4
"""Rows needed beside the last: two that have derivatives, and one before and after them."""

MIN_DISTANCE = 1e-6
"""Path length below which there is no cost of transport [m]."""


@dataclass(frozen=True, eq=False)
class Effort:
    """Loads of one creature in n rows of a take.

    Attributes:
        name: of the creature.
        joints: (J,) names.
        prismatic: (J,) whether a joint slides.
        legs: (L,) names.
        mass: [kg].
        times: (n,) of the rows [s].
        speeds: (n, J) of the joints [rad/s or m/s].
        torques: (n, J) [N m, or N where a joint slides].
        foot_forces: (n, L, 3) ground reaction forces [N].
        unsupported_force: (n, 3) force that no foot carries, free fall excepted [N].
        unbalanced_moment: (n, 3) moment that the feet cannot give [N m].
        distance: path length of the body over the ground [m].
    """

    name: str
    joints: tuple[str, ...]
    prismatic: tuple[bool, ...]
    legs: tuple[str, ...]
    mass: float
    times: Array
    speeds: Array
    torques: Array
    foot_forces: Array
    unsupported_force: Array
    unbalanced_moment: Array
    distance: float

    @property
    def weight(self) -> float:
        """[N]."""
        return self.mass * GRAVITY

    @cached_property
    def power(self) -> Array:
        """(n,) mechanical power of all joints together [W]."""
        return np.abs(self.torques * self.speeds).sum(axis=-1)

    @property
    def energy(self) -> float:
        """Work of all joints over the rows [J]."""
        return float(np.trapezoid(self.power, self.times))

    @property
    def mean_power(self) -> float:
        """Energy per duration [W]."""
        return self.energy / float(self.times[-1] - self.times[0])

    @property
    def cost_of_transport(self) -> float | None:
        """Energy per weight and distance; None for a creature that stays in place."""
        if self.distance < MIN_DISTANCE:
            return None
        return self.energy / (self.mass * GRAVITY * self.distance)

    @property
    def max_torques(self) -> Array:
        """(J,) largest torques of the joints in either direction [N m or N]."""
        return np.abs(self.torques).max(axis=0)


def efforts_of(take: Take, names: Sequence[str]) -> list[Effort]:
    """Return the efforts of creatures on legs that stand on the terrain."""
    mechanisms = {name: one for one in take.mechanisms for name in one.performers}
    return [
        _effort(take, name, mechanisms[name], [leg for leg in take.legs if leg.performer == name])
        for name in names
    ]


def _effort(take: Take, name: str, mechanism: Mechanism, legs: Sequence[Leg]) -> Effort:
    dt = 1.0 / float(take.header.rate * take.header.samples)
    body = first_node(take, name)
    place = take.positions[:, body]
    motion = finite_difference_motion(
        _joint_values(take, name, mechanism), matrix(take.rotations[:, body]), place, dt
    )
    tree = JointTree(
        np.array(mechanism.parents, dtype=np.int64),
        np.array(mechanism.axes),
        np.array(mechanism.places),
        np.array(mechanism.prismatic, dtype=bool),
    )
    masses = FrameMasses(
        np.array(mechanism.masses), np.array(mechanism.centres), np.array(mechanism.inertias)
    )
    paths = [foot_path(take, leg) for leg in legs]
    tips = np.stack(paths, axis=1)
    stands = np.stack([_bears(take, leg, path) for leg, path in zip(legs, paths, strict=True)], 1)
    needed = inverse_dynamics(tree, masses, motion)
    # About the centre of mass, so that the unbalanced moments of creatures can be compared.
    centre = motion.X_WB[:, :3, 3] + _centre_arm(tree, masses, motion.q, motion.X_WB)
    moment = needed.moment + cross(motion.X_WB[:, :3, 3] - centre, needed.force)
    points = tips[1:-1]
    borne = ground_reaction(points - centre[:, None], stands, needed.force, moment)
    push = ExternalForces([leg.joint for leg in legs], points, borne.forces)
    return Effort(
        name,
        mechanism.joints,
        mechanism.prismatic,
        tuple(leg.name for leg in legs),
        float(masses.mass.sum()),
        np.arange(1, len(place) - 1) / float(take.header.rate * take.header.samples),
        motion.speeds,
        inverse_dynamics(tree, masses, motion, push).torques,
        borne.forces,
        borne.force,
        borne.moment,
        float(np.linalg.norm(np.diff(place[1:-1, [0, 2]], axis=0), axis=-1).sum()),
    )


def _joint_values(take: Take, name: str, mechanism: Mechanism) -> Array:
    """Return the joint values (K, J) of a creature [rad or m]."""
    column = {channel.name: i for i, channel in enumerate(take.channels)}
    return take.values[:, [column[f"{name}.{joint}"] for joint in mechanism.joints]]


def _bears(take: Take, leg: Leg, path: Array) -> NDArray[np.bool_]:
    """Return whether a foot can carry load in each row except the first and the last (n,)."""
    resting = resting_rows(take, leg, path, ground_below(take, path))
    return resting[1:] | resting[:-1]


def _centre_arm(tree: JointTree, masses: FrameMasses, q: Array, X_WB: Array) -> Array:
    """Return the centre of mass relative to the body's origin (n, 3), along world axes [m]."""
    X = tree.pose(q)
    joints = (X[..., :3, :3] @ masses.centre[:-1, :, None])[..., 0] + X[..., :3, 3]
    weighted = (masses.mass[:-1, None] * joints).sum(axis=-2) + masses.mass[-1] * masses.centre[-1]
    return (X_WB[..., :3, :3] @ (weighted / masses.mass.sum())[..., None])[..., 0]
