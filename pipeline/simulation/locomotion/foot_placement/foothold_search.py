"""Foothold search: finds where one foot comes down next.

    1. The foot's neutral position in the middle of its next stance.
    2. If that is forbidden or out of reach: the farthest good place between it and the present
       foothold.
    3. Otherwise: the good place nearest to it on any side.
    4. Otherwise: the same candidates, with the body lowered as far as it may be.

Reach is checked from touchdown until the foot has left the ground again, which the thesis does not
do, and the body's lowering is known a whole swing ahead.

Source: Sims 1987, 10.2, steps 1 and 2.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.curves import ease
from pipeline.simulation.locomotion.foot_placement.leg_reachability import (
    EASY_SWING_HEIGHT,
    LegReachability,
    shortest_reaches,
)
from pipeline.simulation.locomotion.foot_placement.step_batch import (
    STANCE_FRACTIONS,
    Stances,
    StepBatch,
    StepRequest,
    neutral_positions,
)
from pipeline.simulation.locomotion.gaits.pace_schedule import StepTiming
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.routes.body_trajectory import BodyTrajectory
from pipeline.simulation.locomotion.swing.swing_trajectory import (
    clearance_height,
    lowest_standing_height,
    part_of_path,
    quickness,
    swing_positions,
)
from pipeline.simulation.spatial import UP, Array, turn, turn_inverse
from pipeline.simulation.terrain import Ground

# Candidates between the neutral and the present place: fractions of the way back.
RETREAT_FRACTIONS = np.linspace(1.0, 0.0, 49)

# Candidates around the neutral place: rings, spokes, and radius of the outer ring in leg lengths.
RINGS, SPOKES, RING_RADIUS = 24, 16, 0.4

# Greatest lowering of a body for a foothold: fraction of the belly's height, and leg lengths, since
# legs under a lower body would fold too far.
MAX_LOWERING_OF_CLEARANCE, MAX_LOWERING_OF_LEG = 0.9, 0.25

# Least distance of feet from hips under a lowered body, in that at which legs are folded.
FOLD_MARGIN = 1.03

# Candidates checked by inverse kinematics: chunk boundaries (the first is mostly good), and
# greatest number of one kind.
IK_CHUNKS, MAX_IK_CANDIDATES = np.array([1, 9]), 41

# Fractions of a swing at which reach is checked.
SWING_FRACTIONS = np.linspace(0.08, 0.92, 12)

# Greatest height of a swing, in leg lengths: a leg that clears more folds up.
MAX_SWING_HEIGHT = 0.4

# Step heights tried in turn where a leg cannot lift its foot higher, as fractions of the usual one.
STEP_HEIGHT_FRACTIONS = 1.0, 0.6, 0.3

# Length of swings that need no check, in strides.
EASY_LENGTH = 1.25


@dataclass(frozen=True, eq=False)
class Foothold:
    """A place where a foot stands.

    Attributes:
        place: (3,) contact of the sole with the ground [m].
        normal: (3,) of the ground.
        tip: (3,) centre of the leg's tip [m].
        lowering: how far the body has to be lowered for it [m].
        swing_height: of the swing that leads to it [m].
    """

    place: Array
    normal: Array
    tip: Array
    lowering: float
    swing_height: float = 0.0


class FootholdSearch:
    """Searches footholds for single legs of a herd, and holds the geometry that planning shares."""

    def __init__(self, herd: Herd, ground: Ground, trajectory: BodyTrajectory) -> None:
        self.herd, self.ground, self.trajectory = herd, ground, trajectory
        self.reachability = LegReachability(herd, trajectory.surface)

    # --- searches -----------------------------------------------------------------

    def find(self, request: StepRequest, any_swing: bool = False) -> Foothold | None:
        """Return where a foot that lifts comes down, None if no foothold is within reach.

        Args:
            request: the step.
            any_swing: whether a foothold will do to which the leg swings at its limits.
        """
        assert request.present is not None
        leg, present = np.array([request.leg]), request.present
        batch, stance = self._stance(request)
        R, p = stance.R[0], stance.p[0]
        lift = turn_inverse(stance.lift_R, present - stance.lift_p)
        starts_near = bool(self.reachability.near_neutral(leg, lift).all())

        @cache
        def swing_bodies() -> tuple[Array, Array]:
            phases = request.timing.up + request.timing.swing * SWING_FRACTIONS
            R, p = batch.body_poses(self.trajectory, phases[None])
            return R[0], p[0]

        def candidates() -> Iterator[Array]:
            return self._candidates(request.leg, stance.neutral[0], present[[0, 2]])

        def with_swing(hold: Foothold) -> Foothold | None:
            landing = turn_inverse(R[:1], hold.tip - p[:1])
            near = starts_near and bool(self.reachability.near_neutral(leg, landing).all())
            easy = EASY_LENGTH if near else 0.0
            swing_height, faults = self._swing_to(request, hold, swing_bodies, easy)
            if 0.0 < faults < np.inf:
                faulty.append((faults, len(faulty), replace(hold, swing_height=swing_height)))
            if faults > 0.0:
                return None
            return replace(hold, swing_height=swing_height)

        faulty = list[tuple[float, int, Foothold]]()
        best = self._best(request.leg, candidates(), R, p, with_swing, request)
        # On level ground a leg that folds too far on a long swing stays above the ground anyway.
        is_level = self.trajectory.surface.of(int(self.herd.owner[request.leg])).is_level
        if best is None and faulty and (is_level or any_swing):
            return min(faulty)[2] if any_swing else faulty[0][2]
        return best

    def find_initial(self, request: StepRequest) -> Foothold | None:
        """Return where a foot stands at the start: the good place nearest to its neutral one."""
        _, stance = self._stance(request)
        candidates = self._candidates(request.leg, stance.neutral[0])
        return self._best(request.leg, candidates, stance.R[0], stance.p[0])

    def find_ahead(self, request: StepRequest) -> Foothold | None:
        """Return where a foot of a body farther ahead can come down, wherever it lifts."""
        _, stance = self._stance(request)
        owner, up = self.herd.owner[request.leg], np.array(request.timing.up)
        stride = float(self.trajectory.paces.number("stride", owner, up))
        R, p, neutral = stance.R[0], stance.p[0], stance.neutral[0]
        # It lifts about a stride behind.
        behind = neutral - stride * R[len(STANCE_FRACTIONS) // 2, [0, 2], 0]
        return self._best(request.leg, self._candidates(request.leg, neutral, behind), R, p)

    def can_stand_neutral(self, leg: int, distance: float) -> bool:
        """Return whether a foot can stand at its neutral place below a body at rest.

        Args:
            leg: its number.
            distance: that the body has gone [m].
        """
        swing = float(self.herd.swings[leg])
        timing = StepTiming(0.0, swing, 1.0 - swing)
        _, stance = self._stance(StepRequest(leg, distance, 0.0, timing, 0.0))
        return self._best(leg, [stance.neutral], stance.R[0], stance.p[0]) is not None

    # --- geometry -----------------------------------------------------------------

    def neutral_place(self, leg: int, distance: float, phase: float) -> Array:
        """Return the neutral place (2,) of a foot below a body that has gone `distance` [m]."""
        legs, now = np.array([leg]), np.array([phase])
        R, p = self.trajectory.pose(self.herd.owner[legs], np.array([distance]), now)
        return neutral_positions(self.trajectory, legs, now, R, p)[0]

    def tip_positions(self, legs: NDArray[np.int64], xz: Array) -> Array:
        """Return the tips (N, k, 3) of legs (N,) with their soles on the ground at (N, k, 2)."""
        x, z = xz[..., 0], xz[..., 1]
        heights, normals = self.ground.surface(x, z)
        radii = self.herd.foot_radius[legs, None, None]
        return np.stack([x, heights, z], axis=-1) + radii * normals

    def _stance(self, request: StepRequest) -> tuple[StepBatch, Stances]:
        batch = StepBatch.of(self.herd, [request])
        return batch, batch.stances(self.trajectory)

    # --- candidates ---------------------------------------------------------------

    def _candidates(
        self, leg: int, neutral: Array, present: Array | None = None
    ) -> Iterator[Array]:
        """Yield candidate places (n, 2) [m], the best first."""
        # Mostly the first is good and the others are not looked at.
        yield neutral[None]
        if present is not None:
            yield self.retreat(neutral, present)
        yield self.rings(leg, neutral)

    @staticmethod
    def retreat(neutral: Array, present: Array) -> Array:
        """Return places (n, 2) [m] from `neutral` back to the present one (2,)."""
        return present + RETREAT_FRACTIONS[:, None] * (neutral - present)

    def rings(self, leg: int, middle: Array) -> Array:
        """Return places (n, 2) [m] on rings around `middle` (2,), the nearest first."""
        angle = np.arange(SPOKES) * (2.0 * np.pi / SPOKES)
        spokes = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        radii = np.linspace(0.0, RING_RADIUS * self.herd.legs.lengths[leg], RINGS)
        return middle + (radii[:, None, None] * spokes).reshape(-1, 2)

    def _best(
        self,
        leg: int,
        candidates: Iterable[Array],
        R: Array,
        p: Array,
        with_swing: Callable[[Foothold], Foothold | None] = lambda hold: hold,
        request: StepRequest | None = None,
    ) -> Foothold | None:
        """Return the first good foothold; any without lowering comes before one with it.

        Args:
            leg: its number.
            candidates: places (n, 2) each, the best first [m].
            R: (m, 3, 3) and
            p: (m, 3), poses of the body during the stance [m].
            with_swing: adds the swing to a foothold, None where the leg cannot swing there.
            request: the step, if other feet are down already.
        """
        legs, owner, seen = np.array([leg]), int(self.herd.owner[leg]), []
        others, room = (0.0, np.inf) if request is None else (request.lowering[1], request.room)
        for xz in candidates:
            tips = self.tip_positions(legs, xz[None])
            lowering = self.reachability.required_lowering(legs, tips, R[None], p[None])[0]
            owners = np.full(len(xz), owner)
            allowed = self.trajectory.surface.is_allowed(owners, xz[:, 0], xz[:, 1])
            lowering = np.where(allowed, lowering, np.inf)
            good = lowering == 0.0
            for i in self._reached(leg, tips[0], (lowering, others), good, (R, p)):
                hold = with_swing(self._foothold(leg, xz[i], 0.0))
                if hold is not None:
                    return hold
            seen.append((xz, tips[0], lowering))
        clearance = MAX_LOWERING_OF_CLEARANCE * self._belly_clearance(owner, p)
        most = min(clearance, MAX_LOWERING_OF_LEG * float(self.herd.legs.lengths[leg]), room)
        for xz, tips, lowering in seen:
            usable = (lowering > 0.0) & (lowering <= most)
            for i in self._reached(leg, tips, (lowering, others), usable, (R, p)):
                hold = with_swing(self._foothold(leg, xz[i], float(lowering[i])))
                if hold is not None:
                    return hold
        return None

    def lowering_room(self, legs: NDArray[np.int64], ends: Array, R: Array, p: Array) -> float:
        """Return how far a body can be lowered until a leg folds too far [m].

        Args:
            legs: (n,) whose feet stand, or come down soon.
            ends: (n, 3) where [m].
            R: (3, 3) orientation of the body.
            p: (3,) place of the body [m].
        """
        offset = ends - (p + turn(R, self.herd.hips[legs]))
        # Feet that are before or behind their hips will come under them, or were there.
        aside = offset @ R[:, 2]
        least = np.sqrt(np.maximum(self._shortest[legs] ** 2 - aside**2, 0.0))
        return max(float((-offset[:, 1] - least).min(initial=np.inf)), 0.0)

    @cached_property
    def _shortest(self) -> Array:
        return FOLD_MARGIN * shortest_reaches(self.herd)

    def _belly_clearance(self, c: int, p: Array) -> float:
        """Return how far a body at all positions p (m, 3) can sink until its belly is down [m]."""
        above = (p[:, 1] - self.ground.height(p[:, 0], p[:, 2])).min()
        return max(float(max(self.herd.body_height[c], above) - self.herd.belly[c]), 0.0)

    def _reached(
        self,
        leg: int,
        tips: Array,
        lowering: tuple[Array, float],
        usable: NDArray[np.bool_],
        bodies: tuple[Array, Array],
    ) -> Iterator[int]:
        """Yield the usable tips (n, 3) that the joints reach; of many, a regular sample.

        Args:
            leg: its number.
            tips: [m].
            lowering: of the body for them (n,), and for its other feet, which may end [m].
            usable: (n,) which of them.
            bodies: orientations (m, 3, 3) and places (m, 3) during the stance [m].
        """
        (own, others), (R, p) = lowering, bodies
        lowest = (own**4 + others**4) ** 0.25
        numbers = np.flatnonzero(usable)
        if len(numbers) > MAX_IK_CANDIDATES:
            sample = np.linspace(0, len(numbers) - 1, MAX_IK_CANDIDATES).astype(np.int64)
            numbers = numbers[sample]
        for chunk in np.split(numbers, IK_CHUNKS[IK_CHUNKS < len(numbers)]):
            if len(chunk):
                reached = np.ones(len(chunk), dtype=bool)
                for low in (own, lowest) if others else (own,):
                    lowered = p - np.multiply.outer(low[chunk], UP)[:, None]
                    goals = turn_inverse(R, tips[chunk, None] - lowered)
                    legs = np.full(len(chunk), leg)
                    reached &= self.reachability.reaches(legs, goals).all(axis=-1)
                yield from chunk[reached].tolist()

    def _foothold(self, leg: int, xz: Array, lowering: float) -> Foothold:
        """Return the foothold at `xz` (2,), its sole clear of the slopes beside it."""
        x, z = xz
        height, normal = self.ground.surface(x, z)
        place = np.array([float(x), float(height), float(z)])
        foot_radius = float(self.herd.foot_radius[leg])
        tip = place + foot_radius * normal
        tip[1] = max(
            tip[1], float(lowest_standing_height(self.ground, tip[:1], tip[2:], foot_radius)[0])
        )
        return Foothold(place, normal, tip, lowering)

    # --- the swing to a foothold ----------------------------------------------------

    def _swing_to(
        self,
        request: StepRequest,
        hold: Foothold,
        bodies: Callable[[], tuple[Array, Array]],
        easy_length: float,
    ) -> tuple[float, float]:
        """Return the height of the swing to a foothold [m], and its faults, 0 if the leg can do it.

        Args:
            request: the step.
            hold: where it ends.
            bodies: returns R_WB (n, 3, 3) and p_WB (n, 3) during the swing [m].
            easy_length: of swings that need no check, in strides.
        """
        leg, present = request.leg, request.present
        assert present is not None
        foot_radius, owner = float(self.herd.foot_radius[leg]), int(self.herd.owner[leg])
        step_height, stride = (
            float(self.trajectory.paces.number(name, owner, np.array(request.timing.up)))
            for name in ("step_height", "stride")
        )
        swing_height = clearance_height(self.ground, present, hold.tip, foot_radius, step_height)
        if swing_height > MAX_SWING_HEIGHT * float(self.herd.legs.lengths[leg]):
            return swing_height, np.inf
        across = hold.tip - present
        is_easy = swing_height < EASY_SWING_HEIGHT * step_height and abs(across[1]) < step_height
        is_easy = is_easy and self.reachability.can_lift(leg, step_height)
        # Under a lowered body legs are folded already.
        is_easy = is_easy and max(*request.lowering, hold.lowering) <= 0.0
        if is_easy and np.hypot(across[0], across[2]) <= easy_length * stride:
            return swing_height, 0.0
        n, (R, p) = len(SWING_FRACTIONS), bodies()
        lowering = _swing_lowering(request.lowering, hold.lowering)
        ends, faults = (np.tile(present, (n, 1)), np.tile(hold.tip, (n, 1))), np.inf
        for fraction in STEP_HEIGHT_FRACTIONS:
            if fraction < 1.0:
                height = fraction * step_height
                lower = clearance_height(self.ground, present, hold.tip, foot_radius, height)
                if lower > 0.99 * swing_height:
                    break
                swing_height = lower
            parts = part_of_path(SWING_FRACTIONS, request.timing.swing)
            path = swing_positions(*ends, np.full(n, swing_height), parts)
            paths = turn_inverse(R, path - (p - np.multiply.outer(lowering, UP)))
            legs = np.full(len(paths), leg)
            if quickness(np.array(request.timing.swing)) > 0.0:
                paths = self.reachability.within_reach(legs, paths)
            faults = float(self.reachability.swing_faults(legs, paths).max())
            if faults == 0.0:
                break
        return swing_height, faults


def _swing_lowering(present: tuple[float, float], following: float) -> Array:
    """Return by how much the body may be lowered during a swing, in every case (k, n) [m].

    Args:
        present: for the foot's present place, and for the other feet [m].
        following: for its next place [m].
    """
    if max(following, *present) <= 0.0:
        return np.zeros((1, len(SWING_FRACTIONS)))
    # The other feet may cease to need a low body before this swing, or after it.
    own = present[0] + ease(SWING_FRACTIONS) * (following - present[0])
    return np.stack([own, np.sqrt(np.hypot(own**2, present[1] ** 2))])
