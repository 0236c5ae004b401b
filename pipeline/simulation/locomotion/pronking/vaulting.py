"""Vaulting: the jump that takes a pronker over a hurdle, and from where it is best made.

Jumps that land in some places behind the hurdle are worked out as they will be made, each as
low as leaves a margin between the hurdle and all that passes over it: the silhouette of the
body, and the feet on their ways from the ground to the ground. Of those the one is taken that
leaves the ground the most slowly.

Source: Sims 1987, 3.2.4 and 11.1 to 11.3.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.locomotion.pronking import spin
from pipeline.simulation.locomotion.pronking.aiming import Aim, leaping, lift_off
from pipeline.simulation.locomotion.pronking.course import Leap
from pipeline.simulation.locomotion.pronking.forces import drive
from pipeline.simulation.locomotion.pronking.hurdle import Hurdle
from pipeline.simulation.locomotion.pronking.pronker import Pronker
from pipeline.simulation.locomotion.pronking.state import State
from pipeline.simulation.locomotion.pronking.touching import drawn_up
from pipeline.simulation.locomotion.routes.route import heading_vector
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground

MARGIN = 0.08
"""Between a hurdle and what passes over it, in leg lengths."""

APART = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 1.2)
"""How far before a hurdle jumps are made from, and how far behind it they land, beside what is
needed, in leg lengths."""

HALVINGS, ROUNDS = 6, 4
"""In which the lowest jump is found, and each comes about to where it is aimed."""

LOWEST, HIGHEST = 0.04, 3.0
"""Heights of jumps that are looked at, in leg lengths."""

OVERRUN = 0.12
"""How far a body may end up beside its feet, in leg lengths."""

MOMENTS = np.linspace(0.0, 1.0, 17)
"""Of each phase of a jump, at which it is looked at."""


@dataclass(frozen=True, eq=False)
class Vault:
    """A jump over a hurdle.

    Attributes:
        leap: how it is to be made.
        speed: at lift-off [m/s].
    """

    leap: Leap
    speed: float


def half_width(of: Pronker) -> float:
    """Return half the width of what passes over a hurdle [m]."""
    widest = float(np.abs(_crouching(of)[:, 2]).max())
    return widest + MARGIN * of.leg


def before(of: Pronker) -> float:
    """Return how far before a body that stands the creature reaches at the height of legs [m]."""
    return _reach(of, 1.0)


def vault(
    of: Pronker,
    state: State,
    ground: Ground,
    hurdle: Hurdle,
    heading: float,
    landings: Sequence[float] = APART,
) -> Vault | str:
    """Return the easiest jump over a hurdle, or why there is none.

    Args:
        of: who jumps.
        state: at the begin of its push.
        ground: that it jumps from and to.
        hurdle: as it is seen from the middle of its body.
        heading: in which it jumps [rad].
        landings: how far behind the hurdle, see `APART`.
    """
    middle = state.now(of).origin[[0, 2]]
    behind = hurdle.far + MARGIN * of.leg + _reach(of, -1.0)
    found, cause = list[Vault](), "it is too long for its legs"
    for extra in landings:
        way = behind + extra * of.leg
        x, z = (middle + way * heading_vector(heading)).tolist()
        best = _lowest(of, state, ground, hurdle, (x, z), heading)
        if isinstance(best, Vault):
            found.append(best)
        elif not found:
            cause = best
    return min(found, key=lambda one: one.speed) if found else cause


def stand_before(
    of: Pronker, state: State, ground: Ground, hurdle: Hurdle, heading: float
) -> tuple[float, Vault] | str:
    """Return from how far before a hurdle it is jumped over most easily [m], and how.

    Args:
        of: who jumps.
        state: crouched, with the hurdle somewhere ahead.
        ground: that it jumps from and to.
        hurdle: as it is seen from the middle of its body.
        heading: to the hurdle [rad].
    """
    nearest = MARGIN * of.leg + before(of)
    found, cause = list[tuple[float, Vault]](), "it is too high for its legs"
    for extra in APART:
        way = nearest + extra * of.leg
        there = moved(of, state, ground, (hurdle.near - way) * heading_vector(heading))
        seen = hurdle.from_here(hurdle.near - way)
        # What is easiest is about as far on either side.
        one = vault(of, there, ground, seen, heading, (extra,))
        if isinstance(one, Vault):
            found.append((way, one))
        elif not found:
            cause = one
    return min(found, key=lambda one: one[1].speed) if found else cause


def moved(of: Pronker, state: State, ground: Ground, by: Array) -> State:
    """Return the state of who is so elsewhere, by (2,) [m]."""
    raised = float(
        ground.height(state.p[0] + by[0], state.p[2] + by[1])
        - ground.height(state.p[0], state.p[2])
    )
    way = np.array([by[0], raised, by[1]])
    return state.elsewhere(way)


def _reach(of: Pronker, side: float) -> float:
    """Return how far ahead (1) or back (-1) a creature reaches that crouches [m]."""
    points = _crouching(of)
    low = points[:, 1] < of.stand - of.crouch
    return float((side * points[low, 0]).max())


def _crouching(of: Pronker) -> Array:
    """Return the points (k, 3) of one that crouches, in its frame [m]."""
    feet = of.rest.copy()
    feet[:, 1] = of.soles - of.crouch
    return np.concatenate([of.silhouette.body, of.silhouette.legs(feet[None])[0]])


def _lowest(
    of: Pronker,
    state: State,
    ground: Ground,
    hurdle: Hurdle,
    spot: tuple[float, float],
    heading: float,
) -> Vault | str:
    """Return the lowest jump to a spot that clears a hurdle, or why there is none."""

    def jump(height: float) -> tuple[Aim, Leap]:
        up = math.sqrt(2.0 * GRAVITY * height)
        leap = Leap(up, heading, spot, folds=True)
        return leaping(of, state, ground, leap, ROUNDS), leap

    def clears(one: Aim) -> bool:
        spare = _spare(of, state, hurdle, one, heading)
        return spare >= 0.0 and not _overruns(of, one)

    low, high = LOWEST * of.leg, HIGHEST * of.leg
    aim, leap = jump(high)
    if not clears(aim):
        return "it is too high or too long for its legs"
    for _ in range(HALVINGS):
        middle = math.sqrt(low * high)
        found = jump(middle)
        if not clears(found[0]):
            low = middle
        else:
            high, (aim, leap) = middle, found
    if _saturates(of, state, aim):
        most = of.most / of.weight
        return f"it is too high or too long for legs that give {most:.3g} body weights each"
    return Vault(leap, float(np.linalg.norm(aim.velocity)))


def _saturates(of: Pronker, state: State, one: Aim) -> bool:
    v0, v1 = (tuple(v.tolist()) for v in (state.v, one.velocity))
    most = of.most * int(state.down.sum())
    return drive(of.mass.mass, most, v0, v1, one.rise).saturated


def _spare(of: Pronker, state: State, hurdle: Hurdle, one: Aim, heading: float) -> float:
    """Return how far all that passes over a hurdle stays above it, less the margin [m]."""
    now, R = state.now(of), np.array(spin.rows(one.attitude))
    _, _, p1 = lift_off(of, state, one.velocity)
    start, lift = now.origin, p1 - R @ of.mass.centre
    t = MOMENTS[:, None] * one.flight
    flight = lift + t * one.velocity
    flight[:, 1] -= 0.5 * GRAVITY * t[:, 0] ** 2
    falls = one.velocity - [0.0, GRAVITY * one.flight, 0.0]
    # Both constant accelerations begin or end at rest.
    rises = start + MOMENTS[:, None] ** 2 * (lift - start)
    way = _sinks(of, one, falls) * falls
    lands = flight[-1] + (2.0 * MOMENTS - MOMENTS**2)[:, None] * 0.5 * way
    origins = np.concatenate([rises, flight, lands])
    stood = np.where(state.down[:, None], state.tips, now.points(of.rest))
    swing = drawn_up(of, (stood - lift) @ R, one.ends, 0.0, one.flight, one.velocity @ R, True)
    aloft = np.array([swing.tips(float(time)) for time in t[:, 0]])
    landed = flight[-1] + one.ends @ R.T
    feet = np.concatenate(
        [(stood - rises[:, None]) @ R, aloft, (landed - lands[:, None]) @ R], axis=0
    )
    body = np.broadcast_to(of.silhouette.body, (len(feet), *of.silhouette.body.shape))
    points = origins[:, None] + np.concatenate([body, of.silhouette.legs(feet)], axis=1) @ R.T
    along = ((points - start)[..., [0, 2]] * heading_vector(heading)).sum(axis=-1)
    return float(hurdle.spare(along, points[..., 1], MARGIN * of.leg).min())


def _sinks(of: Pronker, one: Aim, falls: Array) -> float:
    """Return how long a landing takes [s]."""
    height = float((of.soles - one.ends[:, 1]).mean())
    return 2.0 * max(height - of.crouch, 0.05 * of.leg) / max(-float(falls[1]), 1e-3)


def _overruns(of: Pronker, one: Aim) -> bool:
    """Tell whether a body goes farther while it lands than feet are held out before it."""
    falls = one.velocity - [0.0, GRAVITY * one.flight, 0.0]
    v = one.velocity[[0, 2]]
    ahead = np.linalg.norm((one.ends - of.rest)[:, [0, 2]].mean(axis=0))
    way = 0.5 * _sinks(of, one, falls) * float(np.hypot(*v))
    return bool(way - ahead > OVERRUN * of.leg)
