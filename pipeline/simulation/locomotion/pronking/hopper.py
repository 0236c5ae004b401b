"""Pronker: the constants of one creature that hops."""

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
from pipeline.simulation.figures.figure_mass import FigureMass as Masses
from pipeline.simulation.figures.kinematics import JointTree
from pipeline.simulation.figures.limb_chains import group_chains
from pipeline.simulation.figures.network import LEG
from pipeline.simulation.figures.rest_ik import solve_each_near_rest, solve_near_rest
from pipeline.simulation.figures.skeleton import BODY
from pipeline.simulation.locomotion.foot_placement.leg_reachability import shortest_reaches
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.pronking.jump_parameters import (
    Jump,
    resolve_jump,
    round_down,
    round_up,
)
from pipeline.simulation.locomotion.pronking.leg_forces import BodyInertia
from pipeline.simulation.scalar_rotation import Rows
from pipeline.simulation.spatial import Array, turn
from pipeline.spec.creature import Pronk

LIFT_OFF_STRETCH, TOUCH_DOWN_STRETCH, STANCE_STRETCH = 0.955, 0.93, 0.975
"""How far a leg is stretched where it leaves the ground and where it comes down, and at most
while it is down, as parts of its length."""

CROUCH_FRACTION = 0.36
"""Of a crouch that nobody asked for, between the lowest and standing."""

BELLY_CLEARANCE = 1.08
"""Lowest height of a body, in the depth of its belly."""

FORCE_RESERVE = 1.7
"""Greatest force of legs, in what an ordinary jump takes, if nobody says."""

MIN_LIFT_FORCE, MAX_CROUCH = 1.0001, 0.9999
"""Force of all legs that lifts a body, in its weight, and height of the highest crouch, in that
of standing: what is said to who asks for less or more."""

BALANCE_RESERVE = 1.0
"""Moment that is left for bumps, in body weights times leg length, if nobody says."""

MAX_TWIST = 2.0
"""Greatest moment about the vertical, in body weights times leg length."""

BELLY_DIRECTIONS = np.array(
    [(x, y, z) for x in (-1.0, -0.4, 0.0, 0.4, 1.0) for y in (-1.0, -0.4) for z in (-1.0, 0.0, 1.0)]
)
"""In which the points of a body are looked for that meet the ground first."""


@dataclass(frozen=True, eq=False)
class Hopper:
    """A creature that hops.

    Attributes:
        name: of it.
        number: its place in the scene's cast.
        words: how it was asked to hop.
        mass: of all of it, in its preferred pose, in the frame of the body.
        inertia: the same, as numbers.
        hips: (n, 3) in the frame of the body [m].
        rest: (n, 3) feet at rest likewise, whose heights do not count [m].
        lengths: (n,) of the legs [m].
        folds: (n,) least distances from hips to feet [m].
        soles: (n,) radii of the feet [m].
        leg_mass: (n,) [kg].
        belly: (k, 3) points of the body that meet the ground first [m].
        stand, crouch, low: heights of the body above the ground: standing, where landings end,
            and the lowest there is [m].
        jump: that it was asked for.
        most: force of one leg [N].
        balance, twist: greatest moments [N m].
        heading: where it looks at the begin [rad].
        start: (x, z) where it begins [m].
        wide: (2,) half extents of its feet along and across [m].
        legs: how far they come.
        silhouette: by which it passes over things.
    """

    name: str
    number: int
    words: Pronk
    mass: MassProperties
    inertia: BodyInertia
    hips: Array
    rest: Array
    lengths: Array
    folds: Array
    soles: Array
    leg_mass: Array
    belly: Array
    stand: float
    crouch: float
    low: float
    jump: Jump
    most: float
    balance: float
    twist: float
    heading: float
    start: Array
    wide: Array
    legs: LegReach
    silhouette: Outline

    @property
    def leg(self) -> float:
        """Mean length of the legs [m]."""
        return float(self.lengths.mean())

    @property
    def weight(self) -> float:
        """[N]."""
        return self.mass.mass * GRAVITY

    def tallest(self, stretch: float, ahead: float, aside: float = 0.0) -> float:
        """Return the greatest height at which all feet reach level ground [m].

        Args:
            stretch: of the legs, as a part of their lengths.
            ahead: how far feet are before their places at rest [m].
            aside: how far to the right of them [m].
        """
        rest = self.rest + np.array([ahead, 0.0, aside])
        return float(_reach_heights(stretch * self.lengths, self.hips, rest, self.soles).min())


def build_hoppers(herd: Herd, numbers: Sequence[int], words: Sequence[Pronk]) -> list[Hopper]:
    """Return the creatures of a herd as they hop.

    Raises:
        SceneError: one cannot hop as it is asked to.
    """
    folds = shortest_reaches(herd)
    problems, found = list[Problem](), list[Hopper]()
    for c, (number, one) in enumerate(zip(numbers, words, strict=True)):
        try:
            found.append(build_hopper(herd, c, number, one, folds))
        except SceneError as error:
            problems += error.problems
    if problems:
        raise SceneError(problems)
    return found


def build_hopper(herd: Herd, c: int, number: int, words: Pronk, folds: Array) -> Hopper:
    """Return one creature of a herd as it hops.

    Args:
        herd: that it belongs to.
        c: its number there.
        number: its place in the scene's cast.
        words: how it was asked to hop.
        folds: least distances from hips to feet of all legs of the herd (L,) [m].

    Raises:
        SceneError: it cannot hop so.
    """
    where, figure = f"cast[{number}].pronk", herd.figures[c]
    own = np.flatnonzero(herd.owner == c)
    if not len(own):
        message = f"figure '{figure.name}' has no legs to hop on; take `pronk` away"
        raise SceneError([Problem(where, message)])
    masses = Masses(figure)
    mass = masses.at_rest
    hips, lengths, soles = herd.hips[own], herd.legs.lengths[own], herd.sole[own]
    rest = np.stack([herd.rest[own, 0], np.zeros(len(own)), herd.rest[own, 1]], axis=-1)
    leg = float(lengths.mean())
    jump = resolve_jump(
        where, words, float(_reach_heights(LIFT_OFF_STRETCH * lengths, hips, rest, soles).min())
    )
    low = _lowest_height(figure.belly, hips, rest, folds[own], soles)
    stand = float(herd.body_height[c])
    crouch = _crouch_height(where, words, low, stand)
    weight = mass.mass * GRAVITY
    # Uneven ground may leave half of the rise.
    most = _leg_force(where, words, jump, max(0.5 * (stand - crouch), 0.06 * leg), len(own))
    aside = float(np.hypot(mass.centre[0], mass.centre[2])) / leg
    enough = BALANCE_RESERVE + aside * (most * len(own))
    balance = enough if words.balance is None else words.balance
    return Hopper(
        name=herd.names[c],
        number=number,
        words=words,
        mass=mass,
        inertia=BodyInertia(_tensor_rows(mass.inertia), _tensor_rows(np.linalg.inv(mass.inertia))),
        hips=hips,
        rest=rest,
        lengths=lengths,
        folds=folds[own],
        soles=soles,
        leg_mass=np.array([masses.mass_of(limb.links) for limb in figure.skeleton.legs]),
        belly=_extremes(figure.body.vertices),
        stand=stand,
        crouch=crouch,
        low=low,
        jump=jump,
        most=most * weight,
        balance=balance * weight * leg,
        twist=MAX_TWIST * weight * leg,
        heading=float(herd.headings[c]),
        start=herd.starts[c],
        wide=np.maximum(herd.footprint[c], 0.2 * leg),
        legs=LegReach(herd, own, folds[own]),
        silhouette=Outline(herd, own),
    )


def _leg_force(where: str, words: Pronk, jump: Jump, rise: float, legs: int) -> float:
    """Return the greatest force of each of so many legs [body weights]."""
    # A push takes h / rise + 1 body weights.
    pushes = (
        FORCE_RESERVE * (jump.height / rise + 1.0) * math.hypot(1.0, 0.5 * jump.forward / jump.up)
    )
    most = pushes / legs if words.max_force is None else words.max_force
    if most * legs <= 1.0:
        message = (
            f"{legs} legs of {most:g} body weights give {most * legs:.3g} together, and "
            f"it takes more than 1 to leave the ground; take "
            f"{round_up(MIN_LIFT_FORCE / legs)} or more"
        )
        raise SceneError([Problem(f"{where}.max_force", message)])
    return most


def _crouch_height(where: str, words: Pronk, low: float, stand: float) -> float:
    if words.crouch is None:
        return low + CROUCH_FRACTION * (stand - low)
    if not low <= words.crouch < stand:
        deep, high = round_up(low), round_down(MAX_CROUCH * stand)
        nearest = deep if words.crouch < low else high
        message = (
            f"from a crouch of {words.crouch:g} it cannot land or push: its body stands "
            f"{stand:.3g} above the ground and comes down to {low:.3g} at this scale; take "
            f"{nearest}, or another one from {deep} to {high}"
        )
        raise SceneError([Problem(f"{where}.crouch", message)])
    return words.crouch


def _reach_heights(lengths: Array, hips: Array, rest: Array, soles: Array) -> Array:
    """Return the heights (n,) from which legs of such lengths just reach the ground [m]."""
    across = ((rest - hips)[:, [0, 2]] ** 2).sum(axis=-1)
    result: Array = np.sqrt(np.maximum(lengths**2 - across, 0.0)) - hips[:, 1] + soles
    return result


def _lowest_height(belly: float, hips: Array, rest: Array, folds: Array, soles: Array) -> float:
    """Return the least height of a body whose belly and knees have room [m]."""
    across = ((rest - hips)[:, [0, 2]] ** 2).sum(axis=-1)
    folded = np.sqrt(np.maximum(folds**2 - across, 0.0)) - hips[:, 1] + soles
    return max(BELLY_CLEARANCE * belly, 1.03 * float(folded.max()))


def _extremes(vertices: Array) -> Array:
    """Return the points of a body farthest out in some directions (k, 3)."""
    found = np.unique((vertices @ BELLY_DIRECTIONS.T).argmax(axis=0))
    result: Array = np.asarray(vertices[found], dtype=float)
    return result


def _tensor_rows(m: NDArray[np.floating[Any]]) -> Rows:
    (a, b, c), (d, e, f), (g, h, i) = m.tolist()
    return (a, b, c), (d, e, f), (g, h, i)


MISS_DISTANCE = 2e-4
"""Distance of a foot from its foothold that is a miss [m]."""

FOLD_CHECK_RATIO, DIRECTION_CHECK_COSINE = 1.25, 0.85
"""Distance in what a leg can fold to, and cosine of the angle from where it points at rest, from
which on it is looked for."""


class LegReach:
    """The legs of one creature.

    Attributes:
        herd: that it belongs to.
        own: (n,) numbers of its legs there.
        folds: (n,) least distances from hips to feet [m].
    """

    def __init__(self, herd: Herd, own: NDArray[np.int64], folds: Array) -> None:
        self.herd, self.own, self.folds = herd, own, folds
        self._hips = herd.hips[own]
        rest = np.stack([herd.rest[own, 0], 0.0 * folds, herd.rest[own, 1]], axis=-1)
        rest[:, 1] = -herd.body_height[herd.owner[own]]
        rest -= self._hips
        self._rest = rest / np.linalg.norm(rest, axis=-1, keepdims=True)

    def misses(self, feet: Array) -> NDArray[np.bool_]:
        """Tell which legs (n,) do not come to feet (n, 3) in the frame of the body."""
        way = feet - self._hips
        far = np.sqrt((way * way).sum(axis=-1))
        odd = (way * self._rest).sum(axis=-1) < DIRECTION_CHECK_COSINE * far
        odd |= far < FOLD_CHECK_RATIO * self.folds
        odd |= far > 0.97 * self.herd.legs.lengths[self.own]
        missed = np.zeros(len(far), dtype=bool)
        rows = np.flatnonzero(odd)
        if len(rows):
            herd = self.herd
            _, gap = solve_each_near_rest(herd.legs, herd.chains, self.own[rows], feet[rows])
            missed[rows] = gap > MISS_DISTANCE
        return missed


OUTLINE_DIRECTIONS = np.array(
    [(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)]
)
"""In which points are looked for."""


LIMB_SAG = 0.12
"""How far limbs that carry nothing hang lower than at rest [rad]."""


class Outline:
    """The points of one creature.

    Attributes:
        body: (k, 3) of all that does not belong to its legs, in its frame [m].
    """

    def __init__(self, herd: Herd, own: NDArray[np.int64]) -> None:
        figure = herd.figures[int(herd.owner[own[0]])]
        self.body = _body_outline(figure)
        self._legs = herd.legs.rows(own)
        self._chains = group_chains(self._legs, np.zeros(len(own), dtype=np.int64))
        # Leg and joint that each of these points hangs on, and where they are from that.
        self._at, self._arms = _leg_outline(figure, self._legs.places)

    def legs(self, feet: Array) -> Array:
        """Return the points (m, k, 3) of legs with their tips at (m, n, 3), in its frame [m]."""
        X = solve_near_rest(self._legs, self._chains, feet).X_BJ[:, self._at[:, 0], self._at[:, 1]]
        result: Array = X[..., :3, 3] + turn(X[..., :3, :3], self._arms)
        return result


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
            _extreme_points(piece.solid.vertices),
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
            own = _extreme_points(piece.solid.vertices) - places[leg, column]
            at += [(leg, column)] * len(own)
            arms.append(own)
    return np.array(at), np.concatenate(arms)


def _extreme_points(vertices: Array) -> Array:
    result: Array = vertices[np.unique((vertices @ OUTLINE_DIRECTIONS.T).argmax(axis=0))]
    return result
