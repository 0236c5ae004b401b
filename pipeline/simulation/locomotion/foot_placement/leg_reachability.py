"""Leg reachability: the tip positions that the joints of each leg can hold.

A leg reaches less than its length allows: knees fold and hips turn only so far. Inverse kinematics
decides, but runs only for positions outside the box that each leg covers on level ground.
"""

from __future__ import annotations

import itertools
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.ball_aim import ball_joints
from pipeline.simulation.figures.kinematics import LimbBatch
from pipeline.simulation.figures.limb_chains import group_chains
from pipeline.simulation.figures.tip_ik import solve_each_tip, solve_tips
from pipeline.simulation.locomotion.foot_placement.support_surface import SupportSurface
from pipeline.simulation.locomotion.gaits.stride_limits import MAX_REACH, PLANNED_REACH
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.swing.swing_trajectory import quickness
from pipeline.simulation.spatial import Array, turn

# Distance between tip and goal that counts as reached, as a fraction of the leg's length.
REACHED_DISTANCE = 1e-4

# Greatest change of a joint between two samples of a swing [rad]: of a dozen samples, in which no
# joint turns by more than half a turn to and fro.
MAX_JOINT_STEP = 0.8

# Margin around the level-ground tip positions within which every goal is reached, as fractions of
# the leg's length: along, up and across. Downwards the leg's length is the only bound.
NEUTRAL_MARGIN = np.array([0.12, 0.12, 0.1])

# Least height of a hip above its foot, as a fraction of that on level ground. Sprawling legs reach
# above their hips as well.
MIN_HIP_HEIGHT = {"insect": -0.5, "mammal": 0.4}

# Height of a swing that a leg lifts its foot to without a check, in step heights.
EASY_SWING_HEIGHT = 1.5

# Room that a hip keeps to its limits [rad]. One at its limit leaves the rest of the way to knee and
# ankle, which would turn in a blink.
HIP_ROOM = 0.05

# Joints of a hip, the first ones of a leg.
BALL = 3

# Heights of places on level ground and around it that a leg must reach with its hip free, in
# `NEUTRAL_MARGIN`.
BOX_HEIGHTS = -1.0, 0.0, 1.0

# Hip-to-foot distances at which folding is tested, as fractions of the leg's length.
FOLD_DISTANCES = np.linspace(MAX_REACH, 0.1, 30)


class LegReachability:
    """Tests which tip positions the legs of a herd reach; goals are relative to the body."""

    def __init__(self, herd: Herd, surface: SupportSurface) -> None:
        self.herd, self.surface = herd, surface
        self._squared_reach = np.array([r**2 for r in PLANNED_REACH * herd.legs.lengths])
        self._can_lift = dict[tuple[int, float], bool]()
        # Quick feet are on their way at once, slow ones still near their places while bodies go on.
        lag = 0.5 * (1.0 - quickness(herd.swings)) * herd.swings
        half = 0.5 * herd.stride[herd.owner] * (1.0 - herd.swings + lag)
        x, z = herd.rest.T
        margin = NEUTRAL_MARGIN * herd.legs.lengths[:, None]
        floor = herd.foot_radius - herd.body_height[herd.owner]
        self._low = np.stack([x - half, floor - herd.legs.lengths, z], axis=-1) - margin
        self._high = np.stack([x + half, floor, z], axis=-1) + margin
        self._boxed = self._box_is_free(floor, margin[:, 1])

    def _box_is_free(self, floor: Array, margin: Array) -> NDArray[np.bool_]:
        """Return which legs (L,) have their hips free all around their level-ground places."""
        herd, result = self.herd, np.ones(len(self.herd.owner), dtype=bool)
        legs = np.arange(len(result))
        if not len(legs):
            return result
        for x, y, z in itertools.product((0, 1), BOX_HEIGHTS, (0, 1)):
            ends = (self._low, self._high)
            goals = np.stack([ends[x][:, 0], floor + y * margin, ends[z][:, 2]], axis=-1)
            near = np.linalg.norm(goals - herd.hips, axis=-1) < MAX_REACH * herd.legs.lengths
            q, _ = solve_each_tip(herd.legs, herd.chains, legs, goals)
            result &= ~near | free_hips(herd.legs, legs, q)
        return result

    def near_neutral(self, legs: NDArray[np.int64], goals: Array) -> NDArray[np.bool_]:
        """Return which goals (N, 3) lie near the tip positions of legs (N,) on level ground."""
        inside: NDArray[np.bool_] = (goals >= self._low[legs]) & (goals <= self._high[legs])
        return np.asarray(inside.all(axis=-1) & self._boxed[legs])

    def reaches(self, legs: NDArray[np.int64], goals: Array) -> NDArray[np.bool_]:
        """Return which goals (N, m, 3) the legs (N,) reach with their hips free."""
        reached = self.near_neutral(legs[:, None], goals)
        row, sample = np.nonzero(~reached)
        if len(row):
            herd, asked = self.herd, legs[row]
            q, residual = solve_each_tip(herd.legs, herd.chains, asked, goals[row, sample])
            there = residual <= REACHED_DISTANCE * herd.legs.lengths[asked]
            reached[row, sample] = there & free_hips(herd.legs, asked, q)
        return reached

    def follows(self, legs: NDArray[np.int64], paths: Array) -> NDArray[np.bool_]:
        """Return which legs (N,) can move their tips along `paths` (N, m, 3).

        At its limits a leg may reach neighbouring goals by different branches of the inverse
        kinematics; so hips stay free, and no joint may jump between samples.
        """
        missed, free, turned = self._along(legs, paths)
        reached = (missed <= REACHED_DISTANCE) & free
        return np.asarray(reached.all(axis=1) & (turned < MAX_JOINT_STEP).all(axis=1))

    def swing_faults(self, legs: NDArray[np.int64], paths: Array) -> Array:
        """Return how badly legs (N,) follow `paths` (N, m, 3), 0 where they can; see `follows`."""
        missed, free, turned = self._along(legs, paths)
        beyond = np.maximum(missed - REACHED_DISTANCE, 0.0).max(axis=1)
        jumps = np.maximum(turned - MAX_JOINT_STEP, 0.0).max(axis=1)
        # A miss weighs most, then a jump, then a hip at its limit.
        result: Array = 10.0 * beyond + jumps + 0.1 * (~free).mean(axis=1)
        return result

    def _along(
        self, legs: NDArray[np.int64], paths: Array
    ) -> tuple[Array, NDArray[np.bool_], Array]:
        """Return how legs (N,) follow paths (N, m, 3).

        Returns:
            Distances from the paths (N, m) in leg lengths, which hips are free (N, m), and the
            greatest turns of joints between samples (N, m - 1) [rad].
        """
        herd, shape = self.herd, paths.shape[:2]
        rows = np.repeat(legs, shape[1])
        q, residual = solve_each_tip(herd.legs, herd.chains, rows, paths.reshape(-1, 3))
        missed = (residual / herd.legs.lengths[rows]).reshape(shape)
        free = free_hips(herd.legs, rows, q).reshape(shape)
        turned = np.abs(np.diff(q.reshape(*shape, -1), axis=1)).max(axis=-1)
        return missed, free, turned

    def within_reach(self, legs: NDArray[np.int64], paths: Array) -> Array:
        """Return paths (N, m, 3) with what is beyond the reach of legs (N,) drawn in.

        Feet of running legs trail behind as far as the legs let them.
        """
        hips = self.herd.hips[legs, None]
        far = np.linalg.norm(paths - hips, axis=-1)
        reach = PLANNED_REACH * self.herd.legs.lengths[legs, None]
        return hips + np.minimum(reach / np.maximum(far, 1e-9), 1.0)[..., None] * (paths - hips)

    def required_lowering(self, legs: NDArray[np.int64], tips: Array, R: Array, p: Array) -> Array:
        """Return how far bodies must be lowered (N, k) [m] for legs to reach `tips` (N, k, 3).

        By leg length alone. Zero where they reach anyway, infinite where lowering does not help.

        Args:
            legs: (N,) numbers.
            tips: (N, k, 3) [m].
            R: (N, m, 3, 3) and
            p: (N, m, 3), poses of the bodies during the stance [m].
        """
        hips = p + turn(R, self.herd.hips[legs, None])
        x, y, z = np.moveaxis(tips[:, :, None] - hips[:, None], -1, 0)
        room = self._squared_reach[legs, None, None] - x**2 - z**2
        drop = np.sqrt(np.maximum(room, 0.0))
        lowering = np.maximum(-y - drop, 0.0).max(axis=-1)
        highest = np.minimum(drop, self._highest_tips[legs, None, None])
        out_of_reach = (room < 0.0) | (y + lowering[..., None] > highest)
        return np.where(out_of_reach.any(axis=-1), np.inf, lowering)

    @cached_property
    def _highest_tips(self) -> Array:
        """(L,) greatest height of a tip above its hip [m]."""
        herd, owner, surface = self.herd, self.herd.owner, self.surface
        fraction = np.array([MIN_HIP_HEIGHT[figure.style] for figure in herd.figures])[owner]
        tall = herd.body_height[owner] + herd.hips[:, 1] - herd.foot_radius
        # On level ground bodies that crouch or bounce are as low as they were asked to be.
        level = np.array([surface.of(c).is_level for c in range(len(herd.names))])[owner]
        return np.where(level, np.inf, -fraction * tall)

    @cached_property
    def can_lift_usual(self) -> NDArray[np.bool_]:
        """(L,) whether each leg can lift its foot to its usual step height."""
        return self._lifts(np.arange(len(self.herd.owner)), self.herd.step_height)

    def can_lift(self, leg: int, height: float) -> bool:
        """Return whether a leg can lift its foot to a step height [m]."""
        key = leg, height
        if key not in self._can_lift:
            self._can_lift[key] = bool(self._lifts(np.array([leg]), np.array([height]))[0])
        return self._can_lift[key]

    def _lifts(self, legs: NDArray[np.int64], height: Array) -> NDArray[np.bool_]:
        herd, owner = self.herd, self.herd.owner[legs]
        x, z = herd.rest[legs].T
        top = herd.foot_radius[legs] - herd.body_height[owner] + EASY_SWING_HEIGHT * height
        ahead = np.minimum(0.25, 0.5 * (1.0 - herd.swings[legs])) * herd.stride[owner]
        goals = [np.stack([x + k * ahead, top, z], axis=-1) for k in (-1.0, 0.0, 1.0)]
        return np.asarray(self.reaches(legs, np.stack(goals, axis=1)).all(axis=-1))


def free_hips(batch: LimbBatch, rows: NDArray[np.int64], q: Array) -> NDArray[np.bool_]:
    """Return which hips (...) are away from their limits; all of those that are no ball joints.

    Then a leg goes along its bends alone, and follows its foot as calmly as two equal links.

    Args:
        batch: legs.
        rows: (...) their numbers.
        q: (..., n) joint values [rad or m].
    """
    lower, upper, rest = (
        bound[rows, :BALL] for bound in (batch.lower, batch.upper, batch.preferred)
    )
    # An author may let a joint rest at its limit, or hold it.
    below = (q[..., :BALL] - lower < HIP_ROOM) & (rest - lower > HIP_ROOM)
    above = (upper - q[..., :BALL] < HIP_ROOM) & (upper - rest > HIP_ROOM)
    result: NDArray[np.bool_] = ~(below | above).any(axis=-1) | ~ball_joints(batch)[rows]
    return result


def shortest_reaches(herd: Herd) -> Array:
    """Return the hip-to-foot distances (L,) [m] beyond which each leg reaches every foot position.

    Tested on the line from the hip to the foot's neutral position.
    """
    result, known = np.zeros(len(herd.owner)), dict[tuple[str, float, float], Array]()
    for c, figure in enumerate(herd.figures):
        own = np.flatnonzero(herd.owner == c)
        key = figure.name, figure.scale, float(herd.body_height[c])
        if len(own):
            result[own] = known[key] = known[key] if key in known else _fold_limits(herd, own)
    return result


def _fold_limits(herd: Herd, own: NDArray[np.int64]) -> Array:
    legs, (x, z) = herd.legs.rows(own), herd.rest[own].T
    direction = np.stack([x, -herd.body_height[herd.owner[own]], z], axis=-1) - herd.hips[own]
    at_rest = np.linalg.norm(direction, axis=-1)
    direction /= np.maximum(at_rest, 1e-9)[:, None]
    goals = herd.hips[own] + (FOLD_DISTANCES[:, None] * legs.lengths)[..., None] * direction
    chains = group_chains(legs, herd.owner[own])
    solution = solve_tips(legs, chains, goals)
    residual = solution.residual
    # The neutral position is reached by definition, whatever limits stretched legs meet.
    asked = FOLD_DISTANCES[:, None] * legs.lengths
    folded = np.zeros(len(own))
    for chain in chains:
        folded[chain.rows] = chain.path.shortest[chain.on_path[:, 0]]
    near = asked < folded
    held = ~free_hips(legs, np.arange(len(own)), solution.q)
    missed = (asked < at_rest) & ((residual > REACHED_DISTANCE * legs.lengths) | near | held)
    # The last distance before the first miss; legs without a miss fold up completely.
    first = np.where(missed.any(axis=0), missed.argmax(axis=0), len(FOLD_DISTANCES))
    result = FOLD_DISTANCES[np.maximum(first - 1, 0)] * legs.lengths
    # Between two of them lies the end of the bends, unless limits are met before.
    at_end = near & ~np.roll(near, 1, axis=0)
    at_end[0] = False
    ends = np.where(at_end.any(axis=0), at_end.argmax(axis=0), -1)
    return np.where(ends == first, np.minimum(folded, result), result)
