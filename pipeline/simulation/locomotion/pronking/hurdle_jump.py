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
from pipeline.simulation.locomotion.pronking.foot_contact import flight_swing
from pipeline.simulation.locomotion.pronking.hop_state import HopState, PlannedJump
from pipeline.simulation.locomotion.pronking.hopper import Hopper
from pipeline.simulation.locomotion.pronking.jump_planner import (
    JumpPlan,
    lift_off_point,
    plan_requested_jump,
)
from pipeline.simulation.locomotion.pronking.leg_forces import phase_force
from pipeline.simulation.locomotion.routes.route import heading_vector
from pipeline.simulation.scalar_rotation import matrix_rows
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground

CLEARANCE = 0.08
"""Between a hurdle and what passes over it, in leg lengths."""

STANDOFFS = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 1.2)
"""How far before a hurdle jumps are made from, and how far behind it they land, beside what is
needed, in leg lengths."""

HEIGHT_HALVINGS, VAULT_ITERATIONS = 6, 4
"""In which the lowest jump is found, and each comes about to where it is aimed."""

MIN_HEIGHT, MAX_HEIGHT = 0.04, 3.0
"""Heights of jumps that are looked at, in leg lengths."""

MAX_OVERRUN = 0.12
"""How far a body may end up beside its feet, in leg lengths."""

PHASE_SAMPLES = np.linspace(0.0, 1.0, 17)
"""Of each phase of a jump, at which it is looked at."""


@dataclass(frozen=True, eq=False)
class Vault:
    """A jump over a hurdle.

    Attributes:
        leap: how it is to be made.
        speed: at lift-off [m/s].
    """

    leap: PlannedJump
    speed: float


def clearance_half_width(of: Hopper) -> float:
    """Return half the width of what passes over a hurdle [m]."""
    widest = float(np.abs(_crouched_outline(of)[:, 2]).max())
    return widest + CLEARANCE * of.leg


def front_reach(of: Hopper) -> float:
    """Return how far before a body that stands the creature reaches at the height of legs [m]."""
    return _reach(of, 1.0)


def plan_vault(
    of: Hopper,
    state: HopState,
    ground: Ground,
    hurdle: HurdleProfile,
    heading: float,
    landings: Sequence[float] = STANDOFFS,
) -> Vault | str:
    """Return the easiest jump over a hurdle, or why there is none.

    Args:
        of: who jumps.
        state: at the begin of its push.
        ground: that it jumps from and to.
        hurdle: as it is seen from the middle of its body.
        heading: in which it jumps [rad].
        landings: how far behind the hurdle, see `STANDOFFS`.
    """
    middle = state.now(of).origin[[0, 2]]
    behind = hurdle.far + CLEARANCE * of.leg + _reach(of, -1.0)
    found, cause = list[Vault](), "it is too long for its legs"
    for extra in landings:
        way = behind + extra * of.leg
        x, z = (middle + way * heading_vector(heading)).tolist()
        best = _lowest_vault(of, state, ground, hurdle, (x, z), heading)
        if isinstance(best, Vault):
            found.append(best)
        elif not found:
            cause = best
    return min(found, key=lambda one: one.speed) if found else cause


def plan_take_off(
    of: Hopper, state: HopState, ground: Ground, hurdle: HurdleProfile, heading: float
) -> tuple[float, Vault] | str:
    """Return from how far before a hurdle it is jumped over most easily [m], and how.

    Args:
        of: who jumps.
        state: crouched, with the hurdle somewhere ahead.
        ground: that it jumps from and to.
        hurdle: as it is seen from the middle of its body.
        heading: to the hurdle [rad].
    """
    nearest = CLEARANCE * of.leg + front_reach(of)
    found, cause = list[tuple[float, Vault]](), "it is too high for its legs"
    for extra in STANDOFFS:
        way = nearest + extra * of.leg
        there = shifted_state(of, state, ground, (hurdle.near - way) * heading_vector(heading))
        seen = hurdle.from_here(hurdle.near - way)
        # What is easiest is about as far on either side.
        one = plan_vault(of, there, ground, seen, heading, (extra,))
        if isinstance(one, Vault):
            found.append((way, one))
        elif not found:
            cause = one
    return min(found, key=lambda one: one[1].speed) if found else cause


def shifted_state(of: Hopper, state: HopState, ground: Ground, by: Array) -> HopState:
    """Return the state of who is so elsewhere, by (2,) [m]."""
    raised = float(
        ground.height(state.p[0] + by[0], state.p[2] + by[1])
        - ground.height(state.p[0], state.p[2])
    )
    way = np.array([by[0], raised, by[1]])
    return state.elsewhere(way)


def _reach(of: Hopper, side: float) -> float:
    """Return how far ahead (1) or back (-1) a creature reaches that crouches [m]."""
    points = _crouched_outline(of)
    low = points[:, 1] < of.stand - of.crouch
    return float((side * points[low, 0]).max())


def _crouched_outline(of: Hopper) -> Array:
    """Return the points (k, 3) of one that crouches, in its frame [m]."""
    feet = of.rest.copy()
    feet[:, 1] = of.soles - of.crouch
    return np.concatenate([of.silhouette.body, of.silhouette.legs(feet[None])[0]])


def _lowest_vault(
    of: Hopper,
    state: HopState,
    ground: Ground,
    hurdle: HurdleProfile,
    spot: tuple[float, float],
    heading: float,
) -> Vault | str:
    """Return the lowest jump to a spot that clears a hurdle, or why there is none."""

    def jump(height: float) -> tuple[JumpPlan, PlannedJump]:
        up = math.sqrt(2.0 * GRAVITY * height)
        leap = PlannedJump(up, heading, spot, folds=True)
        return plan_requested_jump(of, state, ground, leap, VAULT_ITERATIONS), leap

    def clears(one: JumpPlan) -> bool:
        spare = _clearance(of, state, hurdle, one, heading)
        return spare >= 0.0 and not _is_overrunning(of, one)

    low, high = MIN_HEIGHT * of.leg, MAX_HEIGHT * of.leg
    aim, leap = jump(high)
    if not clears(aim):
        return "it is too high or too long for its legs"
    for _ in range(HEIGHT_HALVINGS):
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


def _saturates(of: Hopper, state: HopState, one: JumpPlan) -> bool:
    v0, v1 = (tuple(v.tolist()) for v in (state.v, one.velocity))
    most = of.most * int(state.down.sum())
    return phase_force(of.mass.mass, most, v0, v1, one.rise).saturated


def _clearance(
    of: Hopper, state: HopState, hurdle: HurdleProfile, one: JumpPlan, heading: float
) -> float:
    """Return how far all that passes over a hurdle stays above it, less the margin [m]."""
    now, R = state.now(of), np.array(matrix_rows(one.attitude))
    _, _, p1 = lift_off_point(of, state, one.velocity)
    start, lift = now.origin, p1 - R @ of.mass.centre
    t = PHASE_SAMPLES[:, None] * one.flight
    flight = lift + t * one.velocity
    flight[:, 1] -= 0.5 * GRAVITY * t[:, 0] ** 2
    falls = one.velocity - [0.0, GRAVITY * one.flight, 0.0]
    # Both constant accelerations begin or end at rest.
    rises = start + PHASE_SAMPLES[:, None] ** 2 * (lift - start)
    way = _landing_time(of, one, falls) * falls
    lands = flight[-1] + (2.0 * PHASE_SAMPLES - PHASE_SAMPLES**2)[:, None] * 0.5 * way
    origins = np.concatenate([rises, flight, lands])
    stood = np.where(state.down[:, None], state.tips, now.points(of.rest))
    swing = flight_swing(of, (stood - lift) @ R, one.ends, 0.0, one.flight, one.velocity @ R, True)
    aloft = np.array([swing.tips(float(time)) for time in t[:, 0]])
    landed = flight[-1] + one.ends @ R.T
    feet = np.concatenate(
        [(stood - rises[:, None]) @ R, aloft, (landed - lands[:, None]) @ R], axis=0
    )
    body = np.broadcast_to(of.silhouette.body, (len(feet), *of.silhouette.body.shape))
    points = origins[:, None] + np.concatenate([body, of.silhouette.legs(feet)], axis=1) @ R.T
    along = ((points - start)[..., [0, 2]] * heading_vector(heading)).sum(axis=-1)
    return float(hurdle.spare(along, points[..., 1], CLEARANCE * of.leg).min())


def _landing_time(of: Hopper, one: JumpPlan, falls: Array) -> float:
    """Return how long a landing takes [s]."""
    height = float((of.soles - one.ends[:, 1]).mean())
    return 2.0 * max(height - of.crouch, 0.05 * of.leg) / max(-float(falls[1]), 1e-3)


def _is_overrunning(of: Hopper, one: JumpPlan) -> bool:
    """Tell whether a body goes farther while it lands than feet are held out before it."""
    falls = one.velocity - [0.0, GRAVITY * one.flight, 0.0]
    v = one.velocity[[0, 2]]
    ahead = np.linalg.norm((one.ends - of.rest)[:, [0, 2]].mean(axis=0))
    way = 0.5 * _landing_time(of, one, falls) * float(np.hypot(*v))
    return bool(way - ahead > MAX_OVERRUN * of.leg)


PROFILE_SAMPLES = 49
"""Places along the way at which its height is known."""

PROFILE_DECIMALS = 10
"""Decimals of ways along it."""

EMPTY_HEIGHT = -1e6
"""Height of what is not there [m]."""


@dataclass(frozen=True, eq=False)
class HurdleProfile:
    """The outline of solids in the strip over which a body comes.

    Attributes:
        along: (k,) ways from where it is looked at, ascending [m].
        top: (k,) the greatest heights there, in the world [m].
    """

    along: Array
    top: Array

    @property
    def near(self) -> float:
        """Way to where it begins [m]."""
        return float(self.along[0])

    @property
    def far(self) -> float:
        """Way to where it ends [m]."""
        return float(self.along[-1])

    @property
    def highest(self) -> float:
        """[m]."""
        return float(self.top.max())

    def from_here(self, way: float) -> HurdleProfile:
        """Return it as it is seen from farther along the way [m]."""
        return HurdleProfile(self.along - way, self.top)

    def spare(self, along: Array, height: Array, margin: float) -> Array:
        """Return how far points are above it, infinite where they are neither over it nor near.

        Args:
            along: of any shape, ways of the points [m].
            height: of the same shape [m].
            margin: how far before and behind it counts, and above it [m].
        """
        over = (along >= self.near - margin) & (along <= self.far + margin)
        top = np.interp(along, self.along, self.top)
        return np.where(over, height - top - margin, np.inf)


def hurdle_profile(
    solids: Sequence[Array], place: Array, heading: float, half_width: float
) -> HurdleProfile | None:
    """Return what of convex solids is in a strip, None if nothing is.

    Args:
        solids: their corners (n, 3) in the world [m].
        place: (x, z) in the middle of the strip, from which ways count [m].
        heading: of the strip [rad].
        half_width: of the strip [m].
    """
    ahead = heading_vector(heading)
    # Forward is (c, -s) and to the right (s, c) in x and z.
    right = np.array([-ahead[1], ahead[0]])
    outlines = [_clip_to_strip(corners, place, ahead, right, half_width) for corners in solids]
    outlines = [one for one in outlines if len(one) > 1 and np.ptp(one[:, 0]) > 0.0]
    if not outlines:
        return None
    first = min(float(one[:, 0].min()) for one in outlines)
    last = max(float(one[:, 0].max()) for one in outlines)
    along = np.linspace(first, last, PROFILE_SAMPLES)
    tops = [_upper_hull(one, along) for one in outlines]
    return HurdleProfile(along, np.max(tops, axis=0))


def _clip_to_strip(corners: Array, place: Array, ahead: Array, right: Array, half: float) -> Array:
    """Return points (m, 2), way and height, whose hull is the side view of what is in a strip."""
    over = corners[:, [0, 2]] - place
    s, w, y = (over * ahead).sum(axis=-1), (over * right).sum(axis=-1), corners[:, 1]
    inside = np.abs(w) <= half
    found = [np.stack([s[inside], y[inside]], axis=-1)]
    # A convex solid has all lines between its corners: those that leave the strip are cut.
    i, j = np.triu_indices(len(corners), 1)
    for edge in (-half, half):
        cuts = (w[i] - edge) * (w[j] - edge) < 0.0
        a, b = i[cuts], j[cuts]
        u = (edge - w[a]) / (w[b] - w[a])
        found.append(np.stack([s[a] + u * (s[b] - s[a]), y[a] + u * (y[b] - y[a])], axis=-1))
    result = np.concatenate(found)
    # Upright sides are so in spite of rounding.
    result[:, 0] = np.round(result[:, 0], PROFILE_DECIMALS)
    return result


def _upper_hull(points: Array, along: Array) -> Array:
    """Return the upper side (k,) of the hull of points (m, 2) at ways (k,) [m]."""
    order = np.lexsort((points[:, 1], points[:, 0]))
    upper = list[Array]()
    for point in points[order]:
        if upper and upper[-1][0] == point[0]:
            upper.pop()
        while len(upper) > 1 and _turns_left(upper[-2], upper[-1], point):
            upper.pop()
        upper.append(point)
    s, y = np.array(upper).T
    result: Array = np.interp(along, s, y, left=EMPTY_HEIGHT, right=EMPTY_HEIGHT)
    return result


def _turns_left(a: Array, b: Array, c: Array) -> bool:
    return bool((b[0] - a[0]) * (c[1] - a[1]) >= (b[1] - a[1]) * (c[0] - a[0]))
