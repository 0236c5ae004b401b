"""Herd: all walking creatures as arrays, creature by creature and leg by leg.

These are the constants of walking: what a creature is and how it was asked to walk.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import Problem, SceneError
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.kinematics import LimbBatch
from pipeline.simulation.locomotion.gaits import GAITS, Gait, written
from pipeline.simulation.spatial import Array
from pipeline.spec.cast import Creature
from pipeline.spec.walk import GaitWords, Walk

REACH = 0.97
"""How far a leg may stretch, as a part of its length: beyond lies the singularity of
full extension (Sims 1987, 6.3)."""

CLEARANCE = 1.25
"""Least height of a body over level ground, as a multiple of the depth of its belly."""

EASY = 0.85
"""A stride that nobody asked for, as a part of the longest that the legs can do."""

WALKS_AT, STANDS_AT = 0.94, 0.99
"""Greatest body height that is chosen by itself, as a part of the tallest possible."""

GRAVITY = 9.81


@dataclass(frozen=True, slots=True)
class Pace:
    """How one creature walks, every parameter known.

    Attributes:
        gait: phases of its legs.
        cycle: duration of a cycle [s].
        stride: length of a cycle over the ground [m]; 0 for one that stands.
        body_height: of the hips over the ground [m].
        bounciness: amplitude of the bounce [m].
        step_height: how high feet are lifted [m].
    """

    gait: Gait
    cycle: float
    stride: float
    body_height: float
    bounciness: float
    step_height: float


@dataclass(frozen=True, eq=False)
class Herd:
    """C creatures with L legs in all.

    Attributes:
        names: of the creatures.
        figures: of the creatures.
        starts: (C, 2) x and z at the start [m].
        headings: (C,) [rad].
        cycle, stride, body_height, bounciness: (C,), see `Pace`.
        beats: (C,) times a cycle that feet come down.
        belly: (C,) how deep the bodies reach below their frames [m].
        walks: (C,) whether it goes anywhere.
        footprint: (C, 2) half extent of the feet at rest along x and z [m].
        owner: (L,) creature of each leg.
        leg_names: of the legs.
        legs: joints of the legs.
        rest: (L, 2) x and z of the feet at rest, relative to the body [m].
        up, down: (L,) phases.
        step_height, sole: (L,) lift of the foot, and radius of its tip [m].
    """

    names: tuple[str, ...]
    figures: tuple[Figure, ...]
    starts: Array
    headings: Array
    cycle: Array
    stride: Array
    body_height: Array
    bounciness: Array
    beats: Array
    belly: Array
    walks: NDArray[np.bool_]
    footprint: Array
    owner: NDArray[np.int64]
    leg_names: tuple[str, ...]
    legs: LimbBatch
    rest: Array
    up: Array
    down: Array
    step_height: Array
    sole: Array

    @cached_property
    def swings(self) -> Array:
        """(L,) parts of a cycle that the feet are in the air."""
        result: Array = np.mod(self.down - self.up, 1.0)
        return result

    @property
    def hips(self) -> Array:
        """(L, 3) bases of the legs, relative to the body [m]."""
        return self.legs.places[:, 0]


def gather(cast: Sequence[tuple[int, Creature, Figure]]) -> Herd:
    """Collect creatures into one herd.

    Args:
        cast: place in the scene's cast, words and figure of each.

    Raises:
        SceneError: if a creature cannot walk as it is asked to.
    """
    owner, limbs = list[int](), []
    for c, (_, _, figure) in enumerate(cast):
        for limb in figure.skeleton.legs:
            owner.append(c)
            limbs.append((figure.skeleton, limb))
    legs = LimbBatch.of(limbs)
    tips = legs.pose(legs.preferred).tips if limbs else np.zeros((0, 3))
    owners = np.array(owner, dtype=np.int64)
    paces = []
    for c, (number, member, figure) in enumerate(cast):
        own = owners == c
        spread = Spread(legs.places[own, 0], tips[own], legs.lengths[own])
        paces.append(_pace(number, member, figure, spread))
    spans = [
        np.abs(tips[owners == c][:, [0, 2]]).max(axis=0, initial=0.05) for c in range(len(cast))
    ]
    return Herd(
        names=tuple(member.name for _, member, _ in cast),
        figures=tuple(figure for _, _, figure in cast),
        starts=np.array([(member.at[0], member.at[-1]) for _, member, _ in cast], dtype=float),
        headings=np.radians([member.heading_deg for _, member, _ in cast]),
        cycle=np.array([p.cycle for p in paces]),
        stride=np.array([p.stride for p in paces]),
        body_height=np.array([p.body_height for p in paces]),
        bounciness=np.array([p.bounciness for p in paces]),
        beats=np.array([p.gait.beats for p in paces], dtype=float),
        belly=np.array([figure.belly for _, _, figure in cast]),
        walks=np.array([member.walk is not None for _, member, _ in cast]),
        footprint=np.array(spans),
        owner=owners,
        leg_names=tuple(limb.name for _, limb in limbs),
        legs=legs,
        rest=tips[:, [0, 2]],
        up=np.concatenate([p.gait.up for p in paces]),
        down=np.concatenate([p.gait.down for p in paces]),
        step_height=np.array([paces[c].step_height for c in owner]),
        sole=np.array([limb.tip_radius for _, limb in limbs]),
    )


@dataclass(frozen=True, eq=False)
class Spread:
    """The legs of one creature at rest.

    Attributes:
        hips, feet: (n, 3) relative to the body [m].
        lengths: (n,) stretched out [m].
    """

    hips: Array
    feet: Array
    lengths: Array

    def tallest(self) -> float:
        """Return the greatest body height from which all feet reach level ground [m]."""
        across = np.abs(self.feet[:, 2] - self.hips[:, 2])
        room = (REACH * self.lengths) ** 2 - across**2
        return float((np.sqrt(np.maximum(room, 0.0)) - self.hips[:, 1]).min())

    def longest_stride(self, gait: Gait, height: float) -> float:
        """Return the longest cycle over level ground that the legs can do from `height` [m]."""
        across = np.abs(self.feet[:, 2] - self.hips[:, 2])
        drop = height + self.hips[:, 1]
        room = (REACH * self.lengths) ** 2 - drop**2 - across**2
        # Half of the ground covered in stance lies before the foot at rest, half behind it.
        forward = np.sqrt(np.maximum(room, 0.0)) - np.abs(self.feet[:, 0] - self.hips[:, 0])
        return max(float((2.0 * forward / (1.0 - gait.swing)).min()), 0.0)


def _pace(number: int, member: Creature, figure: Figure, legs: Spread) -> Pace:
    """Choose what the author left open so that it suits the legs.

    Raises:
        SceneError: if the legs cannot follow the stride or the body height on level ground.
    """
    words = member.walk or Walk()
    if not len(legs.lengths):
        return _legless(number, member, figure)
    leg = float(legs.lengths.mean())
    gait = _gait(number, member, words, figure)
    height = max(-float(legs.feet[:, 1].mean()), CLEARANCE * figure.belly)
    # Straight legs have no room for a stride: who walks stands a little lower.
    height = min(height, (WALKS_AT if member.walk else STANDS_AT) * legs.tallest())
    height = height if words.body_height is None else words.body_height
    if height >= legs.tallest():
        message = f"the legs do not reach the ground from {height:g}; "
        message += f"at this scale less than {legs.tallest():.3g} works"
        raise SceneError([Problem(f"cast[{number}].walk.body_height", message)])
    most = legs.longest_stride(gait, height)
    # A leg swings like a pendulum; this many of its free periods look natural.
    natural = 2.6 * math.sqrt(leg / GRAVITY)
    cycle, stride = timing(words, natural, min(0.55 * leg, EASY * most))
    if member.walk and stride > most:
        message = (
            f"a stride (speed × cycle) of {stride:.3g} is more than the legs can do; at this "
            f"body height at most {most:.3g} works: lower the speed or shorten the cycle"
        )
        raise SceneError([Problem(f"cast[{number}].walk", message)])
    return Pace(
        gait,
        cycle,
        stride if member.walk else 0.0,
        height,
        0.018 * leg if words.bounciness is None else words.bounciness,
        0.13 * leg if words.step_height is None else words.step_height,
    )


def timing(words: Walk, cycle: float, stride: float) -> tuple[float, float]:
    """Return the duration [s] and the length [m] of a cycle.

    Args:
        words: what the author said of them.
        cycle: duration if nothing is said [s].
        stride: length if nothing is said [m].
    """
    if words.stride is not None:
        stride = words.stride
    elif words.speed is not None and words.cycle is not None:
        stride = words.speed * words.cycle
    if words.cycle is not None:
        cycle = words.cycle
    elif words.speed is not None:
        cycle = stride / words.speed
    return cycle, stride


def _legless(number: int, member: Creature, figure: Figure) -> Pace:
    if member.walk is not None:
        message = f"figure '{member.figure}' has no legs to walk on; take `walk` away"
        raise SceneError([Problem(f"cast[{number}].walk", message)])
    lying = figure.skeleton.links[0].radii[0]
    return Pace(Gait(np.zeros(0), np.zeros(0)), 1.0, 0.0, lying, 0.0, 0.0)


def _gait(number: int, member: Creature, words: Walk, figure: Figure) -> Gait:
    legs = figure.skeleton.legs
    names = [leg.name for leg in legs]
    if isinstance(words.gait, GaitWords):
        wrong = sorted(set(words.gait.up) ^ set(names))
        if wrong:
            message = (
                f"has to name every leg of '{member.figure}' and no other: "
                f"its legs are {', '.join(names)}; at fault: {', '.join(wrong)}"
            )
            raise SceneError([Problem(f"cast[{number}].walk.gait.up", message)])
        return written(words.gait, names)
    if words.gait == "tripod" and len(names) != 6:
        message = f"a tripod gait needs 6 legs, '{member.figure}' has {len(names)}; take trot"
        raise SceneError([Problem(f"cast[{number}].walk.gait", message)])
    sides = [leg.side for leg in legs]
    ranks = [sides[:i].count(side) for i, side in enumerate(sides)]
    return GAITS[words.gait](sides, ranks)
