"""The complete inverse kinematics, for limbs that are posed.

First the tips are brought to their goals: near full extension by its own method, elsewhere by
damped pseudo-inverse iterations along a path of segments. Limbs that a limit stops short on a long
way try another branch, found by geometry; they may also restart from random joint values.

`tip_ik` is for tips that need no such search, as the feet of walking legs.

Notation of the thesis: x tip, θ joint values (here q), J Jacobian, α gain.

Source: Sims 1987, ch. 6 and appendix B; damping after Sugihara 2011.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.ball_joint_ik import (
    ball_joint_branches,
    base_ball_joint,
    full_reach,
    is_near_extension,
    solve_extended,
)
from pipeline.simulation.figures.ik_goals import TipPlacement
from pipeline.simulation.figures.inverse_kinematics import TIP_ITERATION, IKSolution, closest_pose
from pipeline.simulation.figures.kinematics import LimbBatch, LimbPose
from pipeline.simulation.figures.task_priority import Task, bounded_priority_step
from pipeline.simulation.spatial import Array

DAMPING_RATIO = 0.05
"""λ as a fraction of the error: it calms joints of limbs out of reach, and vanishes at the goal."""

MIN_DAMPING = 1e-6
"""Least λ."""

MIN_SEGMENT = 1e-7
"""Segment below which a tip is as near its goal as its limits allow."""

RESTART_DRAWS = 32
"""Random joint values for one restart; it starts at those nearest to the goal."""

REST_PREFERENCE = 1e-2
"""Extra distance, in lengths of the limb, that a branch may start with for joints one radian
nearer to rest."""


@dataclass(frozen=True, eq=False)
class _ReachState:
    """Limbs in progress: their pose, and the remaining error (L,), see `TipPlacement.task`."""

    pose: LimbPose
    error: Array

    def where(self, chosen: NDArray[np.bool_], other: _ReachState) -> _ReachState:
        return _ReachState(
            self.pose.where(chosen, other.pose), np.where(chosen, self.error, other.error)
        )

    def better(self, other: _ReachState) -> _ReachState:
        return self.where(self.error < other.error, other)


def reach(
    batch: LimbBatch,
    start: LimbPose,
    goals: Array,
    orientation: Array | None = None,
    *,
    restarts: int = 0,
    rng: np.random.Generator | None = None,
    max_iterations: int = 50,
) -> IKSolution:
    """Bring tips to places, and to orientations if given.

    Args:
        batch: the limbs.
        start: within the limits; along a motion the pose of the step before.
        goals: (L, 3) places of the tips relative to their bases [m]. One out of reach gives the
            closest pose that is found, with its residual. A tip less than a segment from its goal
            stays on its branch: along a motion a knee never flips.
        orientation: (L, 3, 3) R_BF of the tips; free by default.
        restarts: number of restarts, from random values, of limbs that fell short. None along a
            motion: the pose would jump.
        rng: for the restarts.
        max_iterations: bound on the iterations of each start.

    Raises:
        ValueError: there are restarts but no `rng`.
    """
    aim = TipPlacement(goals, orientation)
    state, iterations = _first_approach(batch, start, aim, max_iterations)
    state, more = _try_branches(batch, start, state, aim, max_iterations)
    iterations += more
    for _ in range(restarts):
        if rng is None:
            raise ValueError("restarts need a generator of random numbers")
        # Drawn for all limbs, so that a limb's values do not depend on the success of others.
        share = rng.random((RESTART_DRAWS, *batch.lower.shape))
        rows = np.flatnonzero(state.error > TIP_ITERATION.tolerance)
        if len(rows):
            own = batch.rows(rows)
            draws = own.lower + share[:, rows] * (own.upper - own.lower)
            q = _nearest_draw(own, aim.rows(rows), draws)
            state, more = _retry(batch, state, aim, rows, q, max_iterations)
            iterations += more
    residual = np.linalg.norm(goals - state.pose.tips, axis=-1)
    turn = None
    if orientation is not None:
        turn = np.linalg.norm(aim.task(batch, state.pose).velocity[:, 3:], axis=-1)
    return IKSolution(batch, state.pose, residual, iterations, turn)


def _nearest_draw(batch: LimbBatch, aim: TipPlacement, draws: Array) -> Array:
    """Return, of several joint values (D, L, n), those (L, n) with the least error."""
    errors = np.stack([_error(batch, batch.pose(q), aim) for q in draws])
    return draws[errors.argmin(axis=0), np.arange(len(aim.places))]


def _first_approach(
    batch: LimbBatch, start: LimbPose, aim: TipPlacement, most: int
) -> tuple[_ReachState, int]:
    """Approach from `start`; near full extension by its own method where that succeeds."""
    state = _ReachState(start, _error(batch, start, aim))
    stretched = is_near_extension(batch, start, aim.places) & (
        state.error > TIP_ITERATION.tolerance
    )
    if aim.orientations is None and stretched.any():
        rows = np.flatnonzero(stretched)
        own, there = batch.rows(rows), aim.rows(rows)
        pose = solve_extended(own, start.rows(rows), there.places)
        left = _error(own, pose, there)
        beyond = np.linalg.norm(there.places - own.places[:, 0], axis=-1) - full_reach(own)
        done = left <= np.maximum(beyond / own.lengths, 0.0) + TIP_ITERATION.tolerance
        state = _replace_rows(state, rows[done], _ReachState(pose, left), done)
        if done.all() and len(rows) == len(state.error):
            return state, 1
        # A limb stretched towards a goal beyond its reach is as near as possible.
        rest = np.setdiff1d(np.arange(len(state.error)), rows[done])
        return _retry(batch, state, aim, rest, state.pose.q[rest], most)
    return _approach(batch, state, aim, most)


def _try_branches(
    batch: LimbBatch, start: LimbPose, state: _ReachState, aim: TipPlacement, most: int
) -> tuple[_ReachState, int]:
    """Let limbs that fell short on a long way take another branch, if it ends at the goal.

    The branch is the one with the tip nearest to its goal and the joints nearest to rest; there is
    no randomness in it.
    """
    begun = _error(batch, start, aim)
    beyond = np.linalg.norm(aim.places - batch.places[:, 0], axis=-1) > full_reach(batch)
    stuck = (
        (state.error > TIP_ITERATION.tolerance)
        & (begun > TIP_ITERATION.segment)
        & ~beyond
        & base_ball_joint(batch).any(axis=1)
    )
    rows = np.flatnonzero(stuck)
    if not len(rows):
        return state, 0
    own, there = batch.rows(rows), aim.rows(rows)
    ways = ball_joint_branches(own, there.places)
    left = np.stack([_error(own, own.pose(q), there) for q in ways])
    apart = np.abs(ways - own.preferred).max(axis=-1)
    q = ways[(left + REST_PREFERENCE * apart).argmin(axis=0), np.arange(len(rows))]
    found, count = _retry(batch, state, aim, rows, q, most)
    return found.where(found.error <= TIP_ITERATION.tolerance, state), count


def _retry(
    batch: LimbBatch,
    state: _ReachState,
    aim: TipPlacement,
    rows: NDArray[np.int64],
    q: Array,
    most: int,
) -> tuple[_ReachState, int]:
    """Approach with the limbs `rows` (k,) alone from `q` (k, n); keep the better result."""
    own, there = batch.rows(rows), aim.rows(rows)
    pose = own.pose(q)
    found, count = _approach(own, _ReachState(pose, _error(own, pose, there)), there, most)
    kept = _ReachState(state.pose.rows(rows), state.error[rows])
    return _replace_rows(state, rows, found.better(kept), np.ones(len(rows), dtype=bool)), count


def _replace_rows(
    state: _ReachState, rows: NDArray[np.int64], other: _ReachState, taken: NDArray[np.bool_]
) -> _ReachState:
    """Return `state` with the limbs `rows` replaced by the `taken` ones of `other`."""
    if not len(rows):
        return state
    pose, new = state.pose, other.pose
    arrays = []
    for old, fresh in (
        (pose.q, new.q),
        (pose.X_BJ, new.X_BJ),
        (pose.tips, new.tips),
        (pose.jacobian, new.jacobian),
        (state.error, other.error),
    ):
        changed = old.copy()
        changed[rows] = fresh[taken]
        arrays.append(changed)
    return _ReachState(LimbPose(*arrays[:4]), arrays[4])


def _approach(
    batch: LimbBatch, state: _ReachState, aim: TipPlacement, most: int
) -> tuple[_ReachState, int]:
    """Go towards the goals segment by segment, until they are reached or progress ends."""
    longest = np.full(len(state.error), TIP_ITERATION.segment)
    calm = np.zeros(len(state.error), dtype=bool)
    count = 0
    rows = np.arange(0)
    for count in range(most):
        active = np.flatnonzero((state.error > TIP_ITERATION.tolerance) & (longest > MIN_SEGMENT))
        if not len(active):
            break
        if not np.array_equal(active, rows):
            rows, own, there = active, batch.rows(active), aim.rows(active)
        here = _ReachState(state.pose.rows(rows), state.error[rows])
        gain = np.where(
            ~calm[rows] & ((count == 0) | (here.error > TIP_ITERATION.redundancy_cutoff)),
            TIP_ITERATION.rest_gain,
            0.0,
        )
        after, off = _segment(own, here, there, longest[rows], gain, calm[rows])
        good = after.error < here.error
        # A segment after which the tip is not nearer was too long: revert and shorten it. After
        # one whose end was met the next may be longer (Sims 1987, figure 6.3).
        factor = np.where(good, np.where(off < 0.3, 2.0, 1.0), 0.25)
        longest[rows] = np.minimum(longest[rows] * factor, 1.0)
        calm[rows] = ~good
        state = _replace_rows(state, rows[good], after, good)
    short = np.flatnonzero(state.error > TIP_ITERATION.tolerance)
    if len(short):
        own, there = batch.rows(short), aim.rows(short)
        pose = closest_pose(own, state.pose.rows(short), there)
        nearest = _ReachState(pose, _error(own, pose, there))
        state = _replace_rows(state, short, nearest, np.ones(len(short), dtype=bool))
    return state, count


def _segment(
    batch: LimbBatch,
    state: _ReachState,
    aim: TipPlacement,
    longest: Array,
    gain: Array,
    straight: NDArray[np.bool_],
) -> tuple[_ReachState, Array]:
    """Return the limbs one segment on, and the fraction of it by which they missed its end (L,)."""
    task = aim.task(batch, state.pose)
    part = np.minimum(1.0, longest / np.maximum(state.error, 1e-300))[:, None]
    # On a long way the middle of the limits attracts: a knee that starts straight would else be
    # driven into the limit that it does not bend towards.
    middle = 0.5 * (batch.lower + batch.upper)
    share = np.where(state.error > TIP_ITERATION.segment, 0.5, 0.0)[:, None]
    z = gain[:, None] * (batch.preferred + share * (middle - batch.preferred) - state.pose.q)
    velocity = part * task.velocity
    arc = _arc_step(batch, state.pose.tips, aim.places, part)
    # Only the straight way leads nearer when all others fail.
    velocity[:, :3] = np.where(straight[:, None], velocity[:, :3], arc)
    tasks = [Task(task.jacobian, velocity), Task.wish(z)]
    q, _ = bounded_priority_step(
        batch, state.pose.q, tasks, MIN_DAMPING + DAMPING_RATIO * state.error
    )
    pose = batch.pose(q)
    left = aim.task(batch, pose).velocity
    missed = np.linalg.norm(task.velocity - left - velocity, axis=-1)
    off = missed / np.maximum(part[:, 0] * state.error, 1e-300)
    return _ReachState(pose, np.linalg.norm(left, axis=-1)), off


def _arc_step(batch: LimbBatch, tips: Array, goals: Array, part: Array) -> Array:
    """Return the step (L, 3), in lengths of the limb, that leads `part` (L, 1) of the way.

    The way turns about the base while it lengthens or shortens: a straight one to a goal on the
    other side would lead through the base, which folds a limb into its limits.
    """
    base = batch.places[:, 0]
    a, b = tips - base, goals - base
    r_a, r_b = (np.linalg.norm(v, axis=-1, keepdims=True) for v in (a, b))
    a, b = a / np.maximum(r_a, 1e-300), b / np.maximum(r_b, 1e-300)
    sine = np.linalg.norm(np.cross(a, b), axis=-1, keepdims=True)
    angle = np.arctan2(sine, np.sum(a * b, axis=-1, keepdims=True))
    near = sine < 1e-6
    safe = np.where(near, 1.0, sine)
    u = np.where(near, 1.0 - part, np.sin((1.0 - part) * angle) / safe)
    v = np.where(near, part, np.sin(part * angle) / safe)
    there = base + (u * a + v * b) * (r_a + part * (r_b - r_a))
    there = np.where(part < 1.0, there, goals)
    return (there - tips) / batch.lengths[:, None]


def _error(batch: LimbBatch, pose: LimbPose, aim: TipPlacement) -> Array:
    return np.linalg.norm(aim.task(batch, pose).velocity, axis=-1)
