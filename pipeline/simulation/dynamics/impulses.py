"""Impulses: what all contacts of a body give it together.

Vertex by vertex (12.19) is wrong where several touch at once, for each impulse changes the
speeds of the others. Together they are a linear complementarity problem,

    λ_n >= 0,   u_n >= c,   λ_n (u_n - c) = 0,      |λ_t| <= μ λ_n against the sliding,

in the velocities u = J V of the contacts after it, with V⁺ = V + M⁻¹ Jᵀ λ. Its matrix
J M⁻¹ Jᵀ has on its diagonal what (12.18) divides by: 1/m + N · ((I⁻¹ (L × N)) × L). It is
solved contact by contact, over and over, until nothing changes: a body has few contacts, so
this is quick, and that some of them say the same does no harm.

Source: Sims 1987, 12.3; Jean 1999 (block Gauss-Seidel for contact with friction).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.rigid import Bodies, dot, turned
from pipeline.simulation.spatial import Array, cross, matrix

ROUNDS = 400
"""Most times that all contacts are gone through."""

STILL = 1e-12
"""Change of a speed that is none, in parts of the speeds there are."""


@dataclass(frozen=True, eq=False)
class Problem:
    """The contacts of B bodies that act together, K each.

    Attributes:
        acts: (B, K) which of them are.
        axes: (B, K, 3, 3) normal and two tangents, one a row.
        arms: (B, K, 3, 3) levers × axes [m].
        yields: (B, K, 3, 3) turning that an impulse along an axis gives, I⁻¹ (L × d).
        matrix: (B, K, 3, 3) change of a contact's speeds by its own impulses [1/kg].
        per_mass: (B, 1) [1/kg].
        friction: (B, K).
    """

    acts: NDArray[np.bool_]
    axes: Array
    arms: Array
    yields: Array
    matrix: Array
    per_mass: Array
    friction: Array

    @staticmethod
    def of(
        bodies: Bodies, q: Array, normal: Array, lever: Array, acts: NDArray[np.bool_]
    ) -> Problem:
        """Make the problem of contacts with these normals and levers (B, K, 3)."""
        R = matrix(q)
        inverse = _products(_products(R, bodies.inverse), np.swapaxes(R, -1, -2))
        axes = _axes(normal)
        arms = cross(lever[:, :, None], axes)
        yields = turned(inverse[:, None, None], arms)
        per_mass = (1.0 / bodies.mass)[:, None]
        own = dot(arms[:, :, :, None], yields[:, :, None, :])
        own = own + per_mass[:, :, None, None] * np.eye(3)
        friction = np.broadcast_to(bodies.friction[:, None], acts.shape)
        return Problem(acts, axes, arms, yields, own, per_mass, friction)

    def speeds(self, v: Array, w: Array) -> Array:
        """Return the speeds (B, K, 3) of the contacts along their axes [m/s].

        Args:
            v: (B, 3) velocities.
            w: (B, 3) angular velocities in the world.

        Source: Sims 1987, (12.12).
        """
        return dot(self.axes, v[:, None, None]) + dot(self.arms, w[:, None, None])

    def some(self, which: NDArray[np.int64]) -> Problem:
        """Return that of some bodies."""
        return Problem(*(value[which] for value in vars(self).values()))

    def without_friction(self) -> Problem:
        """Return the same on ice."""
        return replace(self, friction=np.zeros(self.acts.shape))

    def only(self, acts: NDArray[np.bool_]) -> Problem:
        """Return the same of some contacts (B, K)."""
        return replace(self, acts=acts)


def solved(
    problem: Problem,
    v: Array,
    w: Array,
    target: Array,
    still: float = STILL,
    rounds: int = ROUNDS,
    guess: Array | None = None,
) -> tuple[Array, Array, Array]:
    """Return velocities after (B, 3), turning in the world (B, 3), impulses (B, K, 3) [N s].

    Args:
        problem: the contacts.
        v: (B, 3) velocities before.
        w: (B, 3) angular velocities before, in the world.
        target: (B, K, 3) speeds along the axes, below which no normal one may be, and which
            friction would have the tangential ones be.
        still: change of a speed that is none, in parts of the speeds there are.
        rounds: most times that the contacts are gone through.
        guess: (B, K, 3) impulses to begin with, none if left out; each has to be possible.
    """
    V = np.concatenate([v, w], axis=1)
    impulses = np.zeros((*problem.acts.shape, 3))
    miss = np.abs(problem.speeds(v, w) - target).max(axis=-1)
    scale = np.where(problem.acts, miss, 0.0).max(axis=1)
    rows = np.flatnonzero(scale > 0.0)
    sweep = _Sweep.of(problem.some(rows), V[rows], target[rows])
    if guess is not None:
        sweep.begin(guess[rows])
    for _ in range(rounds):
        if not len(rows):
            break
        changed = sweep.round()
        done = changed <= still * scale[rows]
        if done.any():
            V[rows], impulses[rows, : sweep.width] = sweep.V, sweep.impulses
            rows, sweep = rows[~done], sweep.some(~done)
    V[rows], impulses[rows, : sweep.width] = sweep.V, sweep.impulses
    return V[:, :3], V[:, 3:], impulses


@dataclass(eq=False)
class _Sweep:
    """A problem made ready for going through its contacts one by one.

    Attributes:
        V: (B, 6) velocities and turning, so far.
        impulses: (B, K, 3) so far.
        J: (B, K, 3, 6) speeds of the contacts of velocities.
        Y: (B, K, 6, 3) change of velocities by impulses.
        target: (B, K, 3) see `solved`.
        normal: (B, K) inverse of the matrices' first entries, 0 where nothing acts.
        across: (B, K, 2, 2) inverse of their tangential blocks, likewise.
        gentle: (B, K) inverse of the greater eigenvalues of these blocks, likewise.
        beside: (B, K, 2) tangential speeds by normal impulses.
        friction: (B, K).
    """

    V: Array
    impulses: Array
    J: Array
    Y: Array
    target: Array
    normal: Array
    across: Array
    gentle: Array
    beside: Array
    friction: Array

    @staticmethod
    def of(problem: Problem, V: Array, target: Array) -> _Sweep:
        # Contacts stand in the order of their gaps, so those that act are mostly the first.
        width = int(np.flatnonzero(problem.acts.any(axis=0)).max(initial=0)) + 1
        acts, own = problem.acts[:, :width], problem.matrix[:, :width]
        axes = problem.axes[:, :width]
        push = axes * problem.per_mass[:, :, None, None]
        a, b, c = own[..., 1, 1], own[..., 1, 2], own[..., 2, 2]
        across = np.stack([np.stack([c, -b], -1), np.stack([-b, a], -1)], -2)
        across = across / (a * c - b * b)[..., None, None]
        greatest = 0.5 * (a + c) + np.sqrt(0.25 * (a - c) ** 2 + b * b)
        yields = np.concatenate([push, problem.yields[:, :width]], axis=-1)
        return _Sweep(
            V=V,
            impulses=np.zeros((len(V), width, 3)),
            J=np.concatenate([axes, problem.arms[:, :width]], axis=-1),
            Y=np.ascontiguousarray(np.swapaxes(yields, -1, -2)),
            target=target[:, :width],
            normal=np.where(acts, 1.0 / own[..., 0, 0], 0.0),
            across=np.where(acts[..., None, None], across, 0.0),
            gentle=np.where(acts, 1.0 / greatest, 0.0),
            beside=own[..., 1:, 0],
            friction=problem.friction[:, :width],
        )

    @property
    def width(self) -> int:
        """Contacts that are gone through (K)."""
        return int(self.impulses.shape[1])

    def begin(self, guess: Array) -> None:
        """Let impulses act before any contact is looked at."""
        self.impulses = np.where(self.normal[..., None] > 0.0, guess[:, : self.width], 0.0)
        for k in range(self.width):
            self.V = self.V + (self.Y[:, k] * self.impulses[:, k, None]).sum(axis=-1)

    def some(self, which: NDArray[np.bool_]) -> _Sweep:
        """Return that of some bodies."""
        return _Sweep(*(value[which] for value in vars(self).values()))

    def round(self) -> Array:
        """Let each contact once have its way; return how much speeds changed (B,) [m/s]."""
        most = np.zeros(len(self.V))
        for k in range(self.width):
            before, normal = self.impulses[:, k], self.normal[:, k]
            miss = (self.J[:, k] * self.V[:, None]).sum(axis=-1) - self.target[:, k]
            after = np.empty_like(before)
            after[:, 0] = np.maximum(before[:, 0] - miss[:, 0] * normal, 0.0)
            push = after[:, 0] - before[:, 0]
            slide = miss[:, 1:] + self.beside[:, k] * push[:, None]
            hold = before[:, 1:] - (self.across[:, k] * slide[:, None]).sum(axis=-1)
            limit = self.friction[:, k] * after[:, 0]
            # What friction cannot hold slides, and its most is against the sliding: only a step
            # of the same length along every axis ends in that direction.
            free = before[:, 1:] - self.gentle[:, k, None] * slide
            slips = hold[:, 0] ** 2 + hold[:, 1] ** 2 > limit**2
            hold = np.where(slips[:, None], free, hold)
            length = np.sqrt(hold[:, 0] ** 2 + hold[:, 1] ** 2)
            after[:, 1:] = hold * (limit / np.maximum(np.maximum(length, limit), 1e-300))[:, None]
            change = after - before
            self.impulses[:, k] = after
            self.V = self.V + (self.Y[:, k] * change[:, None]).sum(axis=-1)
            moved = np.abs(change).max(axis=1) / np.where(normal > 0.0, normal, np.inf)
            most = np.maximum(most, moved)
        return most


def _axes(normal: Array) -> Array:
    """Return rows (..., 3, 3) of each normal and two tangents across it."""
    x, y, z = normal[..., 0], normal[..., 1], normal[..., 2]
    # Across the normal and whichever of X and Z it is farther from.
    flat = np.abs(x) < np.abs(z)
    first = np.where(flat[..., None], np.stack([0 * x, z, -y], -1), np.stack([y, -x, 0 * x], -1))
    first = first / np.sqrt(dot(first, first))[..., None]
    return np.stack([normal, first, cross(normal, first)], axis=-2)


def _products(a: Array, b: Array) -> Array:
    """Return matrix products (..., 3, 3), added up in one order however many there are."""
    return np.stack([turned(a, b[..., :, k]) for k in range(3)], axis=-1)
