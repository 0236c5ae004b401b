"""Jumps over hurdles: the side profile of a hurdle, and the easiest jump that clears it.

Candidate jumps land at several distances behind the hurdle. Each is as low as the clearance of
body outline and feet allows, from push-off to landing; the one with the lowest speed is taken.

Source: Sims 1987, 3.2.4 and 11.1 to 11.3.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.locomotion.pronking.flight_swing import flight_swing, trunk_pitch
from pipeline.simulation.locomotion.pronking.hop_state import HopState, PlannedJump, available_force
from pipeline.simulation.locomotion.pronking.hopper import Hopper
from pipeline.simulation.locomotion.pronking.jump_planner import (
    JumpPlan,
    lift_off_point,
    plan_requested_jump,
)
from pipeline.simulation.locomotion.pronking.leg_forces import ZERO_VECTOR, phase_force
from pipeline.simulation.locomotion.routes.route import heading_vector
from pipeline.simulation.scalar_rotation import rotation_matrix, vector_tuple
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground

CLEARANCE = 0.08
"""Distance between a hurdle and all that passes over it, in leg lengths."""


@dataclass(frozen=True, slots=True)
class VaultSearch:
    """Constants of the search for the lowest jump over a hurdle, distances in leg lengths.

    Attributes:
        standoffs: extra distances before and behind a hurdle tried for take-off and landing.
        min_height, max_height: range of jump heights.
        halvings: of that range.
        plan_iterations: planning iterations of each jump.
        phase_samples: points of each phase at which the clearance is checked.
        max_overrun: how far a body may end up beyond its feet after a landing.
    """

    standoffs: tuple[float, ...] = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 1.2)
    min_height: float = 0.04
    max_height: float = 3.0
    halvings: int = 6
    plan_iterations: int = 4
    phase_samples: int = 17
    max_overrun: float = 0.12


@dataclass(frozen=True, slots=True)
class ProfileSampling:
    """Constants of the profile of a hurdle.

    Attributes:
        samples: number of samples along a profile.
        decimals: of the distances along a profile: they keep upright sides upright.
        empty_height: height outside of a solid [m].
    """

    samples: int = 49
    decimals: int = 10
    empty_height: float = -1e6


VAULT_SEARCH, PROFILE_SAMPLING = VaultSearch(), ProfileSampling()


@dataclass(frozen=True, eq=False)
class Vault:
    """A jump over a hurdle.

    Attributes:
        planned: how it is made.
        speed: at lift-off [m/s].
    """

    planned: PlannedJump
    speed: float


def clearance_half_width(hopper: Hopper) -> float:
    """Return half the width of the strip that a hopper sweeps over a hurdle [m]."""
    widest = float(np.abs(_crouched_outline(hopper)[:, 2]).max())
    return widest + CLEARANCE * hopper.leg_length


def front_reach(hopper: Hopper) -> float:
    """Return how far a crouching creature extends ahead of its middle at leg height [m]."""
    return _reach(hopper, 1.0)


def plan_vault(
    hopper: Hopper,
    state: HopState,
    ground: Ground,
    hurdle: HurdleProfile,
    heading: float,
    landings: Sequence[float] = VAULT_SEARCH.standoffs,
) -> Vault | str:
    """Return the easiest jump over a hurdle, or the reason why there is none.

    Args:
        hopper: the creature.
        state: at the start of the push.
        ground: that it jumps from and to.
        hurdle: seen from the middle of the body.
        heading: of the jump [rad].
        landings: extra distances behind the hurdle, see `VaultSearch`.
    """
    middle = state.body(hopper).origin[[0, 2]]
    behind = hurdle.far + CLEARANCE * hopper.leg_length + _reach(hopper, -1.0)
    vaults, reason = list[Vault](), "it is too long for its legs"
    for extra in landings:
        distance = behind + extra * hopper.leg_length
        x, z = (middle + distance * heading_vector(heading)).tolist()
        vault = _lowest_vault(hopper, state, ground, hurdle, (x, z), heading)
        if isinstance(vault, Vault):
            vaults.append(vault)
        elif not vaults:
            reason = vault
    return min(vaults, key=lambda vault: vault.speed) if vaults else reason


def plan_take_off(
    hopper: Hopper, state: HopState, ground: Ground, hurdle: HurdleProfile, heading: float
) -> tuple[float, Vault] | str:
    """Return the easiest distance before a hurdle to jump from [m], and the jump; or a reason.

    Args:
        hopper: the creature.
        state: crouched, with the hurdle somewhere ahead.
        ground: that it jumps from and to.
        hurdle: seen from the middle of the body.
        heading: to the hurdle [rad].
    """
    nearest = CLEARANCE * hopper.leg_length + front_reach(hopper)
    candidates, reason = list[tuple[float, Vault]](), "it is too high for its legs"
    for extra in VAULT_SEARCH.standoffs:
        distance = nearest + extra * hopper.leg_length
        state_there = shifted_state(
            hopper, state, ground, (hurdle.near - distance) * heading_vector(heading)
        )
        seen = hurdle.seen_from(hurdle.near - distance)
        # The easiest jump is nearly symmetric about the hurdle.
        vault = plan_vault(hopper, state_there, ground, seen, heading, (extra,))
        if isinstance(vault, Vault):
            candidates.append((distance, vault))
        elif not candidates:
            reason = vault
    return min(candidates, key=lambda candidate: candidate[1].speed) if candidates else reason


def shifted_state(hopper: Hopper, state: HopState, ground: Ground, offset: Array) -> HopState:
    """Return the state moved by (x, z) over the ground [m]."""
    raised = float(
        ground.height(state.p[0] + offset[0], state.p[2] + offset[1])
        - ground.height(state.p[0], state.p[2])
    )
    shift = np.array([offset[0], raised, offset[1]])
    return state.shifted(shift)


def _reach(hopper: Hopper, side: float) -> float:
    """Return how far a crouching creature extends ahead (1) or back (-1) at leg height [m]."""
    points = _crouched_outline(hopper)
    low = points[:, 1] < hopper.standing_height - hopper.crouch_height
    return float((side * points[low, 0]).max())


def _crouched_outline(hopper: Hopper) -> Array:
    """Return the outline points (k, 3) of the crouching creature, in its frame [m]."""
    feet = hopper.rest_feet.copy()
    feet[:, 1] = hopper.foot_radii - hopper.crouch_height
    return np.concatenate([hopper.outline.body, hopper.outline.legs(feet[None])[0]])


def _lowest_vault(
    hopper: Hopper,
    state: HopState,
    ground: Ground,
    hurdle: HurdleProfile,
    target: tuple[float, float],
    heading: float,
) -> Vault | str:
    """Return the lowest jump to a target that clears a hurdle, or the reason why there is none."""

    def jump(height: float) -> tuple[JumpPlan, PlannedJump]:
        up = math.sqrt(2.0 * GRAVITY * height)
        planned = PlannedJump(up, heading, target, fold_legs=True)
        iterations = VAULT_SEARCH.plan_iterations
        return plan_requested_jump(hopper, state, ground, planned, iterations), planned

    def clears(candidate: JumpPlan) -> bool:
        spare = _clearance(hopper, state, hurdle, candidate, heading)
        return spare >= 0.0 and not _is_overrunning(hopper, candidate)

    low = VAULT_SEARCH.min_height * hopper.leg_length
    high = VAULT_SEARCH.max_height * hopper.leg_length
    plan, planned = jump(high)
    if not clears(plan):
        return "it is too high or too long for its legs"
    for _ in range(VAULT_SEARCH.halvings):
        middle = math.sqrt(low * high)
        found = jump(middle)
        if not clears(found[0]):
            low = middle
        else:
            high, (plan, planned) = middle, found
    if _saturates(hopper, state, plan):
        force = hopper.max_leg_force / hopper.weight
        return f"it is too high or too long for legs that give {force:.3g} body weights each"
    return Vault(planned, float(np.linalg.norm(plan.velocity)))


def _saturates(hopper: Hopper, state: HopState, plan: JumpPlan) -> bool:
    v0, v1 = vector_tuple(state.v), vector_tuple(plan.velocity)
    max_force = available_force(hopper, state)
    return phase_force(hopper.mass.mass, max_force, v0, v1, plan.rise).saturated


def _clearance(
    hopper: Hopper, state: HopState, hurdle: HurdleProfile, plan: JumpPlan, heading: float
) -> float:
    """Return the least height of all outline points above a hurdle, less the margin [m]."""
    now, R = state.body(hopper), rotation_matrix(plan.attitude)
    _, _, p1 = lift_off_point(hopper, state, plan.velocity)
    start, lift_off_origin = now.origin, p1 - R @ hopper.mass.centre
    moments = np.linspace(0.0, 1.0, VAULT_SEARCH.phase_samples)
    t = moments[:, None] * plan.flight_time
    centres = p1 + t * plan.velocity
    centres[:, 1] -= 0.5 * GRAVITY * t[:, 0] ** 2
    landing_velocity = plan.velocity - [0.0, GRAVITY * plan.flight_time, 0.0]
    planted_feet = np.where(state.down[:, None], state.tips, now.to_world(hopper.rest_feet))
    own_velocity = plan.velocity @ R
    swing = flight_swing(
        hopper,
        (planted_feet - lift_off_origin) @ R,
        plan.landing_feet,
        0.0,
        plan.flight_time,
        own_velocity,
        True,
    )
    pitch, level = trunk_pitch(hopper, swing, own_velocity), (plan.attitude, ZERO_VECTOR)
    R_air = np.array([rotation_matrix(pitch.turned(level, float(time))[0]) for time in t[:, 0]])
    flight = centres - R_air @ hopper.mass.centre
    # The constant accelerations of push and landing start and end at rest.
    push_origins = start + moments[:, None] ** 2 * (lift_off_origin - start)
    landing_travel = _landing_time(hopper, plan, landing_velocity) * landing_velocity
    landed = centres[-1] - R @ hopper.mass.centre
    landing_origins = landed + (2.0 * moments - moments**2)[:, None] * 0.5 * landing_travel
    origins = np.concatenate([push_origins, flight, landing_origins])
    air_feet = np.array([swing.tips(float(time)) for time in t[:, 0]])
    landed_feet = landed + plan.landing_feet @ R.T
    feet = np.concatenate(
        [
            (planted_feet - push_origins[:, None]) @ R,
            air_feet,
            (landed_feet - landing_origins[:, None]) @ R,
        ],
        axis=0,
    )
    steady = np.broadcast_to(R, R_air.shape)
    body = np.broadcast_to(hopper.outline.body, (len(feet), *hopper.outline.body.shape))
    points = np.concatenate([body, hopper.outline.legs(feet)], axis=1)
    points = points @ np.concatenate([steady, R_air, steady]).transpose(0, 2, 1)
    points += origins[:, None]
    along = ((points - start)[..., [0, 2]] * heading_vector(heading)).sum(axis=-1)
    return float(hurdle.spare(along, points[..., 1], CLEARANCE * hopper.leg_length).min())


def _landing_time(hopper: Hopper, plan: JumpPlan, velocity: Array) -> float:
    """Return the duration of a landing [s]."""
    height = float((hopper.foot_radii - plan.landing_feet[:, 1]).mean())
    return (
        2.0
        * max(height - hopper.crouch_height, 0.05 * hopper.leg_length)
        / max(-float(velocity[1]), 1e-3)
    )


def _is_overrunning(hopper: Hopper, plan: JumpPlan) -> bool:
    """Return whether the body travels farther during the landing than its feet are held ahead."""
    landing_velocity = plan.velocity - [0.0, GRAVITY * plan.flight_time, 0.0]
    v = plan.velocity[[0, 2]]
    ahead = np.linalg.norm((plan.landing_feet - hopper.rest_feet)[:, [0, 2]].mean(axis=0))
    travel = 0.5 * _landing_time(hopper, plan, landing_velocity) * float(np.hypot(*v))
    return bool(travel - ahead > VAULT_SEARCH.max_overrun * hopper.leg_length)


@dataclass(frozen=True, eq=False)
class HurdleProfile:
    """The side profile of solids within the strip that a body sweeps.

    Attributes:
        along: (k,) ascending distances ahead of the viewpoint [m].
        top: (k,) greatest heights at these, in the world [m].
    """

    along: Array
    top: Array

    @property
    def near(self) -> float:
        """Distance to the near end [m]."""
        return float(self.along[0])

    @property
    def far(self) -> float:
        """Distance to the far end [m]."""
        return float(self.along[-1])

    def seen_from(self, way: float) -> HurdleProfile:
        """Return the profile as seen from `distance` farther ahead [m]."""
        return HurdleProfile(self.along - way, self.top)

    def spare(self, along: Array, height: Array, margin: float) -> Array:
        """Return the height of points above the profile, infinite beside it [m].

        Args:
            along: distances of the points, any shape [m].
            height: heights of the points, same shape [m].
            margin: added before, behind and above the profile [m].
        """
        over = (along >= self.near - margin) & (along <= self.far + margin)
        top = np.interp(along, self.along, self.top)
        return np.where(over, height - top - margin, np.inf)


def hurdle_profile(
    solids: Sequence[Array], place: Array, heading: float, half_width: float
) -> HurdleProfile | None:
    """Return the profile of convex solids in a strip; None if none is in it.

    Args:
        solids: their corners (n, 3) in the world [m].
        place: (x, z) viewpoint, in the middle of the strip [m].
        heading: of the strip [rad].
        half_width: of the strip [m].
    """
    ahead = heading_vector(heading)
    # In (x, z), forward is (c, -s) and right is (s, c).
    right = np.array([-ahead[1], ahead[0]])
    outlines = [_clip_to_strip(corners, place, ahead, right, half_width) for corners in solids]
    outlines = [points for points in outlines if len(points) > 1 and np.ptp(points[:, 0]) > 0.0]
    if not outlines:
        return None
    first = min(float(points[:, 0].min()) for points in outlines)
    last = max(float(points[:, 0].max()) for points in outlines)
    along = np.linspace(first, last, PROFILE_SAMPLING.samples)
    tops = [_upper_hull(points, along) for points in outlines]
    return HurdleProfile(along, np.max(tops, axis=0))


def _clip_to_strip(corners: Array, place: Array, ahead: Array, right: Array, half: float) -> Array:
    """Return points (m, 2), distance and height, whose hull is the side view within a strip."""
    over = corners[:, [0, 2]] - place
    s, w, y = (over * ahead).sum(axis=-1), (over * right).sum(axis=-1), corners[:, 1]
    inside = np.abs(w) <= half
    found = [np.stack([s[inside], y[inside]], axis=-1)]
    # A convex solid contains all lines between its corners; those leaving the strip are cut.
    i, j = np.triu_indices(len(corners), 1)
    for edge in (-half, half):
        cuts = (w[i] - edge) * (w[j] - edge) < 0.0
        a, b = i[cuts], j[cuts]
        u = (edge - w[a]) / (w[b] - w[a])
        found.append(np.stack([s[a] + u * (s[b] - s[a]), y[a] + u * (y[b] - y[a])], axis=-1))
    result = np.concatenate(found)
    # Rounding must not tilt upright sides.
    result[:, 0] = np.round(result[:, 0], PROFILE_SAMPLING.decimals)
    return result


def _upper_hull(points: Array, along: Array) -> Array:
    """Return the heights (k,) of the upper hull of points (m, 2) at distances (k,) [m]."""
    order = np.lexsort((points[:, 1], points[:, 0]))
    upper = list[Array]()
    for point in points[order]:
        if upper and upper[-1][0] == point[0]:
            upper.pop()
        while len(upper) > 1 and _turns_left(upper[-2], upper[-1], point):
            upper.pop()
        upper.append(point)
    s, y = np.array(upper).T
    empty = PROFILE_SAMPLING.empty_height
    return np.interp(along, s, y, left=empty, right=empty)


def _turns_left(a: Array, b: Array, c: Array) -> bool:
    return bool((b[0] - a[0]) * (c[1] - a[1]) >= (b[1] - a[1]) * (c[0] - a[0]))
