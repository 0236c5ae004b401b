"""Passive swing: the leg falls forward by itself, and is only placed at the end.

Muscles draw the leg in, along the line from hip to foot, so that the foot keeps clear of
the ground, as small motors do in walkers that go down a slope without others: a leg that
hangs quite freely would scuff at once. Nothing turns it about the hip. With σ the part of
the way over the ground that the foot has gone, q(σ, t) the joint values by inverse
kinematics, and φ the turn of the whole leg about its hip that brings the foot ahead most,
this is, by virtual work,

    (∂q/∂φ) · (τ + d q̇) = 0,

where τ is what the motion of the leg needs below a body that goes its path, and d what
joints damp. Limits of joints are kept as inverse kinematics keeps them. The equation is
solved for σ step by step with the derivatives that rows have, from the foot at rest and the
body on its way. From some row on the foot is brought to its foothold by a quintic: from the
last one from which it does not have to hurry. Where legs are long and swings short, that
is soon: a leg that falls takes half its own period.

Source: Sims 1987, 7.4, which was not implemented; McGeer 1990 for legs that swing by
themselves and are drawn in; Flash and Hogan 1985 for the way home.
"""

from __future__ import annotations

import math

import numpy as np

from pipeline.simulation.curves import bump, ease
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.figures.inverse_dynamics import finite_difference_motion
from pipeline.simulation.locomotion.swing.swing_dynamics import DURING, ROWS, SwingTrial
from pipeline.simulation.locomotion.swing.swing_trajectory import (
    KNOTS,
    POINTS,
    SPANS,
    clearance_height,
    fit_offset,
)
from pipeline.simulation.spatial import UP, Array, normalized, unturn
from pipeline.simulation.terrain import Ground

LONGEST = 0.6
"""Part of the swing in which a leg may be free."""

HURRY = 1.5
"""Greatest speed on the way home, of the plain swing's greatest."""

EASE_SPEED = 1.875
"""Greatest slope of `ease`."""

BACKWARD = 0.05
"""How far a free foot may fall back, as a part of its way."""

DAMPING = 0.05
"""Of the joints, as a part of what would just keep the hanging leg from swinging."""

SHORT = 0.02
"""Ways shorter than this are no fall, in lengths of the leg."""

NUDGE = 1e-3
"""Change of σ by which its effect is found."""


LEAP = 0.1
"""Change of σ within a row, beyond going on, that is no swing: the leg falls over."""


def passive(
    trial: SwingTrial, ground: Ground, sole: float, step_height: float
) -> tuple[float, Array]:
    """Return height [m] and bend of a swing by itself.

    Args:
        trial: the swing.
        ground: that is to be cleared.
        sole: radius of the foot [m].
        step_height: on level ground [m].
    """
    ends, plain = (trial.start, trial.end), np.zeros((POINTS, 3))
    height = clearance_height(ground, *ends, sole, step_height)
    way = _level(trial)
    if np.linalg.norm(way) < SHORT * float(trial.model.batch.lengths[0]):
        return height, plain
    part, free = fall(trial, height)
    if not free:
        return height, plain
    bend = fit_offset((part[:: ROWS // SPANS] - ease(KNOTS))[:, None] * way)
    higher = clearance_height(ground, *ends, sole, step_height, bend)
    # Legs that are spread wide rather fall over than swing: those are led.
    tips = np.stack([trial.tips(higher, bend), trial.tips(height, plain)], axis=1)
    by_itself, led = trial.powers(tips)[0][: free + 1].sum(axis=0)
    return (higher, bend) if by_itself < led else (height, plain)


def fall(trial: SwingTrial, height: float) -> tuple[Array, int]:
    """Return how a leg swings by itself, its foot lifted by an arch of `height` [m].

    Returns:
        σ at the rows of the swing (`ROWS` + 1,), and the last row at which the leg is free.
    """
    σ = _free(trial, height)
    for k in range(len(σ) - 2, 1, -1):
        home = _home(σ, k)
        if home is not None:
            return np.concatenate([σ[1 : k + 1], home]), k - 1
    return ease(np.linspace(0.0, 1.0, ROWS + 1)), 0


def _level(trial: SwingTrial) -> Array:
    """Return the way over the ground (3,) [m]."""
    way: Array = (trial.end - trial.start) * (1.0 - UP)
    return way


def _free(trial: SwingTrial, height: float) -> Array:
    """Return σ of a free leg at the rows from the one before the swing on."""
    damping = _damping(trial)
    before, here = (_near(trial, height, row, 0.0)[0][0] for row in (0, 1))
    turned = _near(trial, height, 1, 0.0)[1]
    σ = [0.0, 0.0, 0.0]
    for row in range(2, 2 + math.ceil(LONGEST * ROWS)):
        # As if the acceleration stayed, so that a small change is left to be found.
        guess = 3.0 * (σ[-1] - σ[-2]) + σ[-3]
        after, turning = _near(trial, height, row, guess)
        pull = _pull(trial, row - 1, np.stack([before, here]), after, turned, damping)
        nudges = pull[0] / (pull[0] - pull[1]) if pull[1] > pull[0] else math.inf
        if abs(nudges) * NUDGE > LEAP:
            break
        σ.append(guess + NUDGE * float(nudges))
        before, here, turned = here, after[0] + nudges * (after[1] - after[0]), turning
    return np.array(σ[1:])


def _pull(
    trial: SwingTrial, row: int, rows: Array, after: Array, turned: Array, damping: float
) -> Array:
    """Return the work (m,) for a turn of the leg that is lacking at `row`.

    Args:
        trial: the swing.
        row: in its middle between three.
        rows: (2, n) joint values before it and at it.
        after: (m, n) those after it.
        turned: (n,) how they change as the leg turns there.
        damping: of the joints [N m s].
    """
    many = len(after)
    q = np.concatenate([np.repeat(rows[:, None], many, axis=1), after[None]])
    near = slice(row - 1, row + 2)
    R = np.broadcast_to(trial.R_WB[near, None], (3, many, 3, 3))
    p = np.broadcast_to(trial.p_WB[near, None], (3, many, 3))
    motion = finite_difference_motion(q, R, p, trial.dt)
    needed = trial.load(motion).torques + damping * motion.speeds
    result: Array = (needed[0] * turned).sum(axis=-1)
    return result


def _near(trial: SwingTrial, height: float, row: int, σ: float) -> tuple[Array, Array]:
    """Return joint values at a row for σ and a nudge beyond (2, n), and how a turn changes them.

    The turn (n,) is of the whole leg about its hip, the one that brings the foot ahead most.
    """
    s, way = DURING[row], _level(trial)
    up = ease(s) * (trial.end[1] - trial.start[1]) + height * bump(s)
    tip = trial.start + σ * way + up * UP
    hip = trial.p_WB[row] + trial.R_WB[row] @ trial.model.batch.places[0, 0]
    ahead, size = normalized(way), float(np.linalg.norm(way))
    leg = normalized(tip - hip)
    across = normalized(ahead - (ahead @ leg) * leg)
    tips = tip + np.stack([0.0 * way, NUDGE * way, NUDGE * size * across])
    R = np.broadcast_to(trial.R_WB[row], (3, 3, 3))
    q = trial.model.settled(unturn(R, tips - trial.p_WB[row]))[0]
    return q[:2], (q[2] - q[0]) / NUDGE


def _damping(trial: SwingTrial) -> float:
    """Return d [N m s] of all joints: a part of 2 m l² √(g / l), as of a pendulum of its length."""
    mass = float(trial.model.masses.mass.sum())
    length = 0.5 * float(trial.model.batch.lengths[0])
    return DAMPING * 2.0 * mass * math.sqrt(GRAVITY * length**3)


def _home(σ: Array, k: int) -> Array | None:
    """Return σ at the rows after `k` up to the end; None if the foot would have to hurry.

    The quintic that goes on from row `k` and comes to rest at 1.
    """
    left = ROWS + 1 - k
    speed, change = 0.5 * (σ[k + 1] - σ[k - 1]) * left, (σ[k + 1] - 2.0 * σ[k] + σ[k - 1]) * left**2
    gap = 1.0 - σ[k]
    third = 10.0 * gap - 6.0 * speed - 1.5 * change
    fourth = -15.0 * gap + 8.0 * speed + 1.5 * change
    fifth = 6.0 * gap - 3.0 * speed - 0.5 * change
    t = np.arange(1, left + 1) / left
    home = σ[k] + t * (speed + t * (0.5 * change + t * (third + t * (fourth + t * fifth))))
    fastest = np.diff(home, prepend=σ[k]).max() * ROWS
    hurries = fastest > HURRY * EASE_SPEED
    astray = home.min() < -BACKWARD or home.max() > 1.0 + BACKWARD
    return None if hurries or astray else home
