"""Passive swing: the leg falls forward by itself, and is only placed at the end.

Muscles draw the leg in along the line from hip to foot, so that the foot clears the ground, as
small motors do in walkers that descend a slope passively: a freely hanging leg would scuff at once.
Nothing turns it about the hip. With σ the fraction of the way over the ground that the foot has
gone, q(σ, t) the joint values by inverse kinematics, and φ the turn of the whole leg about its hip
that brings the foot ahead most, this is, by virtual work,

    (∂q/∂φ) · (τ + d q̇) = 0,

where τ is the torque that the leg's motion needs below a body on its trajectory, and d the damping
of the joints. Joint limits are kept by inverse kinematics. The equation is solved for σ row by row
with finite differences, from the foot at rest and the body on its way. From some row on a quintic
brings the foot to its foothold: from the last row from which it does not have to hurry. Where legs
are long and swings short that is soon: a falling leg takes half its own period.

Source: Sims 1987, 7.4, which was not implemented; McGeer 1990 for legs that swing by themselves and
are drawn in; Flash and Hogan 1985 for the quintic.
"""

from __future__ import annotations

import math

import numpy as np

from pipeline.simulation.curves import bump, ease
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.figures.inverse_dynamics import finite_difference_motion
from pipeline.simulation.locomotion.gaits.gait_transition import MAX_EASE_SLOPE
from pipeline.simulation.locomotion.swing.swing_dynamics import FOOT_FRACTIONS, ROWS, SwingTrial
from pipeline.simulation.locomotion.swing.swing_trajectory import (
    KNOTS,
    PIECES,
    POINTS,
    clearance_height,
    fit_bend,
)
from pipeline.simulation.spatial import UP, Array, normalized, turn_inverse
from pipeline.simulation.terrain import Ground

# Part of the swing in which a leg may be free.
MAX_FREE_FRACTION = 0.6

# Greatest speed of the quintic, in greatest speeds of the plain swing.
MAX_HURRY = 1.5

# How far a free foot may fall back, as a fraction of its way.
MAX_BACKWARD = 0.05

# Damping of the joints, as a fraction of the critical damping of the hanging leg.
DAMPING = 0.05

# Ways shorter than this are led, in leg lengths.
MIN_WAY = 0.02

# Change of σ for finite differences; and change within a row, beyond going on, at which the leg
# falls over instead of swinging.
NUDGE, MAX_JUMP = 1e-3, 0.1


def plan_passive_swing(
    trial: SwingTrial, ground: Ground, foot_radius: float, step_height: float
) -> tuple[float, Array]:
    """Return height [m] and bend of a passive swing.

    Args:
        trial: the swing.
        ground: under it.
        foot_radius: [m].
        step_height: on level ground [m].
    """
    ends, plain = (trial.start, trial.end), np.zeros((POINTS, 3))
    height = clearance_height(ground, *ends, foot_radius, step_height)
    way = _level_way(trial)
    if np.linalg.norm(way) < MIN_WAY * float(trial.model.batch.lengths[0]):
        return height, plain
    part, free = simulate_fall(trial, height)
    if not free:
        return height, plain
    bend = fit_bend((part[:: ROWS // PIECES] - ease(KNOTS))[:, None] * way)
    higher = clearance_height(ground, *ends, foot_radius, step_height, bend)
    # Legs that are spread wide fall over rather than swing: those are led.
    tips = np.stack([trial.tips(higher, bend), trial.tips(height, plain)], axis=1)
    by_itself, led = trial.powers(tips)[0][: free + 1].sum(axis=0)
    return (higher, bend) if by_itself < led else (height, plain)


def simulate_fall(trial: SwingTrial, height: float) -> tuple[Array, int]:
    """Return the passive motion of a leg whose foot is lifted by an arch of `height` [m].

    Returns:
        σ at the rows of the swing (`ROWS` + 1,), and the last row at which the leg is free.
    """
    σ = _free_motion(trial, height)
    for k in range(len(σ) - 2, 1, -1):
        placed = _quintic_to_foothold(σ, k)
        if placed is not None:
            return np.concatenate([σ[1 : k + 1], placed]), k - 1
    return ease(np.linspace(0.0, 1.0, ROWS + 1)), 0


def _level_way(trial: SwingTrial) -> Array:
    """Return the way over the ground (3,) [m]."""
    return (trial.end - trial.start) * (1.0 - UP)


def _free_motion(trial: SwingTrial, height: float) -> Array:
    """Return σ of a free leg at the rows from the one before the swing on."""
    # A fraction of 2 m l² √(g / l), as of a pendulum of the leg's length [N m s].
    length = 0.5 * float(trial.model.batch.lengths[0])
    mass = float(trial.model.masses.mass.sum())
    damping = DAMPING * 2.0 * mass * math.sqrt(GRAVITY * length**3)
    before, here = (_near_row(trial, height, row, 0.0)[0][0] for row in (0, 1))
    turned = _near_row(trial, height, 1, 0.0)[1]
    σ = [0.0, 0.0, 0.0]
    for row in range(2, 2 + math.ceil(MAX_FREE_FRACTION * ROWS)):
        # As if the acceleration stayed, so that a small change is left to be found.
        guess = 3.0 * (σ[-1] - σ[-2]) + σ[-3]
        after, turning = _near_row(trial, height, row, guess)
        pull = _missing_work(trial, row - 1, np.stack([before, here]), after, turned, damping)
        nudges = pull[0] / (pull[0] - pull[1]) if pull[1] > pull[0] else math.inf
        if abs(nudges) * NUDGE > MAX_JUMP:
            break
        σ.append(guess + NUDGE * float(nudges))
        before, here, turned = here, after[0] + nudges * (after[1] - after[0]), turning
    return np.array(σ[1:])


def _missing_work(
    trial: SwingTrial, row: int, rows: Array, after: Array, turned: Array, damping: float
) -> Array:
    """Return the virtual work (m,) that is lacking at `row`.

    Args:
        trial: the swing.
        row: in the middle of three.
        rows: (2, n) joint values before it and at it.
        after: (m, n) joint values after it.
        turned: (n,) change of the joints as the leg turns there.
        damping: of the joints [N m s].
    """
    many = len(after)
    q = np.concatenate([np.repeat(rows[:, None], many, axis=1), after[None]])
    near = slice(row - 1, row + 2)
    R = np.broadcast_to(trial.R_WB[near, None], (3, many, 3, 3))
    p = np.broadcast_to(trial.p_WB[near, None], (3, many, 3))
    motion = finite_difference_motion(q, R, p, trial.dt)
    needed = trial.load(motion).torques + damping * motion.speeds
    return (needed[0] * turned).sum(axis=-1)


def _near_row(trial: SwingTrial, height: float, row: int, σ: float) -> tuple[Array, Array]:
    """Return joint values at a row for σ and for σ + nudge (2, n), and ∂q/∂φ (n,)."""
    s, way = FOOT_FRACTIONS[row], _level_way(trial)
    up = ease(s) * (trial.end[1] - trial.start[1]) + height * bump(s)
    tip = trial.start + σ * way + up * UP
    hip = trial.p_WB[row] + trial.R_WB[row] @ trial.model.batch.places[0, 0]
    ahead, size = normalized(way), float(np.linalg.norm(way))
    leg = normalized(tip - hip)
    across = normalized(ahead - (ahead @ leg) * leg)
    tips = tip + np.stack([0.0 * way, NUDGE * way, NUDGE * size * across])
    R = np.broadcast_to(trial.R_WB[row], (3, 3, 3))
    q = trial.model.solve(turn_inverse(R, tips - trial.p_WB[row]))[0]
    return q[:2], (q[2] - q[0]) / NUDGE


def _quintic_to_foothold(σ: Array, k: int) -> Array | None:
    """Return σ after row `k`, to rest at 1 by a quintic; None if the foot would have to hurry."""
    left = ROWS + 1 - k
    speed, change = 0.5 * (σ[k + 1] - σ[k - 1]) * left, (σ[k + 1] - 2.0 * σ[k] + σ[k - 1]) * left**2
    gap = 1.0 - σ[k]
    third = 10.0 * gap - 6.0 * speed - 1.5 * change
    fourth = -15.0 * gap + 8.0 * speed + 1.5 * change
    fifth = 6.0 * gap - 3.0 * speed - 0.5 * change
    t = np.arange(1, left + 1) / left
    path = σ[k] + t * (speed + t * (0.5 * change + t * (third + t * (fourth + t * fifth))))
    fastest = np.diff(path, prepend=σ[k]).max() * ROWS
    hurries = fastest > MAX_HURRY * MAX_EASE_SLOPE
    is_astray = path.min() < -MAX_BACKWARD or path.max() > 1.0 + MAX_BACKWARD
    return None if hurries or is_astray else path
