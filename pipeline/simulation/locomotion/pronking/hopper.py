"""The constants of one hopping creature: mass, legs, outline and limits of force."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import Problem, SceneError
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.mass import MassProperties
from pipeline.simulation.figures.base_change import displacement_at
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.figure_mass import FigureMass
from pipeline.simulation.figures.kinematics import JointTree
from pipeline.simulation.figures.limb_chains import group_chains
from pipeline.simulation.figures.network import LEG
from pipeline.simulation.figures.skeleton import BODY
from pipeline.simulation.figures.tip_ik import solve_each_tip, solve_tips
from pipeline.simulation.locomotion.foot_placement.leg_reachability import BALL, shortest_reaches
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.pronking.jump_parameters import (
    Jump,
    resolve_jump,
    round_down,
    round_up,
)
from pipeline.simulation.locomotion.pronking.leg_forces import BodyInertia
from pipeline.simulation.scalar_rotation import Rows
from pipeline.simulation.spatial import Array, normalized, turn
from pipeline.spec.creature import Pronk

LIFT_OFF_STRETCH, TOUCH_DOWN_STRETCH, STANCE_STRETCH = 0.955, 0.93, 0.975
"""Leg stretch at lift-off, at touch-down, and at most while the foot is down, in leg lengths."""

CROUCH_FRACTION = 0.36
"""Default crouch, as a fraction of the way from the lowest height to standing."""

CROUCHES = np.linspace(0.95, 0.2, 31)
"""Distances from hip to foot at which joints are looked for below the foot, in leg lengths."""

BELLY_CLEARANCE = 1.08
"""Lowest height of a body, in depths of its belly."""

FORCE_RESERVE = 1.7
"""Default leg force, in what the requested jump takes."""

MIN_LIFT_FORCE, MAX_CROUCH = 1.0001, 0.9999
"""Values suggested in error messages: leg force in body weights, crouch in standing heights."""

BALANCE_RESERVE = 1.0
"""Default balance moment beyond the static one, in body weights times leg length."""

MAX_TWIST = 2.0
"""Greatest moment about the vertical, in body weights times leg length."""

BELLY_DIRECTIONS = np.array(
    [(x, y, z) for x in (-1.0, -0.4, 0.0, 0.4, 1.0) for y in (-1.0, -0.4) for z in (-1.0, 0.0, 1.0)]
)
"""Directions in which a body meets the ground first."""


MISS_DISTANCE = 2e-4
"""Distance of a foot from its foothold that counts as a miss [m]."""

FOLD_CHECK_RATIO, DIRECTION_CHECK_COSINE = 1.25, 0.85
"""Places that inverse kinematics checks: nearer than this, in folded lengths, or farther from the
rest direction than this cosine."""

OUTLINE_DIRECTIONS = np.array(
    [(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)]
)
"""Directions in which the outermost points are looked for."""

LIMB_SAG = 0.12
"""How far heads, tails and feelers trail below their rest pose [rad]."""


@dataclass(frozen=True, eq=False)
class Hopper:
    """A hopping creature; it does not change during a simulation.

    Attributes:
        name: of the performer.
        config: its `pronk` block.
        mass: of the whole figure in its preferred pose, in the frame of the body.
        inertia: the inertia of `mass` as plain floats.
        hips: (n, 3) in the frame of the body [m].
        rest_feet: (n, 3) feet at rest, in the frame of the body, at height 0 [m].
        leg_lengths: (n,) [m].
        folded_lengths: (n,) least distances from hip to foot [m].
        foot_radii: (n,) [m].
        leg_masses: (n,) [kg].
        belly_points: (k, 3) points of the body that meet the ground first [m].
        standing_height: of the body above the ground [m].
        crouch_height: at which landings end [m].
        lowest_height: that belly and folded legs allow [m].
        jump: the requested jump.
        max_leg_force: of one leg [N].
        max_balance_moment: about horizontal axes [N m].
        max_twist_moment: about the vertical [N m].
        heading: at the start [rad].
        start: (x, z) at the start [m].
        half_extents: (2,) of the feet, along and across [m].
        leg_reach: which places its feet reach.
        outline: its outermost points, for clearing hurdles.
    """

    name: str
    config: Pronk
    mass: MassProperties
    inertia: BodyInertia
    hips: Array
    rest_feet: Array
    leg_lengths: Array
    folded_lengths: Array
    foot_radii: Array
    leg_masses: Array
    belly_points: Array
    standing_height: float
    crouch_height: float
    lowest_height: float
    jump: Jump
    max_leg_force: float
    max_balance_moment: float
    max_twist_moment: float
    heading: float
    start: Array
    half_extents: Array
    leg_reach: LegReach
    outline: Outline

    @property
    def leg_length(self) -> float:
        """Mean leg length [m]."""
        return float(self.leg_lengths.mean())

    @property
    def weight(self) -> float:
        """Weight [N]."""
        return self.mass.mass * GRAVITY

    def greatest_height(self, stretch: float, ahead: float, aside: float = 0.0) -> float:
        """Return the greatest body height at which all feet reach level ground [m].

        Args:
            stretch: of the legs, in their lengths.
            ahead: of the feet before their rest places [m].
            aside: of the feet to the right of them [m].
        """
        rest = self.rest_feet + np.array([ahead, 0.0, aside])
        return float(
            _reach_heights(stretch * self.leg_lengths, self.hips, rest, self.foot_radii).min()
        )


def build_hoppers(
    herd: Herd, cast_indices: Sequence[int], configs: Sequence[Pronk]
) -> list[Hopper]:
    """Return the hoppers of a herd.

    Args:
        herd: the creatures.
        cast_indices: their places in the scene's cast.
        configs: their `pronk` blocks.

    Raises:
        SceneError: a creature cannot hop as configured; lists all of them.
    """
    folds = shortest_reaches(herd)
    problems, hoppers = list[Problem](), list[Hopper]()
    for c, (cast_index, config) in enumerate(zip(cast_indices, configs, strict=True)):
        try:
            hoppers.append(build_hopper(herd, c, cast_index, config, folds))
        except SceneError as error:
            problems += error.problems
    if problems:
        raise SceneError(problems)
    return hoppers


def build_hopper(herd: Herd, c: int, cast_index: int, config: Pronk, folds: Array) -> Hopper:
    """Return one creature of a herd as a hopper.

    Args:
        herd: the creatures.
        c: number of the creature in the herd.
        cast_index: its place in the scene's cast.
        config: its `pronk` block.
        folds: (L,) least distances from hip to foot of all legs of the herd [m].

    Raises:
        SceneError: it cannot hop as configured.
    """
    where, figure = f"cast[{cast_index}].pronk", herd.figures[c]
    own = np.flatnonzero(herd.owner == c)
    if not len(own):
        message = f"figure '{figure.name}' has no legs to hop on; take `pronk` away"
        raise SceneError([Problem(where, message)])
    masses = FigureMass(figure)
    mass = masses.at_rest
    hips, lengths, foot_radii = herd.hips[own], herd.legs.lengths[own], herd.foot_radius[own]
    rest = np.stack([herd.rest[own, 0], np.zeros(len(own)), herd.rest[own, 1]], axis=-1)
    leg_length = float(lengths.mean())
    heights = _reach_heights(LIFT_OFF_STRETCH * lengths, hips, rest, foot_radii)
    jump = resolve_jump(where, config, float(heights.min()))
    least = np.maximum(folds[own], _clear_folds(herd, own))
    lowest = _lowest_height(figure.belly, hips, rest, least, foot_radii)
    standing = float(herd.body_height[c])
    crouch = _crouch_height(where, config, lowest, standing)
    weight = mass.mass * GRAVITY
    # Uneven ground may leave half of the rise.
    rise = max(0.5 * (standing - crouch), 0.06 * leg_length)
    force = _leg_force(where, config, jump, rise, len(own))
    offset = float(np.hypot(mass.centre[0], mass.centre[2])) / leg_length
    default_balance = BALANCE_RESERVE + offset * (force * len(own))
    balance = default_balance if config.balance is None else config.balance
    return Hopper(
        name=herd.names[c],
        config=config,
        mass=mass,
        inertia=BodyInertia(_tensor_rows(mass.inertia), _tensor_rows(np.linalg.inv(mass.inertia))),
        hips=hips,
        rest_feet=rest,
        leg_lengths=lengths,
        folded_lengths=folds[own],
        foot_radii=foot_radii,
        leg_masses=np.array([masses.mass_of(limb.links) for limb in figure.skeleton.legs]),
        belly_points=extreme_points(figure.body.vertices, BELLY_DIRECTIONS),
        standing_height=standing,
        crouch_height=crouch,
        lowest_height=lowest,
        jump=jump,
        max_leg_force=force * weight,
        max_balance_moment=balance * weight * leg_length,
        max_twist_moment=MAX_TWIST * weight * leg_length,
        heading=float(herd.headings[c]),
        start=herd.starts[c],
        half_extents=np.maximum(herd.footprint[c], 0.2 * leg_length),
        leg_reach=LegReach(herd, own, folds[own]),
        outline=Outline(herd, own),
    )


def _leg_force(where: str, config: Pronk, jump: Jump, rise: float, legs: int) -> float:
    """Return the greatest force of one of `legs` legs [body weights]."""
    # A push takes h / rise + 1 body weights.
    pushes = (
        FORCE_RESERVE * (jump.height / rise + 1.0) * math.hypot(1.0, 0.5 * jump.forward / jump.up)
    )
    force = pushes / legs if config.max_force is None else config.max_force
    if force * legs <= 1.0:
        message = (
            f"{legs} legs of {force:g} body weights give {force * legs:.3g} together, and "
            f"it takes more than 1 to leave the ground; take "
            f"{round_up(MIN_LIFT_FORCE / legs)} or more"
        )
        raise SceneError([Problem(f"{where}.max_force", message)])
    return force


def _crouch_height(where: str, config: Pronk, low: float, stand: float) -> float:
    if config.crouch is None:
        return low + CROUCH_FRACTION * (stand - low)
    if not low <= config.crouch < stand:
        deep, high = round_up(low), round_down(MAX_CROUCH * stand)
        nearest = deep if config.crouch < low else high
        message = (
            f"from a crouch of {config.crouch:g} it cannot land or push: its body stands "
            f"{stand:.3g} above the ground and comes down to {low:.3g} at this scale; take "
            f"{nearest}, or another one from {deep} to {high}"
        )
        raise SceneError([Problem(f"{where}.crouch", message)])
    return config.crouch


def _reach_heights(lengths: Array, hips: Array, rest: Array, foot_radii: Array) -> Array:
    """Return the heights (n,) from which legs of given lengths just reach the ground [m]."""
    across = ((rest - hips)[:, [0, 2]] ** 2).sum(axis=-1)
    return np.sqrt(np.maximum(lengths**2 - across, 0.0)) - hips[:, 1] + foot_radii


def _clear_folds(herd: Herd, own: NDArray[np.int64]) -> Array:
    """Return the distances (n,) from hip to foot from which on all joints are above the foot [m].

    Of legs that stand as at rest, their feet in the same directions: a fetlock or heel that comes
    lower would be in the ground.
    """
    legs = herd.legs.rows(own)
    rest = legs.pose(legs.preferred)
    rows, last = np.arange(len(own)), legs.is_joint.sum(axis=1) - 1
    way = rest.tips - herd.hips[own]
    feet = normalized(rest.tips - rest.X_BJ[rows, last, :3, 3])
    distances = CROUCHES[:, None] * legs.lengths
    goals = herd.hips[own] + distances[..., None] * normalized(way)
    chains = group_chains(legs, herd.owner[own])
    found = solve_tips(legs, chains, goals, np.broadcast_to(feet, goals.shape))
    is_bend = legs.is_joint & (np.arange(legs.is_joint.shape[1]) >= BALL)
    heights = np.where(is_bend, found.X_BJ[..., 1, 3], np.inf).min(axis=-1) - goals[..., 1]
    # Those drawn lower stay as they are.
    below = heights < np.minimum(heights[0], 0.0)
    first = np.where(below.any(axis=0), below.argmax(axis=0), len(CROUCHES))
    least: Array = distances[np.maximum(first - 1, 0), rows]
    return np.where(first < len(CROUCHES), least, 0.0)


def _lowest_height(
    belly: float, hips: Array, rest: Array, folds: Array, foot_radii: Array
) -> float:
    """Return the least body height with room for belly and knees [m]."""
    across = ((rest - hips)[:, [0, 2]] ** 2).sum(axis=-1)
    folded = np.sqrt(np.maximum(folds**2 - across, 0.0)) - hips[:, 1] + foot_radii
    return max(BELLY_CLEARANCE * belly, 1.03 * float(folded.max()))


def extreme_points(vertices: Array, directions: Array) -> Array:
    """Return the vertices (k, 3) farthest out in any of some directions."""
    farthest = np.unique((vertices @ directions.T).argmax(axis=0))
    return np.asarray(vertices[farthest], dtype=float)


def _tensor_rows(m: NDArray[np.floating[Any]]) -> Rows:
    (a, b, c), (d, e, f), (g, h, i) = m.tolist()
    return (a, b, c), (d, e, f), (g, h, i)


class LegReach:
    """Tests whether the legs of one creature reach given places.

    The distance from hip to foot decides for most places. Only where a leg points far from its
    rest direction, or is nearly folded or stretched, joint limits can prevent it: there inverse
    kinematics decides.

    Attributes:
        herd: the creatures.
        own: (n,) numbers of the creature's legs in the herd.
        folds: (n,) least distances from hip to foot [m].
    """

    def __init__(self, herd: Herd, own: NDArray[np.int64], folds: Array) -> None:
        self.herd, self.own, self.folds = herd, own, folds
        self._hips = herd.hips[own]
        rest = np.stack([herd.rest[own, 0], 0.0 * folds, herd.rest[own, 1]], axis=-1)
        rest[:, 1] = -herd.body_height[herd.owner[own]]
        rest -= self._hips
        self._rest = rest / np.linalg.norm(rest, axis=-1, keepdims=True)

    def misses(self, feet: Array) -> NDArray[np.bool_]:
        """Return which legs (n,) do not reach feet (n, 3) in the frame of the body."""
        way = feet - self._hips
        far = np.sqrt((way * way).sum(axis=-1))
        odd = (way * self._rest).sum(axis=-1) < DIRECTION_CHECK_COSINE * far
        odd |= far < FOLD_CHECK_RATIO * self.folds
        odd |= far > 0.97 * self.herd.legs.lengths[self.own]
        missed = np.zeros(len(far), dtype=bool)
        rows = np.flatnonzero(odd)
        if len(rows):
            herd = self.herd
            _, gap = solve_each_tip(herd.legs, herd.chains, self.own[rows], feet[rows])
            missed[rows] = gap > MISS_DISTANCE
        return missed


class Outline:
    """The outermost points of a creature, which have to clear a hurdle.

    Attributes:
        body: (k, 3) points that do not belong to legs, in the frame of the body [m].
    """

    def __init__(self, herd: Herd, own: NDArray[np.int64]) -> None:
        figure = herd.figures[int(herd.owner[own[0]])]
        self.body = _body_outline(figure)
        self._legs = herd.legs.rows(own)
        self._chains = group_chains(self._legs, np.zeros(len(own), dtype=np.int64))
        # Leg and joint that each leg point hangs on, and its offset from that joint.
        self._at, self._arms = _leg_outline(figure, self._legs.places)

    def legs(self, feet: Array) -> Array:
        """Return the leg points (m, k, 3) for feet (m, n, 3), in the frame of the body [m]."""
        X = solve_tips(self._legs, self._chains, feet).X_BJ[:, self._at[:, 0], self._at[:, 1]]
        return X[..., :3, 3] + turn(X[..., :3, :3], self._arms)


def _body_outline(figure: Figure) -> Array:
    tree = JointTree.of(figure.skeleton)
    X_BJ, found = tree.pose(figure.skeleton.preferred), []
    limbs = {link: limb for limb in figure.skeleton.limbs for link in limb.links}
    for piece in figure.pieces:
        limb = limbs.get(piece.link)
        if limb is not None and limb.kind == LEG:
            continue
        joint, points = (
            figure.skeleton.links[piece.link].joint,
            extreme_points(piece.solid.vertices, OUTLINE_DIRECTIONS),
        )
        if joint != BODY:
            X = displacement_at(tree, X_BJ, joint)
            points = points @ X[:3, :3].T + X[:3, 3]
        if limb is not None:
            out = points - X_BJ[limb.joints[0], :3, 3]
            points[:, 1] -= LIMB_SAG * np.hypot(out[:, 0], out[:, 2])
        found.append(points)
    return np.concatenate(found)


def _leg_outline(figure: Figure, places: Array) -> tuple[NDArray[np.int64], Array]:
    at, arms = list[tuple[int, int]](), []
    for leg, limb in enumerate(figure.skeleton.legs):
        for piece in figure.pieces:
            if piece.link not in limb.links:
                continue
            column = limb.joints.index(figure.skeleton.links[piece.link].joint)
            own = extreme_points(piece.solid.vertices, OUTLINE_DIRECTIONS) - places[leg, column]
            at += [(leg, column)] * len(own)
            arms.append(own)
    return np.array(at), np.concatenate(arms)
