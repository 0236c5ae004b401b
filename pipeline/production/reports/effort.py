"""Effort: the torques of a creature's joints over a take, and what its way costs.

Joint values and the poses of the body are the take's rows; their derivatives are central
differences, so the first and the last row have none. What the motion needs as force and
moment is carried by the feet that rest on the ground (see `support`); with these forces and
gravity, inverse dynamics gives the torque τ of every joint, and

    power   P = Σ |τ q̇|               over all joints
    energy  E = ∫ P dt                   by trapezoids
    cost of transport  E / (m g d)       d being the way of the body over the ground.

Muscles that brake cost as much as muscles that drive, and holding still costs nothing: what
is measured is mechanical work, not oxygen. (The thesis takes force times time for work.)

Source: Sims 1987, 7.3.1 and 7.3.2.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import UsageError
from pipeline.production.reports.gait_contacts import rests, tips_of
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.support import support
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.figure_mass import FigureMass
from pipeline.simulation.figures.inverse_dynamics import (
    ExternalForces,
    FrameMasses,
    finite_difference_motion,
    inverse_dynamics,
)
from pipeline.simulation.figures.kinematics import JointTree
from pipeline.simulation.locomotion.walking import Walkers
from pipeline.simulation.simulate import Simulation
from pipeline.simulation.spatial import Array, cross, matrix
from pipeline.simulation.take import Take
from pipeline.spec import Scene

LEAST_ROWS = 4
"""Of a take beside its last: two with derivatives at least, for a work between them."""


@dataclass(frozen=True, eq=False)
class Effort:
    """What the motion of one creature takes, in n rows of a take.

    Attributes:
        name: of the creature.
        figure: its.
        legs: names of its legs.
        mass: [kg].
        times: (n,) of the rows [s].
        speeds: (n, J) of the joints [rad/s or m/s].
        torques: (n, J) [N m, or N where a joint slides].
        feet: (n, L, 3) forces of the ground on the legs' feet [N].
        unborne: (n, 3) force that nobody carries: no foot is down, and it does not fall
            freely [N].
        unbalanced: (n, 3) moment that the feet cannot give [N m].
        distance: way of the body over the ground [m].
    """

    name: str
    figure: Figure
    legs: tuple[str, ...]
    mass: float
    times: Array
    speeds: Array
    torques: Array
    feet: Array
    unborne: Array
    unbalanced: Array
    distance: float

    @cached_property
    def power(self) -> Array:
        """(n,) mechanical power of all joints together [W]."""
        result: Array = np.abs(self.torques * self.speeds).sum(axis=-1)
        return result

    @property
    def energy(self) -> float:
        """Work of all joints over the rows [J]."""
        return float(np.trapezoid(self.power, self.times))

    @property
    def mean_power(self) -> float:
        """[W]."""
        return self.energy / float(self.times[-1] - self.times[0])

    @property
    def cost_of_transport(self) -> float | None:
        """Energy by weight and way; None for who does not go anywhere."""
        if self.distance < 1e-6:
            return None
        return self.energy / (self.mass * GRAVITY * self.distance)

    @property
    def largest(self) -> Array:
        """(J,) greatest torques of the joints, either way [N m or N]."""
        result: Array = np.abs(self.torques).max(axis=0)
        return result


def legged_of(scene: Scene) -> list[tuple[Walkers, int]]:
    """Return the creatures that stand on the terrain on legs, each with its herd.

    Raises:
        UsageError: there are none, or the film is too short to tell accelerations.
        PronkError: the scene cannot begin.
    """
    riders = {member.name for _, member in scene.creatures if member.parent is not None}
    found = [
        (troupe, c)
        for troupe in Simulation(scene).troupes
        if isinstance(troupe, Walkers)
        for c, name in enumerate(troupe.herd.names)
        if name not in riders and troupe.herd.figures[c].skeleton.legs
    ]
    if not found:
        raise UsageError(
            "nobody in this scene stands on legs, so there is no effort to tell; "
            "give it a creature with legs"
        )
    if scene.n_frames * scene.samples < LEAST_ROWS:
        raise UsageError(
            f"{scene.n_frames} frames are too few to tell accelerations; give the scene a "
            f"longer `duration`, {LEAST_ROWS} frames or more"
        )
    return found


def efforts(legged: Iterable[tuple[Walkers, int]], take: Take) -> list[Effort]:
    """Return the efforts of creatures.

    Args:
        legged: herds and numbers in them, see `legged_of`.
        take: what became of them.
    """
    return [_effort(walkers, c, take) for walkers, c in legged]


def _effort(walkers: Walkers, c: int, take: Take) -> Effort:
    """Return the effort of creature `c`."""
    herd = walkers.herd
    name, figure = herd.names[c], herd.figures[c]
    skeleton, inertia = figure.skeleton, FigureMass(figure)
    dt = 1.0 / float(take.header.rate * take.header.samples)
    body = [node.performer for node in take.nodes].index(name)
    place = take.positions[:, body]
    motion = finite_difference_motion(
        _joints(take, name, figure), matrix(take.rotations[:, body]), place, dt
    )
    tree, masses = JointTree.of(skeleton), FrameMasses.of(skeleton, inertia.links)
    legs = np.flatnonzero(herd.owner == c)
    tips = np.stack([tips_of(take, herd, int(leg)) for leg in legs], axis=1)
    stands = np.stack([_stands(tips[:, i], walkers, int(leg), dt) for i, leg in enumerate(legs)], 1)
    needed = inverse_dynamics(tree, masses, motion)
    # About the centre of mass, so that a moment left over means the same for everybody.
    middle = motion.X_WB[:, :3, 3] + _centre_arm(tree, masses, motion.q, motion.X_WB)
    about = needed.moment + cross(motion.X_WB[:, :3, 3] - middle, needed.force)
    points = tips[1:-1]
    borne = support(points - middle[:, None], stands, needed.force, about)
    frames = [limb.joints[-1] for limb in skeleton.legs]
    load = inverse_dynamics(tree, masses, motion, ExternalForces(frames, points, borne.forces))
    return Effort(
        name,
        figure,
        tuple(limb.name for limb in skeleton.legs),
        float(masses.mass.sum()),
        np.arange(1, len(place) - 1) / float(take.header.rate * take.header.samples),
        motion.speeds,
        load.torques,
        borne.forces,
        borne.force,
        borne.moment,
        float(np.linalg.norm(np.diff(place[1:-1, [0, 2]], axis=0), axis=-1).sum()),
    )


def _joints(take: Take, name: str, figure: Figure) -> Array:
    """Return the joint values (K, J) of a creature [rad or m]."""
    column = {channel.name: i for i, channel in enumerate(take.channels)}
    return take.values[:, [column[f"{name}.{joint}"] for joint in figure.skeleton.joint_names]]


def _stands(tip: Array, walkers: Walkers, leg: int, dt: float) -> NDArray[np.bool_]:
    """Tell in which rows but the first and the last a foot can bear (n,)."""
    still = rests(tip, walkers.herd, walkers.world.ground, leg, dt)
    result: NDArray[np.bool_] = still[1:] | still[:-1]
    return result


def _centre_arm(tree: JointTree, masses: FrameMasses, q: Array, X_WB: Array) -> Array:
    """Return where the centre of mass is from the body's origin (n, 3), in the world [m]."""
    X = tree.pose(q)
    joints = (X[..., :3, :3] @ masses.centre[:-1, :, None])[..., 0] + X[..., :3, 3]
    weighted = (masses.mass[:-1, None] * joints).sum(axis=-2) + masses.mass[-1] * masses.centre[-1]
    result: Array = (X_WB[..., :3, :3] @ (weighted / masses.mass.sum())[..., None])[..., 0]
    return result
