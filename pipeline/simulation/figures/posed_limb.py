"""Posed limbs: joint values of one limb, as a function of time and of where its figure is.

The pose of every key is found first, from any other if need be, so that a limb does not stick in
the branch that led away from its goal. Between keys the joint values go from pose to pose, and all
rows at once are led from there to the goals of their own times. No row starts from the row before
it: what a limb does follows from the time and the place of its figure alone.

The poses of keys in the frames of feet or world change with the place of the body. They are looked
up anew in regular intervals, and the change comes in smoothly over the next one.

Source: Sims 1987, 3.2.2, 6.2 and B.3.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.curves import ease
from pipeline.simulation.figures.cleared_ways import WayClearer, samples_of
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.figure_frames import (
    FigureFrames,
    Foresight,
    LimbParent,
    point_targets,
)
from pipeline.simulation.figures.goal_miss import FULL_WEIGHT, GoalMiss, MissWatch
from pipeline.simulation.figures.key_pose import KEY_STEPS, KEY_TOLERANCE, KeyPoseSearch
from pipeline.simulation.figures.kinematics import LimbBatch, LimbPose
from pipeline.simulation.figures.limb_goals import CLEARANCE, Clearance, LimbGoals, pursue
from pipeline.simulation.figures.pose_knots import CHECKED, Knot, find_knots, weights_of
from pipeline.simulation.figures.pose_plan import PosePlan
from pipeline.simulation.figures.skeleton import BODY
from pipeline.simulation.figures.surroundings import Surroundings
from pipeline.simulation.keyframe_track import SAME_TIME, Key, Track
from pipeline.simulation.spatial import Array, turn

MAX_JOINT_RATE = 14.0
"""Greatest rate of a joint [rad/s or m/s]."""

ROW_STEPS = 10
"""Bound on the steps to the pose of a row."""

LONG_WAY = 0.15
"""Error of a row's start, in lengths of the limb or radians, from which joints are led away from
their limits."""

JUMP_RATIO, JUMP_ANGLE, CALM = 1.5, 0.35, 0.6
"""Joints jump that go farther between checks than this ratio of the direct way, unless it is no
more than this angle [rad] farther and at no more than this fraction of their greatest rate."""

DETOUR_END = 0.25
"""Fraction of a detour's time at each of its ends in which the goals are joined again."""

RENEWAL = 0.25
"""Interval in which the poses of keys follow the place of the body [s]."""

MOVED_TARGET = 0.02
"""Movement of a target relative to the limb that needs a new pose, in lengths of the limb or
radians."""


class PosedLimb:
    """One posed limb of a figure."""

    def __init__(
        self,
        figure: Figure,
        number: int,
        plan: PosePlan,
        rng: np.random.Generator,
        surroundings: Surroundings,
    ) -> None:
        skeleton = figure.skeleton
        self.figure = figure
        self.limb = skeleton.limbs[number]
        self.batch = LimbBatch.of([(skeleton, self.limb)])
        self.above = int(skeleton.parents[self.limb.joints[0]])
        self.points = [run for run in plan.points if run.limb == number]
        self.joints = [run for run in plan.joints if run.limb == number]
        runs = [*self.points, *self.joints]
        self.dexterity = max(run.dexterity for run in runs)
        self.surroundings = surroundings
        if all(run.avoid is not None for run in runs):
            self.surroundings = surroundings.only({n for run in runs for n in run.avoid or ()})
        self._samples = samples_of(figure, self.limb, self.points)
        self._search = KeyPoseSearch(self.batch, rng)
        self._body = plan.body
        self._knots = list[Knot]()
        self._renewed = -math.inf
        self._last: Array | None = None
        self._lags = False
        self._watch = MissWatch(self.limb.name, self.batch, (*self.points, *self.joints))

    def weights(self, times: Array) -> Array:
        """Return the weights (n, m) of each point, then of each joint."""
        return weights_of((*self.points, *self.joints), times)

    def weight(self, times: Array) -> Array:
        """Return the weight (n,) of the demands against the limb's own motion."""
        return self.weights(times).max(axis=-1)

    def follow(
        self, q: Array, frames: FigureFrames, parent: LimbParent, foresight: Foresight
    ) -> tuple[Array, list[GoalMiss]]:
        """Return posed joint values (n, k), and misses.

        Args:
            q: (n, k) the limb's own values [rad or m].
            frames: of the figure.
            parent: of the limb.
            foresight: of the frames.
        """
        weights = self.weights(frames.times)
        goals = self._goals(frames, parent, q)
        result, count = q.copy(), len(self.points)
        for i, run in enumerate(self.joints):
            own = result[:, run.column]
            result[:, run.column] = own + weights[:, count + i] * (goals.values[:, i] - own)
        most = weights[:, :count].max(axis=-1, initial=0.0)
        if most.any():
            shares = weights.copy()
            shares[:, :count] /= np.where(most > 0.0, most, 1.0)[:, None]
            if not self._knots:
                first = int(np.flatnonzero(most)[0])
                clearer = WayClearer(self.figure, self.limb, self.batch, self.surroundings)
                self.points = clearer.cleared(self.points, first, parent, foresight)
                size = float(self.batch.lengths[0])
                self._knots = list(find_knots(self.points, self.joints, self._body, size))
                goals = self._goals(frames, parent, q)
            seeds = self._seeds(result, frames, parent, foresight, most > 0.0)
            kept, adherence = self._detours(frames.times)
            asked = goals
            if (kept != frames.times).any():
                shares[:, :count] *= adherence[:, None]
                asked = self._goals(replace(frames, times=kept), parent, q)
                asked = replace(asked, values=goals.values)
            found = self._rows(asked, shares, seeds, np.flatnonzero(most > 0.0))
            result += most[:, None] * (found - result)
        q = self._limited(result, most > 0.0, frames.dt)
        return q, list(self._watch.misses(goals, q, result, weights, frames, parent))

    def _goals(self, frames: FigureFrames, parent: LimbParent, pull: Array) -> LimbGoals:
        times = frames.times
        values = [run.run.track(times)[:, 0] for run in self.joints]
        return LimbGoals(
            self.points,
            self.joints,
            [point_targets(run, frames, parent) for run in self.points],
            np.stack(values, axis=-1) if values else np.zeros((len(times), 0)),
            pull,
            self.dexterity,
            self._clearance(frames, parent),
        )

    def _clearance(self, frames: FigureFrames, parent: LimbParent) -> Clearance | None:
        R_WP = frames.R_WB @ parent.R_BP
        p_WP = frames.p_WB + turn(frames.R_WB, parent.p_BP)
        base = p_WP + turn(R_WP, self.batch.places[0, 0])
        reach = float(self.batch.lengths[0])
        near = self.surroundings.near(frames.times, base, reach * (1.0 + 2.0 * CLEARANCE))
        if near.is_empty:
            return None
        return Clearance(near, self._samples, frames.times, R_WP, p_WP)

    # --- rows -----------------------------------------------------------------------

    def _rows(
        self, goals: LimbGoals, shares: Array, seeds: Array, rows: NDArray[np.int64]
    ) -> Array:
        """Return joint values (n, k) that meet goals with `shares` (n, m), from those of knots."""
        result = seeds.copy()
        kinds = (shares[rows] > 0.0).astype(int) + (shares[rows] > FULL_WEIGHT)
        for kind in np.unique(kinds, axis=0):
            chosen = rows[(kinds == kind).all(axis=1)]
            start = seeds[chosen]
            # The poses of knots keep clear of obstacles; what lies between follows them.
            there = replace(goals.rows(chosen), clearance=None, dexterity=0.0)
            pose = self.batch.pose(start)
            there = replace(there, pull=self._unfolded(there, pose))
            if (kind == 2).any():
                whole = there.only((kind == 2).tolist())
                pose = pursue(self.batch, start, whole, ROW_STEPS)
            if (kind == 1).any():
                # Goals that are still taking over ask for a fraction of their way.
                partial = there.partly(shares[chosen], self.batch, pose)
                part = partial.only((kind > 0).tolist())
                pose = pursue(self.batch, pose.q, part, ROW_STEPS)
            result[chosen] = pose.q
        return result

    def _unfolded(self, goals: LimbGoals, start: LimbPose) -> Array:
        """Return what redundancy leads to (n, k): the start, far from goals the middle of limits.

        A straight limb does not bend towards its own base otherwise.
        """
        middle = 0.5 * (self.batch.lower + self.batch.upper)
        far = np.clip(self._search.cost(goals, start) / LONG_WAY - 1.0, 0.0, 1.0)
        result: Array = start.q + 0.5 * ease(far)[:, None] * (middle - start.q)
        return result

    def _limited(self, q: Array, is_active: NDArray[np.bool_], dt: float) -> Array:
        """Return joint values (n, k), none faster than joints can be.

        A limb that lags catches up, even after its release.
        """
        most = MAX_JOINT_RATE * dt
        before = q[0] if self._last is None else self._last
        steps = np.abs(np.diff(q, axis=0, prepend=before[None])).max(axis=1, initial=0.0)
        if (steps > most).any():
            q = q.copy()
            for row in range(len(q)):
                step = q[row] - before
                fastest = float(np.abs(step).max())
                if is_active[row] or self._lags:
                    self._lags = fastest > most
                    if self._lags:
                        q[row] = before + step * (most / fastest)
                before = q[row]
        self._last = q[-1].copy()
        return q

    # --- knots ----------------------------------------------------------------------

    def _seeds(
        self,
        own: Array,
        frames: FigureFrames,
        parent: LimbParent,
        foresight: Foresight,
        is_active: NDArray[np.bool_],
    ) -> Array:
        """Return joint values (n, k) on the way from knot to knot; `own` (n, k) elsewhere."""
        result, times = own.copy(), frames.times
        # By the clock, so that rows do not depend on how many are worked out together.
        periods = np.floor(times / RENEWAL + SAME_TIME)
        for period in np.unique(periods[is_active]):
            rows = np.flatnonzero((periods == period) & is_active)
            near = self._near_knots(period * RENEWAL)
            if period != self._renewed:
                self._renew(near, int(rows[0]), own, parent, foresight)
                self._renewed = period
            near = self._complete(near, int(rows[0]), own, parent, foresight)
            part = (times[rows] / RENEWAL - period)[:, None]
            before, after = (
                self._way(near, [getattr(knot, name) for knot in near], times[rows])
                for name in ("before", "after")
            )
            result[rows] = before + part * (after - before)
        return result

    def _near_knots(self, start: float) -> list[Knot]:
        """Return the knots that rows of a period need, and one more on each side for a spline.

        They are those of whole ways from key to key.
        """
        knots, times = self._knots, [knot.time for knot in self._knots]
        first = max(int(np.searchsorted(times, start, side="right")) - 2, 0)
        last = min(int(np.searchsorted(times, start + RENEWAL, side="right")) + 1, len(knots) - 1)
        while knots[first].is_between:
            first -= 1
        while knots[last].is_between:
            last += 1
        return knots[first : last + 1]

    def _way(self, knots: list[Knot], poses: list[Array | None], times: Array) -> Array:
        """Return joint values (n, k) on the way through the poses of knots."""
        keys = list[Key]()
        for i, knot in enumerate(knots):
            pose, way = poses[i], knot.ease
            if pose is None:
                # Nothing is asked of the limb here: it holds the pose that it leaves or awaits.
                sides = [p for p in (*poses[max(i - 1, 0) : i], *poses[i + 1 : i + 2])]
                pose, way = next((p for p in sides if p is not None), None), "in-out"
            if pose is not None:
                keys.append((knot.time, pose.tolist(), way))
        return np.clip(Track.of(keys)(times), self.batch.lower, self.batch.upper)

    def _renew(
        self, knots: list[Knot], row: int, own: Array, parent: LimbParent, foresight: Foresight
    ) -> None:
        """Let the poses of knots follow what has become of their targets."""
        for knot in knots:
            knot.before = knot.after
        if self.above == BODY and all(run.frame == "body" for run in self.points):
            return
        for knot, goals in self._goals_of(knots, row, own, parent, foresight):
            if knot.after is None or knot.targets is None:
                continue
            if self._has_moved(knot.targets, goals):
                found = pursue(self.batch, knot.after[None], goals, ROW_STEPS)
                if knot.is_between or self._search.cost(goals, found)[0] < KEY_TOLERANCE:
                    knot.after = found.q[0]
                else:
                    knot.after = self._search.pose_of(goals, own[row], knot.after)
                knot.targets = goals

    def _complete(
        self, knots: list[Knot], row: int, own: Array, parent: LimbParent, foresight: Foresight
    ) -> list[Knot]:
        """Find the poses of knots that have none; return the knots that are left."""
        if all(knot.after is not None or not any(knot.taken) for knot in knots):
            return knots
        way = list[tuple[Knot, LimbGoals]]()
        for knot, goals in list(self._goals_of(knots, row, own, parent, foresight)):
            way.append((knot, goals))
            if knot.is_between:
                continue
            if knot.after is None and any(knot.taken) and not self._track(way):
                first, inner = way[0][0], [there for there, _ in way[1:-1]]
                knots = [k for k in knots if k not in inner]
                self._knots = [k for k in self._knots if k not in inner]
                start = own[row] if first.after is None else first.after
                knot.before = knot.after = self._search.pose_of(goals, own[row], start)
                left = self._search.cost(goals, self.batch.pose(knot.after[None]))[0]
                knot.is_met = bool(left < KEY_TOLERANCE)
                knot.targets = goals
                taken = tuple(a and b for a, b in zip(first.taken, knot.taken, strict=True))
                if first is not knot and any(taken[: len(self.points)]):
                    times = first.time + (knot.time - first.time) * CHECKED
                    there = parent.repeated(row, len(times))
                    direct = self._way(knots, [k.after for k in knots], times)
                    asked = self._goals(foresight(row, times), there, direct).only(taken)
                    knot.detours = not self._leads_through(asked, direct, times[1] - times[0])
            way = [(knot, goals)]
        return knots

    def _track(self, way: list[tuple[Knot, LimbGoals]]) -> bool:
        """Follow goals from the first knot of a way to the last; return whether they were met."""
        first = way[0][0]
        if len(way) == 1 or first.after is None:
            return False
        q = first.after[None]
        for knot, goals in way[1:]:
            most = KEY_STEPS if knot is way[-1][0] else ROW_STEPS
            least = 1 if goals.clearance is None else ROW_STEPS
            q = pursue(self.batch, q, goals, most, least).q
            if self._search.cost(goals, self.batch.pose(q))[0] > KEY_TOLERANCE:
                return False
            knot.before = knot.after = q[0]
            knot.targets = goals
        return True

    def _leads_through(self, goals: LimbGoals, way: Array, dt: float) -> bool:
        """Return whether the goals of n rows can be met without jumps, near a `way` (n, k)."""
        inner = goals.rows(np.arange(1, len(way) - 1))
        found = pursue(self.batch, way[1:-1], inner, ROW_STEPS)
        q = np.concatenate([way[:1], found.q, way[-1:]])
        ends = self._search.cost(goals, self.batch.pose(way))[[0, -1]].max()
        largest, least = (float(np.abs(np.diff(rows, axis=0)).max()) for rows in (q, way))
        most = max(JUMP_RATIO * least, min(least + JUMP_ANGLE, CALM * MAX_JOINT_RATE * dt))
        missed = float(self._search.cost(inner, found).max())
        return bool(largest < most and missed < ends + KEY_TOLERANCE)

    def _detours(self, times: Array) -> tuple[Array, Array]:
        """Return whose times' goals rows keep (n,) [s], and how far (n,).

        Those of their own times, fully; but on a detour those of the key that was, less and less,
        and then of the key that is to be.
        """
        knots = self._knots
        ends = np.array([knot.time for knot in knots])
        detours = np.array([bool(knot.detours) for knot in knots])
        met = np.array([knot.is_met for knot in knots])
        right = np.clip(np.searchsorted(ends, times, side="right"), 1, len(ends) - 1)
        away = detours[right] & (times > ends[right - 1]) & (times < ends[right])
        if not away.any():
            return times, np.ones(len(times))
        s = (times - ends[right - 1]) / np.maximum(ends[right] - ends[right - 1], SAME_TIME)
        near = np.where(s < 0.5, right - 1, right)
        share = 1.0 - ease(np.clip(np.minimum(s, 1.0 - s) / DETOUR_END, 0.0, 1.0))
        return np.where(away, ends[near], times), np.where(away, share * met[near], 1.0)

    def _goals_of(
        self, knots: list[Knot], row: int, own: Array, parent: LimbParent, foresight: Foresight
    ) -> Iterator[tuple[Knot, LimbGoals]]:
        """Return the goals (one row) of knots, as foreseen in `row`."""
        times = np.array([knot.time for knot in knots])
        if not len(times):
            return
        pull = np.broadcast_to(own[row], (len(times), own.shape[1]))
        goals = self._goals(foresight(row, times), parent.repeated(row, len(times)), pull)
        for i, knot in enumerate(knots):
            yield knot, goals.only(knot.taken).rows(np.array([i]))

    def _has_moved(self, before: LimbGoals, now: LimbGoals) -> bool:
        size = float(self.batch.lengths[0])
        moves = [
            float(np.abs(a - b).max()) / (size if run.goal == "reach" else 1.0)
            for run, a, b in zip(now.points, before.targets, now.targets, strict=True)
        ]
        return max(moves, default=0.0) > MOVED_TARGET
