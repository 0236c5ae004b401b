"""Limb avoidance: heads, tails, feelers and arms that nobody poses keep out of ground and props.

Where a link would come too near, the joints give way by the least movement that clears it: the
velocity of the nearest points away from the obstacle, taken back through their own Jacobians. It
begins before the links touch and grows smoothly, and each row is worked out by itself.

Source: Sims 1987, B.2.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.cleared_ways import samples_of
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.kinematics import LimbBatch
from pipeline.simulation.figures.limb_goals import Clearance, LimbGoals, begins_at, pursue
from pipeline.simulation.figures.network import LEG
from pipeline.simulation.figures.skeleton import BODY
from pipeline.simulation.figures.surroundings import LimbSamples, Surroundings
from pipeline.simulation.locomotion.body_motion.damped_springs import Oscillators, SpringFollower
from pipeline.simulation.locomotion.body_motion.idle_motion import FreeJoints
from pipeline.simulation.spatial import Array, turn

KEEP = 0.01
"""Gap that free limbs keep, in their lengths."""

STEPS = 6
"""Steps of the joints; in all rows as many, so that what they do is continuous."""

RESTRAINT = 0.2
"""Damping of the steps: what points at an obstacle cannot be turned out of its way by much."""

FREQUENCY, DAMPING = 10.0, 0.9
"""Frequency [rad/s] and damping ratio with which joints give way."""

LEAD = 0.2
"""How long before a body is there its limbs give way [s]."""

STEEPEST = 1.5
"""Greatest height above the ground per gap: between upward and a level normal, 1 / cos 45°."""


@dataclass(frozen=True, eq=False)
class _FreeLimb:
    """A limb with what is needed to lead it away.

    Attributes:
        creature: number.
        name: of the limb.
        joints: its numbers among the free joints.
        above: free joint that it hangs on; `BODY` for the body.
        hung: (3,) where that joint was drawn [m].
        batch: the limb alone.
        samples: points that keep clear.
    """

    creature: int
    name: str
    joints: NDArray[np.int64]
    above: int
    hung: Array
    batch: LimbBatch
    samples: LimbSamples


@dataclass(frozen=True, eq=False)
class _AllSamples:
    """Points of all limbs of a herd that keep clear, limb by limb.

    Attributes:
        limbs, joints: (P,) numbers of the limb and the free joint of each.
        offsets: (P, 3) from where that joint was drawn [m].
        begins: (P,) gaps from which on they give way [m].
    """

    limbs: NDArray[np.int64]
    joints: NDArray[np.int64]
    offsets: Array
    begins: Array


class LimbAvoidance:
    """Leads a herd's free limbs out of obstacles."""

    def __init__(
        self,
        figures: list[Figure],
        free_joints: FreeJoints,
        surroundings: Surroundings,
        body_height: Array,
        dt: float,
    ) -> None:
        self.joints, self.surroundings = free_joints, surroundings
        limbs = list(_free_limbs(figures, free_joints, body_height))
        # What hangs on another limb comes after it.
        self._limbs = sorted(limbs, key=lambda limb: limb.above != BODY)
        count = len(free_joints.owner)
        springs = Oscillators(np.full(count, FREQUENCY), np.full(count, DAMPING), dt)
        self._springs = SpringFollower(springs)
        # How far a point of a link may be from the joint that moves it, and be on it.
        self._spans = np.zeros(count)
        for limb in self._limbs:
            corners = np.concatenate([limb.batch.places[0], limb.batch.tips])
            longest = float(np.linalg.norm(np.diff(corners, axis=0), axis=-1).max())
            keep = 2.0 * KEEP * float(limb.batch.lengths[0])
            self._spans[limb.joints] = longest + keep + float(limb.samples.radii.max())

    def apply(self, times: Array, q: Array, R_WB: Array, p_WB: Array, v_WB: Array) -> Array:
        """Return joint values that keep clear.

        Args:
            times: (n,) [s].
            q: (n, M) of the free joints [rad or m].
            R_WB: (n, C, 3, 3) and
            p_WB: (n, C, 3), poses of the bodies [m].
            v_WB: (n, C, 3) their velocities [m/s].
        """
        # Edges of the ground come all at once; joints give way as on springs.
        moved = self._cleared(times, q, R_WB, p_WB, LEAD * v_WB) - q
        moved += self._springs.follow(moved)
        limits = self.joints.limits
        return np.clip(q + moved, np.minimum(limits.lower, q), np.maximum(limits.upper, q))

    def _cleared(self, times: Array, q: Array, R_WB: Array, p_WB: Array, ahead: Array) -> Array:
        """Return joint values (n, M) that keep clear at once."""
        if self.surroundings.is_empty or not self._limbs:
            return q
        X = self.joints.tree.pose(q)
        near = self._near(times, X, (R_WB, p_WB), ahead)
        if not near.any():
            return q
        result = q.copy()
        for i in np.flatnonzero(near.any(axis=0)):
            limb = self._limbs[i]
            R, p = R_WB[:, limb.creature], p_WB[:, limb.creature]
            if limb.above != BODY:
                R_BP = X[:, limb.above, :3, :3]
                p = p + turn(R, X[:, limb.above, :3, 3] - turn(R_BP, limb.hung))
                R = R @ R_BP
            base, reach = p + turn(R, limb.batch.places[0, 0]), float(limb.batch.lengths[0])
            around = self.surroundings
            if around.solids:
                around = around.near(times, base, (1.0 + 2.0 * KEEP) * reach)
                if around.is_empty:
                    continue
            clearance = Clearance(around, limb.samples, times, R, p, KEEP, ahead[:, limb.creature])
            own = result[:, limb.joints]
            gap = clearance.least_gap(limb.batch.pose(own), limb.batch)
            rows = np.flatnonzero(near[:, i] & (gap < begins_at(KEEP, limb.batch)))
            if not len(rows):
                continue
            none = np.zeros((len(rows), 0))
            goals = LimbGoals((), (), (), none, own[rows], clearance=clearance.rows(rows))
            pose = pursue(limb.batch, own[rows], goals, STEPS, STEPS, RESTRAINT)
            result[rows[:, None], limb.joints] = pose.q
            X = self.joints.tree.pose(result)
        return result

    def _near(
        self, times: Array, X: Array, bodies: tuple[Array, Array], ahead: Array
    ) -> NDArray[np.bool_]:
        """Return when limbs (n, l) may come near an obstacle.

        Args:
            times: (n,) [s].
            X: (n, M, 4, 4) frames of the joints, relative to the bodies.
            bodies: orientations (n, C, 3, 3) and places (n, C, 3) [m].
            ahead: (n, C, 3) displacements by which limbs keep clear, too [m].
        """
        (R_WB, p_WB), own, around = bodies, self.joints.owner, self.surroundings
        joints = p_WB[:, own] + turn(R_WB[:, own], X[..., :3, 3])
        result = np.zeros((len(times), len(self._limbs)), dtype=bool)
        if around.solids:
            solids = replace(around, ground=None)
            near = solids.within(times, joints, self._spans)
            result |= np.stack([near[:, limb.joints].any(axis=1) for limb in self._limbs], axis=-1)
        if around.ground is None:
            return result
        ground = replace(around, solids=())
        low_joints = np.asarray(ground.within(times, joints, self._spans).any(axis=0))
        of_samples = self._samples
        points = np.flatnonzero(low_joints[of_samples.joints])
        if not len(points):
            return result
        at = of_samples.joints[points]
        frames = X[:, at]
        in_body = frames[..., :3, 3] + turn(frames[..., :3, :3], of_samples.offsets[points])
        here = p_WB[:, own[at]] + turn(R_WB[:, own[at]], in_body)
        begins = STEEPEST * of_samples.begins[points]
        low = np.zeros((len(times), len(points)), dtype=bool)
        for there in (here, here + ahead[:, own[at]]):
            low |= there[..., 1] - around.ground.height(there[..., 0], there[..., 2]) < begins
        limbs, first = np.unique(of_samples.limbs[points], return_index=True)
        result[:, limbs] |= np.logical_or.reduceat(low, first, axis=1)
        return result

    @cached_property
    def _samples(self) -> _AllSamples:
        """The points of all limbs that keep clear."""
        joints, offsets = [limb.joints[limb.samples.columns] for limb in self._limbs], []
        for limb, own in zip(self._limbs, joints, strict=True):
            offsets.append(limb.samples.places - self.joints.tree.places[own])
        counts = [len(own) for own in joints]
        begins = [begins_at(KEEP, limb.batch) + limb.samples.radii for limb in self._limbs]
        return _AllSamples(
            np.repeat(np.arange(len(self._limbs)), counts),
            np.concatenate(joints),
            np.concatenate(offsets),
            np.concatenate(begins),
        )


def _free_limbs(
    figures: list[Figure], joints: FreeJoints, body_height: Array
) -> Iterator[_FreeLimb]:
    free, at_rest = iter(joints.limbs), joints.tree.pose(joints.limits.preferred)
    for c, figure in enumerate(figures):
        skeleton = figure.skeleton
        for limb in (limb for limb in skeleton.limbs if limb.kind != LEG):
            own = np.array(list(next(free).joints), dtype=np.int64)
            above = int(joints.tree.parents[own[0]])
            hung = joints.tree.places[above] if above != BODY else np.zeros(3)
            batch = LimbBatch.of([(skeleton, limb)])
            samples = samples_of(figure, limb, ())
            # What lies or hangs close to the ground is not lifted off it: its line alone keeps out.
            at = own[samples.columns]
            offsets = samples.places - joints.tree.places[at]
            rest = at_rest[at, :3, 3] + turn(at_rest[at, :3, :3], offsets)
            gap = body_height[c] + rest[:, 1] - begins_at(KEEP, batch)
            samples = replace(samples, radii=np.where(gap > 2 * samples.radii, samples.radii, 0.0))
            yield _FreeLimb(c, limb.name, own, above, hung, batch, samples)
