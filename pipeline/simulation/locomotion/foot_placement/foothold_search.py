"""Footholds: where a foot is put next.

    1. The place where the foot would rest in the middle of its next stance.
    2. If that is forbidden or out of reach, the farthest good place that is nearer.
    3. If there is none, the good place nearest to the wished one on any side of it.
    4. If there is none, the same again with the body as low as it may be.

Sims 1987, 10.2, steps 1 and 2. The thesis leaves reach to chance; here it is checked
from the foot's coming down until it has left the ground again, and how far the body
has to stoop is known a whole swing before.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.curves import ease
from pipeline.simulation.locomotion.foot_placement.leg_reachability import LegReachability
from pipeline.simulation.locomotion.gaits.gait_transition import StepTiming
from pipeline.simulation.locomotion.gaits.spread import MAX_REACH
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.routes.body_trajectory import BodyTrajectory
from pipeline.simulation.locomotion.routes.braking import braked
from pipeline.simulation.locomotion.swing.swing_trajectory import (
    clearance_height,
    lowest_center_height,
    swing_positions,
)
from pipeline.simulation.spatial import Array, turn, unturn
from pipeline.simulation.terrain import Ground

NEARER = np.linspace(1.0, 0.0, 49)
"""Places looked at between the wished foothold and the present one."""

RINGS, SPOKES = 24, 16
"""Places looked at around a wished foothold."""

AROUND = 0.4
"""How far around it, as a part of the leg's length."""

STOOP = 0.9
"""How far a body may be lowered so that its feet reach, as a part of the room that its
belly has over level ground."""

CROUCH = 0.25
"""How far at most, in leg lengths: legs under a lower body would fold too far."""

BELOW = {"insect": -0.5, "mammal": 0.4}
"""How far below its hip a foot stands at least, as a part of how far it does on level ground.
Legs that sprawl reach above their hips as well."""

PLANNED_REACH = 0.98 * MAX_REACH
"""How far a leg is planned to stretch, as a part of its length; the rest is kept for
what the plan does not know."""

STANCE = np.array([0.0, 0.25, 0.5, 0.75, 1.0])
"""Parts of a stance at which reach is checked."""

AT_ONCE = np.array([1, 9])
"""After how many places the next ones are tried together: the first are mostly good."""

MOST = 41
"""How many places of one kind are tried."""

SWUNG = np.linspace(0.08, 0.92, 12)
"""Parts of a swing at which reach is checked."""

MOST_ARCH = 0.4
"""Highest arch of a swing, in leg lengths: a leg that goes over more folds up."""

LIFTS = 1.0, 0.6, 0.3
"""Parts of the height of its step that a foot is lifted in turn, if it cannot be more."""

EASY_WAY = 1.25
EASY_ARCH = 1.5
"""Way and arch of swings that legs can do anyway, in those on level ground."""

UP = np.array([0.0, 1.0, 0.0])

LAGS = 0.25
"""Part of the swing after it in which the foot has hardly left its place, see `ease`."""


@dataclass(frozen=True, eq=False)
class Foothold:
    """Where a foot stands.

    Attributes:
        place: (3,) where the sole touches the ground [m].
        normal: (3,) of the ground there.
        tip: (3,) place of the leg's tip [m].
        stoop: how far the body has to be lowered for it [m].
        arch: how high the swing to it has to arch [m].
    """

    place: Array
    normal: Array
    tip: Array
    stoop: float
    arch: float = 0.0


class Footholds:
    """Plans footholds for the legs of a herd."""

    def __init__(self, herd: Herd, ground: Ground, path: BodyTrajectory) -> None:
        self.herd = herd
        self.ground = ground
        self.path = path
        self.grasp = LegReachability(herd)
        self._lifted: dict[tuple[int, float], bool] = {}

    def next(
        self,
        leg: int,
        present: Array,
        travelled: float,
        step: StepTiming,
        drive: float = 1.0,
        brakes: float = 0.0,
        low: tuple[float, float] = (0.0, 0.0),
    ) -> Foothold | None:
        """Return where `leg`, about to lift, is to come down.

        Args:
            leg: which.
            present: (3,) where its tip is [m].
            travelled: way that the body has gone at lifting [m].
            step: when it swings and stands.
            drive: part of its speed at which the body goes.
            brakes: on which it comes to rest from that, if it has to [m].
            low: how far the body stoops for where the foot is, and for the other feet [m].

        Returns:
            None if there is no foothold within reach.
        """
        R, p, wished, lift = self._stance(leg, travelled, step.up, step, drive, brakes)
        here = present[[0, 2]]
        beside = self.grasp.beside(leg, lift[0].T @ (present - lift[1]))

        @cache
        def on_way() -> tuple[Array, Array]:
            moments = step.up + step.swing * SWUNG
            return self._bodies(leg, travelled, step.up, moments, drive, brakes)

        # On level ground a leg that folds too far on a long way is above it all the same.
        level = self.path.footing.is_level(int(self.herd.owner[leg]))
        for far in (EASY_WAY, np.inf) if level else (EASY_WAY,):

            def swung(place: Foothold, far: float = far) -> Foothold | None:
                rests = beside and self.grasp.beside(leg, unturn(R[:1], place.tip - p[:1]))
                easy = far if rests or far == np.inf else 0.0
                return self._swung(leg, present, place, step.up, on_way, easy, low)

            best = self._best(leg, self._choices(leg, wished, here), R, p, swung)
            if best is not None:
                return best
        return None

    def _swung(
        self,
        leg: int,
        present: Array,
        place: Foothold,
        phase: float,
        bodies: Callable[[], tuple[Array, Array]],
        far: float,
        low: tuple[float, float],
    ) -> Foothold | None:
        """Return a foothold with the arch that leads to it, None if the leg cannot swing so."""
        sole, owner = float(self.herd.sole[leg]), int(self.herd.owner[leg])
        least, stride = (
            float(self.path.paces.number(name, owner, np.array(phase)))
            for name in ("step_height", "stride")
        )
        arch = clearance_height(self.ground, present, place.tip, sole, least)
        if arch > MOST_ARCH * float(self.herd.legs.lengths[leg]):
            return None
        across = place.tip - present
        plain = arch < EASY_ARCH * least and abs(across[1]) < least and self.lifts(leg, least)
        if plain and np.hypot(across[0], across[2]) <= far * stride:
            return replace(place, arch=arch)
        n, (R, p) = len(SWUNG), bodies()
        lower = np.zeros((1, n))
        if max(place.stoop, *low) > 0.0:
            # The others may cease to need a low body before it has swung, or after it.
            own = low[0] + ease(SWUNG) * (place.stoop - low[0])
            lower = np.stack([own, np.sqrt(np.hypot(own**2, low[1] ** 2))])
        ends = np.tile(present, (n, 1)), np.tile(place.tip, (n, 1))
        for lift in LIFTS:
            # No higher than it has to be, if a leg cannot lift its foot as high as it would.
            if lift < 1.0:
                low_arch = clearance_height(self.ground, present, place.tip, sole, lift * least)
                if low_arch > 0.99 * arch:
                    break
                arch = low_arch
            way = swing_positions(*ends, np.full(n, arch), SWUNG)
            ways = unturn(R, way - (p - np.multiply.outer(lower, UP)))
            if self.grasp.follows(leg, ways):
                return replace(place, arch=arch)
        return replace(place, arch=arch) if far == np.inf else None

    def lifts(self, leg: int, high: float) -> bool:
        """Tell whether a leg lifts its foot as high as it would where it rests [m]."""
        if high == self.herd.step_height[leg]:
            return bool(self.lifting[leg])
        key = leg, high
        if key not in self._lifted:
            self._lifted[key] = bool(self._can_lift(np.array([leg]), np.array([high]))[0])
        return self._lifted[key]

    @cached_property
    def highest(self) -> Array:
        """(L,) how high above their hips feet stand at most [m]."""
        herd, owner = self.herd, self.herd.owner
        below = np.array([BELOW[figure.style] for figure in herd.figures])[owner]
        tall = herd.body_height[owner] + herd.hips[:, 1] - herd.sole
        # On level ground bodies that crouch and bounce are as low as they were asked to be.
        level = np.array([self.path.footing.is_level(c) for c in range(len(herd.names))])[owner]
        return np.where(level, np.inf, -below * tall)

    @cached_property
    def lifting(self) -> NDArray[np.bool_]:
        """(L,) which legs lift their feet as high as they would where they rest."""
        return self._can_lift(np.arange(len(self.herd.owner)), self.herd.step_height)

    def _can_lift(self, legs: NDArray[np.int64], high: Array) -> NDArray[np.bool_]:
        herd, owner = self.herd, self.herd.owner[legs]
        x, z = herd.rest[legs].T
        top = herd.sole[legs] - herd.body_height[owner] + EASY_ARCH * high
        ahead = 0.25 * herd.stride[owner]
        goals = [np.stack([x + k * ahead, top, z], axis=-1) for k in (-1.0, 0.0, 1.0)]
        return np.asarray(self.grasp.holds_each(legs, np.stack(goals, axis=1)).all(axis=-1))

    def first(self, leg: int, phase: float, moves: bool = True) -> Foothold | None:
        """Return where `leg` stands at the start: the good place nearest to where it would.

        Args:
            leg: which.
            phase: its gait's phase from which its foot has been down, at most 0.
            moves: whether its body comes walking.
        """
        swing = float(self.herd.swings[leg])
        step = StepTiming(phase - swing, swing, 1.0 - swing)
        R, p, wished, _ = self._stance(leg, 0.0, 0.0, step, 1.0 if moves else 0.0)
        return self._best(leg, self._choices(leg, wished), R, p)

    def later(self, leg: int, travelled: float, step: StepTiming) -> Foothold | None:
        """Return where `leg` can come down from wherever it will be.

        Args:
            leg: which.
            travelled: way that the body will have gone when it lifts [m].
            step: when it is to swing and stand.
        """
        R, p, wished, _ = self._stance(leg, travelled, step.up, step)
        # It will stand about a stride behind.
        stride = float(self.path.paces.number("stride", self.herd.owner[leg], np.array(step.up)))
        behind = wished - stride * R[len(STANCE) // 2, [0, 2], 0]
        return self._best(leg, self._choices(leg, wished, behind), R, p)

    def rests(self, leg: int, travelled: float) -> bool:
        """Tell whether a foot has ground where it rests below a body that rests there.

        Args:
            leg: which.
            travelled: way that its body has gone [m].
        """
        step = StepTiming(0.0, float(self.herd.swings[leg]), 1.0 - float(self.herd.swings[leg]))
        R, p, wished, _ = self._stance(leg, travelled, 0.0, step, 0.0)
        return self._best(leg, [wished[None]], R, p) is not None

    def _choices(self, leg: int, wished: Array, present: Array | None = None) -> Iterator[Array]:
        """Yield places (n, 2) to be looked at, the best first [m]."""
        # Alone, because it is good most times, and the others need not be looked at then.
        yield wished[None]
        if present is not None:
            yield self.nearer(wished, present)
        yield self.around(leg, wished)

    def rest(self, leg: int, travelled: float, phase: float) -> Array:
        """Return where a foot rests (2,) below a body that has gone `travelled` [m]."""
        owner, now = np.array([self.herd.owner[leg]]), np.array([phase])
        R, p = self.path.pose(owner, np.array([travelled]), now)
        result: Array = (p + turn(R, self.path.below(owner, now, self._rest(leg, phase))))[
            0, [0, 2]
        ]
        return result

    @staticmethod
    def nearer(wished: Array, present: Array) -> Array:
        """Return places (n, 2) on the way back from `wished` to the present one (2,) [m]."""
        result: Array = present + NEARER[:, None] * (wished - present)
        return result

    def around(self, leg: int, middle: Array) -> Array:
        """Return places (n, 2) on rings around `middle` (2,), the nearest first [m]."""
        angle = np.arange(SPOKES) * (2.0 * np.pi / SPOKES)
        spokes = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        radii = np.linspace(0.0, AROUND * self.herd.legs.lengths[leg], RINGS)
        result: Array = middle + (radii[:, None, None] * spokes).reshape(-1, 2)
        return result

    def _best(
        self,
        leg: int,
        choices: Iterable[Array],
        R: Array,
        p: Array,
        swung: Callable[[Foothold], Foothold | None] = lambda place: place,
    ) -> Foothold | None:
        """Return the first good foothold, rather a later one than one to stoop for.

        Args:
            leg: which.
            choices: places (n, 2) in each, the best first [m].
            R: (m, 3, 3) and
            p: (m, 3), poses of the body while the foot is there [m].
            swung: gives a foothold the swing that leads to it, or None where none does.
        """
        owner = self.herd.owner[leg]
        looked_at = []
        for xz in choices:
            tips = self.stand(leg, xz)
            safe = self.path.footing.allows(owner, xz[:, 0], xz[:, 1])
            stoop = np.where(safe, self._stoop(leg, tips, R, p), np.inf)
            for best in self._reached(leg, tips, stoop, stoop == 0.0, R, p):
                place = swung(self._foothold(leg, xz[best], 0.0))
                if place is not None:
                    return place
            looked_at.append((xz, tips, stoop))
        room = STOOP * self._room(int(owner), p)
        lowest_at = min(room, CROUCH * float(self.herd.legs.lengths[leg]))
        for xz, tips, stoop in looked_at:
            low = (stoop > 0.0) & (stoop <= lowest_at)
            for best in self._reached(leg, tips, stoop, low, R, p):
                place = swung(self._foothold(leg, xz[best], float(stoop[best])))
                if place is not None:
                    return place
        return None

    def _room(self, c: int, p: Array) -> float:
        """Return how far a body at all of p (m, 3) can be lowered until its belly is down [m]."""
        level = self.herd.body_height[c]
        above = (p[:, 1] - self.ground.height(p[:, 0], p[:, 2])).min()
        return max(float(max(level, above) - self.herd.belly[c]), 0.0)

    def _reached(
        self, leg: int, tips: Array, stoop: Array, which: NDArray[np.bool_], R: Array, p: Array
    ) -> Iterator[int]:
        """Yield those of tips (n, 3) that the joints bring the leg to, the first first.

        Of very many, evenly chosen ones.
        """
        places = np.flatnonzero(which)
        if len(places) > MOST:
            places = places[np.linspace(0, len(places) - 1, MOST).astype(np.int64)]
        for few in np.split(places, AT_ONCE[AT_ONCE < len(places)]):
            if len(few):
                lowered = p - np.multiply.outer(stoop[few], UP)[:, None]
                goals = unturn(R, tips[few, None] - lowered)
                yield from few[self.grasp.holds(leg, goals).all(axis=-1)].tolist()

    def _foothold(self, leg: int, xz: Array, stoop: float) -> Foothold:
        """Return the foothold at `xz` (2,), its sole clear of the slopes beside it."""
        x, z = xz
        height, normal = self.ground.surface(x, z)
        place = np.array([float(x), float(height), float(z)])
        sole = float(self.herd.sole[leg])
        tip = place + sole * normal
        tip[1] = max(tip[1], float(lowest_center_height(self.ground, tip[:1], tip[2:], sole)[0]))
        return Foothold(place, normal, tip, stoop)

    def stand(self, leg: int, xz: Array) -> Array:
        """Return the places (n, 3) of a tip whose sole touches the ground at `xz` (n, 2) [m]."""
        x, z = xz[:, 0], xz[:, 1]
        height, normal = self.ground.surface(x, z)
        return np.stack([x, height, z], axis=-1) + float(self.herd.sole[leg]) * normal

    def _rest(self, leg: int, phase: float) -> Array:
        (x, z), paces = self.herd.rest[leg], self.path.paces
        own, at = self.herd.owner[leg : leg + 1], np.array([phase])
        height, aside = (float(paces.value(name, own, at)[0]) for name in ("body_height", "aside"))
        rest: Array = np.array([float(x), -height, float(z) + aside])
        return rest

    def _stance(
        self,
        leg: int,
        travelled: float,
        phase: float,
        step: StepTiming,
        drive: float = 1.0,
        brakes: float = 0.0,
    ) -> tuple[Array, Array, Array, tuple[Array, Array]]:
        """Return what a foothold is for, if the creature goes on as it goes.

        Args:
            leg: which.
            travelled: way that its body has gone [m].
            phase: of the gait at that, whole cycles counted.
            step: when the foot swings and stands.
            drive: part of its speed at which the body goes.
            brakes: on which it comes to rest from that, if it has to [m].

        Returns:
            R_WB (m, 3, 3) and p_WB (m, 3) of the body while the foot is there, where the
            foot would rest in the middle of its stance (2,), and R_WB (3, 3) and p_WB (3,)
            when it lifts [m].
        """
        down, stance = step.up + step.swing, step.stance
        moments = down + np.append(stance * STANCE, [stance + LAGS * step.swing, -step.swing])
        R, p = self._bodies(leg, travelled, phase, moments, drive, brakes)
        middle = slice(len(STANCE) // 2, len(STANCE) // 2 + 1)
        rest = self._rest(leg, float(moments[middle][0]))
        rest = self.path.below(self.herd.owner[leg : leg + 1], moments[middle], rest)
        wished: Array = (p[middle] + turn(R[middle], rest))[0, [0, 2]]
        return R[:-1], p[:-1], wished, (R[-1], p[-1])

    def _bodies(
        self,
        leg: int,
        travelled: float,
        phase: float,
        moments: Array,
        drive: float,
        brakes: float = 0.0,
    ) -> tuple[Array, Array]:
        """Return R_WB (m, 3, 3) and p_WB (m, 3) of a leg's body at later phases (m,).

        Args:
            leg: which.
            travelled: way that its body has gone [m].
            phase: of the gait at that, whole cycles counted.
            moments: (m,) phases.
            drive: part of its speed at which it goes: the stride grows with its root.
            brakes: on which it comes to rest from that, if it has to [m].
        """
        owner = int(self.herd.owner[leg])
        way = self.path.paces.way(owner, phase, moments) * math.sqrt(drive)
        left = self.path.routes[owner].length - travelled
        if brakes and left < math.inf:
            way = braked(way, left, brakes)
        return self.path.pose(np.full(len(moments), owner), travelled + way, moments)

    def _stoop(self, leg: int, tips: Array, R: Array, p: Array) -> Array:
        """Return how far (n,) all bodies (m, ...) have to be lowered so that `tips` are reached.

        Zero where they need not, infinite where it does not help [m].
        """
        to_tip = tips[:, None] - (p + turn(R, self.herd.hips[leg]))
        reach = PLANNED_REACH * self.herd.legs.lengths[leg]
        room = reach**2 - to_tip[..., 0] ** 2 - to_tip[..., 2] ** 2
        up = np.sqrt(np.maximum(room, 0.0))
        stoop = np.maximum(-to_tip[..., 1] - up, 0.0).max(axis=1)
        most = np.minimum(up, self.highest[leg])
        out_of_reach = (room < 0.0) | (to_tip[..., 1] + stoop[:, None] > most)
        return np.where(out_of_reach.any(axis=1), np.inf, stoop)
