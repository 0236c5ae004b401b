"""Inverse kinematics of tips: joint values that bring the tips of limbs to their goals.

First the distance from base to tip is set, by all inner joints together (`bend_path`), then the
ball joint at the base points the limb (`ball_aim`). That is exact but for rounding, unless a ball
joint meets its limits; a fixed number of pseudo-inverse iterations spreads what is left over all
joints. So a limb's pose is a continuous function of its goal alone: no knee flips, a limb returns
to the same pose with its foot, and poses of many moments can be solved at once, in any order.
Limbs without a ball joint start the iterations with their base joints at their preferred values.

All is written out for limbs of one structure (`limb_chains`), block by block. Sums go joint by
joint, and the three equations of a tip are solved by elimination, so that the last bit does not
depend on the number of limbs.

Source: Sims 1987, 6.1, 6.2, 6.3.1, B.2 and B.4.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.curves import ease
from pipeline.simulation.figures.foot_link import wanted_offset
from pipeline.simulation.figures.kinematics import LimbBatch, LimbRows
from pipeline.simulation.figures.limb_chains import ChainGroup
from pipeline.simulation.spatial import Array

SEGMENT = 0.35
"""Longest step of a tip in one iteration, in lengths of the limb."""

CORRECTIONS, FREE_CORRECTIONS = 2, 8
"""Iterations after the first guess, of limbs with a ball joint at their base and of others."""

MORE_CORRECTIONS = 16
"""Iterations of those that are not there then."""

LEAST_DAMPING = 1e-4
"""Least λ, in lengths of the limb."""

DAMPING = 0.5
"""λ² in squared distances of tip from goal (Sugihara 2011)."""

TOLERANCE = 1e-6
"""Accepted distance of tip from goal, in lengths of the limb."""

GIVING_WAY = 0.2
"""Way of a hip to its limit on which the foot of its leg gives way [rad]."""

BLOCK_SIZE = 5000
"""Limbs times moments solved at once: so many fit a processor's cache."""


@dataclass(frozen=True, eq=False)
class TipSolution:
    """L limbs at their goals at m moments.

    Attributes:
        q: (m, L, n) joint values within their limits [rad or m].
        X_BJ: (m, L, n, 4, 4) frames of the joints relative to the body; padding has none.
        residual: (m, L) distance of tip from goal [m].
    """

    q: Array
    X_BJ: Array
    residual: Array


def solve_tips(
    batch: LimbBatch, chains: Sequence[ChainGroup], goals: Array, feet: Array | None = None
) -> TipSolution:
    """Move the tips to `goals`.

    Args:
        batch: L limbs.
        chains: the same limbs by structure.
        goals: (m, L, 3) at m moments, relative to the body [m].
        feet: (m, L, 3) wanted directions of the last links of legs that have a foot, relative to
            the body; their lengths are the parts of the way to them, 0 to 1.
    """
    moments, limbs, n = len(goals), *batch.is_joint.shape
    q = np.tile(batch.preferred, (moments, 1, 1))
    X = np.zeros((moments, limbs, n, 4, 4))
    X[..., 3, 3] = 1.0
    residual = np.linalg.norm(goals - batch.tips, axis=-1)
    for chain, when in _blocks(chains, moments):
        at = when, chain.rows
        goal = np.ascontiguousarray(goals[at].transpose(2, 1, 0))
        wanted = None
        if feet is not None and chain.foot is not None:
            wanted = np.ascontiguousarray(feet[at].transpose(2, 1, 0))
        values = _solve_block(chain, goal, wanted)
        k = len(values)
        for j, frame in enumerate(chain.frames(values)):
            p = frame[3]
            if j < k:
                R = chain.rotation(j, frame)
                X[when, :, j, :3, :3][:, chain.rows] = R.transpose(3, 2, 0, 1)
                X[when, :, j, :3, 3][:, chain.rows] = p.transpose(2, 1, 0)
        residual[at] = _norm(goal - p).T
        q[when, :, :k][:, chain.rows] = values.transpose(2, 1, 0)
    moment, far = np.nonzero(residual > TOLERANCE * batch.lengths)
    if len(far):
        q[moment, far], residual[moment, far] = _continued(
            batch, chains, far, q[moment, far], goals[moment, far]
        )
        X[moment, far] = batch.rows(far).pose(q[moment, far]).X_BJ
    return TipSolution(q, X, residual)


def solve_each_tip(
    batch: LimbBatch, chains: Sequence[ChainGroup], rows: LimbRows, goals: Array
) -> tuple[Array, Array]:
    """Return the result of `solve_tips` for limbs with a goal each.

    Args:
        batch: L limbs.
        chains: the same limbs by structure.
        rows: (N,) number of the limb of each goal.
        goals: (N, 3) relative to the body [m].

    Returns:
        Joint values (N, n) [rad or m], and distances of the tips from their goals (N,) [m].
    """
    residual: Array = np.linalg.norm(goals - batch.tips[rows], axis=-1)
    q = batch.preferred[rows]
    for chain in chains:
        place = np.full(len(batch.lengths), -1)
        place[chain.rows] = np.arange(len(chain.rows))
        mine = np.flatnonzero(place[rows] >= 0)
        if not len(mine):
            continue
        some = chain.subset(place[rows[mine]])
        goal = np.ascontiguousarray(goals[mine].T)[..., None]
        values = _solve_block(some, goal)
        *_, (_, _, _, p) = some.frames(values)
        residual[mine] = _norm(goal - p)[:, 0]
        q[mine, : len(values)] = values[..., 0].T
    far = np.flatnonzero(residual > TOLERANCE * batch.lengths[rows])
    if len(far):
        numbers = np.arange(len(batch.lengths))[rows]
        q[far], residual[far] = _continued(batch, chains, numbers[far], q[far], goals[far])
    return q, residual


def _continued(
    batch: LimbBatch,
    chains: Sequence[ChainGroup],
    rows: NDArray[np.int64],
    q: Array,
    goals: Array,
) -> tuple[Array, Array]:
    """Return joint values (N, n) after more iterations from `q`, and the distances left (N,) [m].

    Limits keep these limbs from where their ball joint and bends alone would bring them.
    """
    q, residual = q.copy(), np.empty(len(rows))
    place = np.full(len(batch.lengths), -1)
    for chain in chains:
        place[:] = -1
        place[chain.rows] = np.arange(len(chain.rows))
        mine = np.flatnonzero(place[rows] >= 0)
        if not len(mine):
            continue
        some, k = chain.subset(place[rows[mine]]), len(chain.slides)
        goal = np.ascontiguousarray(goals[mine].T)[..., None]
        start = np.ascontiguousarray(q[mine, :k].T)[..., None]
        values = _corrected(some, start, goal, MORE_CORRECTIONS)
        *_, (_, _, _, p) = some.frames(values)
        residual[mine] = _norm(goal - p)[:, 0]
        q[mine, :k] = values[..., 0].T
    return q, residual


def _blocks(chains: Sequence[ChainGroup], moments: int) -> Iterator[tuple[ChainGroup, slice]]:
    """Yield limbs and moments in blocks."""
    most = min(moments, BLOCK_SIZE)
    limbs = max(BLOCK_SIZE // max(most, 1), 1)
    for chain in chains:
        for first in range(0, len(chain.rows), limbs):
            some = chain.subset(slice(first, first + limbs))
            for moment in range(0, moments, most):
                yield some, slice(moment, moment + most)


def _solve_block(chain: ChainGroup, goal: Array, feet: Array | None = None) -> Array:
    """Return the joint values (k, l, m) of a block for goals (3, l, m) [m]."""
    count = CORRECTIONS if chain.aim is not None else FREE_CORRECTIONS
    q = _first_guess(chain, goal)
    if feet is not None:
        q = _with_feet(chain, q, goal, feet)
    return _corrected(chain, q, goal, count)


def _corrected(chain: ChainGroup, q: Array, goal: Array, count: int) -> Array:
    """Return joint values (k, l, m) after `count` iterations from `q` to goals (3, l, m) [m]."""
    limbs, moments = goal.shape[1:]
    shape = len(chain.slides), limbs, moments
    lower, upper = (
        np.broadcast_to(bound, shape).reshape(shape[0], -1) for bound in (chain.lower, chain.upper)
    )
    longest = np.broadcast_to(SEGMENT * chain.lengths, (limbs, moments))
    least = np.broadcast_to((LEAST_DAMPING * chain.lengths) ** 2, (limbs, moments))
    q = q.reshape(shape[0], -1)
    for _ in range(count):
        tip, J = _jacobian(chain, q.reshape(shape))
        error = goal - tip
        far = _norm(error)
        # Calm where it is out of reach or limits hold it; vanishing at the goal.
        damping = (least + DAMPING * far * far).ravel()
        error *= np.minimum(1.0, longest / np.maximum(far, 1e-300))
        J, dx = J.reshape(3, len(q), -1), error.reshape(3, -1)
        wanted = q + _damped_step(J, dx, damping)
        bounded = np.minimum(np.maximum(wanted, lower), upper)
        at = np.flatnonzero((bounded != wanted).any(axis=0))
        if len(at):
            # Joints that would exceed a limit are held there, and the others carry the motion.
            held = bounded[:, at] != wanted[:, at]
            moved = np.where(held, bounded[:, at] - q[:, at], 0.0)
            rest = dx[:, at] - _apply_jacobian(J[..., at], moved)
            again = _damped_step(J[..., at] * ~held, rest, damping[at])
            again = q[:, at] + np.where(held, moved, again)
            bounded[:, at] = np.minimum(np.maximum(again, lower[:, at]), upper[:, at])
        q = bounded
    return q.reshape(shape)


def _first_guess(chain: ChainGroup, goal: Array) -> Array:
    """Return joint values (k, l, m) with the tips at goals (3, l, m), but for limits [rad or m]."""
    g = goal - chain.first
    q = chain.path.at(chain.on_path, _norm(g))
    if chain.aim is not None:
        q[:3] = 0.0
        *_, (_, _, _, tip) = chain.frames(q)
        q[:3] = chain.aim.angles(tip - chain.first, g)
    return np.minimum(np.maximum(q, chain.lower), chain.upper)


def _with_feet(chain: ChainGroup, q: Array, goal: Array, wanted: Array) -> Array:
    """Return joint values (k, l, m) with last links in wanted directions (3, l, m); see `FootLink`.

    A foot gives way where its hip would meet a limit, which leaves the rest to knee and ankle.

    Args:
        chain: legs with feet.
        q: (k, l, m) joint values without regard to the feet [rad or m].
        goal: (3, l, m) of the tips [m].
        wanted: directions.
    """
    result = _with_turned_feet(chain, q, goal, wanted)
    way = _way_to_limits(chain, result[:3])
    legs = np.flatnonzero((way < 1.0).any(axis=1))
    if len(legs):
        less = wanted[:, legs] * ease(way[legs])
        result[:, legs] = _with_turned_feet(chain.subset(legs), q[:, legs], goal[:, legs], less)
    limited: Array = np.minimum(np.maximum(result, chain.lower), chain.upper)
    return limited


def _with_turned_feet(chain: ChainGroup, q: Array, goal: Array, wanted: Array) -> Array:
    """Return the joint values (k, l, m) of `_with_feet`, but for limits."""
    assert chain.foot is not None
    assert chain.aim is not None
    *_, (_, _, n, ankle), (_, _, _, tip) = chain.frames(q)
    g = goal - chain.first
    offset = wanted_offset(tip - ankle, wanted, n)
    depth, turned = chain.foot.bends(
        chain.on_path, chain.path.depth(chain.on_path, _norm(g)), offset
    )
    result = chain.path.at_depth(chain.on_path, np.clip(depth, 0.0, 1.0))
    result[-1] += turned
    result[:3] = 0.0
    *_, (_, _, _, tip) = chain.frames(result)
    result[:3] = chain.aim.angles(tip - chain.first, g, n)
    return result


def _way_to_limits(chain: ChainGroup, hips: Array) -> Array:
    """Return how far hips (3, l, m) are from their limits (l, m), as parts of `GIVING_WAY`."""
    lower, upper, rest = (bound[:3] for bound in (chain.lower, chain.upper, chain.preferred))
    # Hips that rest near a limit come near it all the time.
    down, up = (np.clip(0.5 * way, 1e-6, GIVING_WAY) for way in (rest - lower, upper - rest))
    way = np.minimum((hips - lower) / down, (upper - hips) / up).min(axis=0)
    return np.clip(way, 0.0, 1.0)


def _jacobian(chain: ChainGroup, q: Array) -> tuple[Array, Array]:
    """Return the tips (3, l, m) [m] and their Jacobian (3, k, l, m)."""
    axes, lever = np.empty((2, 3, *q.shape))
    for j, (_, _, z, p) in enumerate(chain.frames(q)):
        if j < len(q):
            axes[:, j], lever[:, j] = z, p
    np.subtract(p[:, None], lever, out=lever)
    J = np.empty_like(axes)
    for i in range(3):
        a, b = (i + 1) % 3, (i + 2) % 3
        np.multiply(axes[a], lever[b], out=J[i])
        J[i] -= axes[b] * lever[a]
    for j, slides in enumerate(chain.slides):
        if slides:
            J[:, j] = axes[:, j]
    return p, J


def _damped_step(J: Array, dx: Array, damping: Array) -> Array:
    """Return J⁺ dx (k, N) with the damped J⁺ = Jᵀ (J Jᵀ + λ² I)⁻¹.

    Args:
        J: (3, k, N).
        dx: (3, N) [m].
        damping: (N,) λ² [m²].
    """
    square = _sum_joints(J * J) + damping
    mixed = _sum_joints(J * J[[1, 2, 0]])
    y = _solve_symmetric(square, mixed, dx)
    step: Array = J[0] * y[0]
    step += J[1] * y[1]
    step += J[2] * y[2]
    return step


def _solve_symmetric(d: Array, m: Array, b: Array) -> tuple[Array, Array, Array]:
    """Solve symmetric equations by elimination (L D Lᵀ).

    Args:
        d: (3, N) diagonal.
        m: (3, N) elements xy, yz and zx.
        b: (3, N) right sides.
    """
    xy, yz, zx = m
    l_yx, l_zx = xy / d[0], zx / d[0]
    d_y = d[1] - l_yx * xy
    l_zy = (yz - l_zx * xy) / d_y
    d_z = d[2] - l_zx * zx - l_zy * l_zy * d_y
    b_y = b[1] - l_yx * b[0]
    z = (b[2] - l_zx * b[0] - l_zy * b_y) / d_z
    y = b_y / d_y - l_zy * z
    return b[0] / d[0] - l_yx * y - l_zx * z, y, z


def _apply_jacobian(J: Array, q: Array) -> Array:
    """Return J q (3, N)."""
    return _sum_joints(J * q)


def _sum_joints(terms: Array) -> Array:
    """Return the sums (3, N) over joints of `terms` (3, k, N), joint by joint."""
    total: Array = terms[:, 0].copy()
    for j in range(1, terms.shape[1]):
        total += terms[:, j]
    return total


def _norm(v: Array) -> Array:
    return np.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
