"""Feet: where those of a herd stand, and how they step.

Feet that reach their foot-up phase plan a step, feet that reach their foot-down phase
touch the ground; where a foot finds no place its creature comes to rest.

Source: Sims 1987, 10.2.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache

import numpy as np

from pipeline.errors import SimulationError
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.locomotion.foot_placement.barrier_lookahead import (
    Barrier,
    BarrierLookahead,
)
from pipeline.simulation.locomotion.foot_placement.foothold_planner import Lift, PlainSteps
from pipeline.simulation.locomotion.foot_placement.foothold_search import (
    Foothold,
    Footholds,
)
from pipeline.simulation.locomotion.gaits.gait import Gait
from pipeline.simulation.locomotion.gaits.gait_transition import StepTiming
from pipeline.simulation.locomotion.routes.braking import room_to_rest
from pipeline.simulation.locomotion.routes.route_progress import RouteProgress
from pipeline.simulation.locomotion.swing.foot_contacts import FootContacts
from pipeline.simulation.locomotion.swing.swing_planner import SwingPlanner, SwingRequest
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Note
from pipeline.simulation.troupe import World
from pipeline.spec.creature import Creature

AHEAD = 2.5
"""Strides in which a foot has done its step and stood."""

CLOSE = 0.08
"""Distance of a foot from where it rests, as a part of its leg, that is closed up."""

SOON = 2.0
"""Steps before the first foot lifts at which who has rested sets out again."""


class Feet:
    """The feet of a herd.

    Attributes of the state:
        start, end, height: of each leg's swing, (L, 3), (L, 3), (L,) [m]; a leg that
            stands does so at `end`.
        bend: (L, m, 3) what swings have beside their arches, if anybody's have any [m].
        holds: the footholds that the legs stand on or are on their way to.
        stoop: (2, L) how far the body is lowered for each leg's foothold before the one at
            `end`, and for that one [m].
        lifted, span: (L,) phase at which its swing began, and how long that lasts, in cycles.
        swinging: (L,).
        tuck: (2, L) how much it was held up before this swing, and will be after it, 0 or 1.
        up: (L,) foot-up phases of legs whose gait stays.
        changing: creatures whose gait does not stay.
        notes: of what they could not do, since they were taken away.
    """

    def __init__(
        self,
        cast: Sequence[tuple[int, Creature, Figure]],
        world: World,
        going: RouteProgress,
        footfalls: FootContacts,
    ) -> None:
        self.world = world
        self.going = going
        self.herd = herd = going.herd
        self.footfalls = footfalls
        self.footholds = Footholds(herd, world.ground, going.path)
        self._plain = PlainSteps(self.footholds)
        self.scout = BarrierLookahead(self.footholds, going)
        legs = len(herd.owner)
        self.up = herd.up.copy()
        self.span, self.tuck = herd.swings.copy(), np.zeros((2, legs))
        self.changing: set[int] = set()
        self._barred = np.full(len(herd.names), np.nan)
        self.start, self.end = np.zeros((legs, 3)), np.zeros((legs, 3))
        self.height, self.lifted = np.zeros(legs), np.zeros(legs)
        self.stoop = np.zeros((2, legs))
        self._swings = SwingPlanner.of(cast, going, world.ground)
        self.bend = None if self._swings is None else self._swings.none
        self.holds: list[Foothold] = []
        self.swinging = np.zeros(legs, dtype=bool)
        self.notes: list[Note] = []
        self._found: dict[int, Foothold | None] = {}

    # --- the start --------------------------------------------------------------

    def set_down(self) -> None:
        """Put every foot where it would be if the creature had come walking."""
        herd = self.herd
        walking = np.flatnonzero(herd.walks[herd.owner]).tolist()
        self.scout.foresee_before(walking)
        for leg in walking:
            self._end_before(0, leg, self.scout.before(leg))
        # No faster than it can come to rest before what bars its way.
        slow = np.sqrt(self._barred / np.maximum(self.going.braking, 1e-9))
        self.going.set_out(np.fmin(slow, 1.0))
        into = np.mod(-herd.up, 1.0)  # how far the cycle has gone since its last foot-up
        in_air = herd.walks[herd.owner] & (into < herd.swings)
        # Where it stands now, or stood before the swing that it is in.
        down = np.where(
            herd.walks[herd.owner],
            -into + herd.swings - np.where(in_air, 1.0, 0.0),
            -0.5 * (1.0 - herd.swings),
        )
        firsts = [self._standing(leg, float(down[leg])) for leg in range(len(herd.owner))]
        self._plain.foresee(firsts)
        places = [self._plain.of(leg) for leg in range(len(herd.owner))]
        for leg, place in enumerate(places):
            place = place or self.footholds.first(leg, float(down[leg]))
            if place is None:
                raise SimulationError(self._no_ground(leg))
            self.start[leg] = self.end[leg] = place.tip
            self.stoop[:, leg] = place.stoop
            self.holds.append(place)
        lifting = [(leg, -float(into[leg])) for leg in np.flatnonzero(in_air).tolist()]
        self._foresee(lifting)
        for leg in range(len(herd.owner)):
            if self.going.paces.held(leg, 0.0):
                self._hold_up(leg, 0.0)
                self.tuck[0, leg] = 1.0
            elif in_air[leg]:
                self._lift(0, leg, -float(into[leg]))
        self._found.clear()
        for c in np.flatnonzero((self._barred == 0.0) | self.going.halted).tolist():
            self._stay(c)

    def _standing(self, leg: int, down: float) -> Lift:
        """Return what is known of a foot that has been down since the phase `down`."""
        swing = float(self.herd.swings[leg])
        return Lift(leg, 0.0, 0.0, StepTiming(down - swing, swing, 1.0 - swing), 1.0)

    def _stay(self, c: int) -> None:
        """Let a creature that does not set out stand: it never came walking."""
        self.going.stay(c)
        for leg in np.flatnonzero(self.herd.owner == c).tolist():
            place = self.footholds.first(leg, -0.5 * (1.0 - self.herd.swings[leg]), moves=False)
            if place is not None:
                self.start[leg] = self.end[leg] = place.tip
                self.stoop[:, leg] = place.stoop
                self.holds[leg], self.swinging[leg] = place, False

    def _no_ground(self, leg: int) -> str:
        owner = int(self.herd.owner[leg])
        x, z = self.herd.starts[owner]
        return (
            f"{self.herd.names[owner]}: leg {self.herd.leg_names[leg]} finds no foothold around "
            f"its start at [{x:g}, {z:g}]: all is forbidden or out of reach; "
            "place it elsewhere with `at`, or raise `unsteppable_slope_deg`"
        )

    # --- one step ---------------------------------------------------------------

    def take_steps(self, step: int, before: Array) -> None:
        """Lift the feet whose foot-up phase was passed, put down those whose foot-down was."""
        herd, dt = self.herd, self.world.clock.dt
        phase, base = self.going.phase[herd.owner], before[herd.owner]
        span = phase - base
        for leg in self.footfalls.scuffing.due(base, phase):
            fraction = (self.footfalls.scuffing.at[leg] - base[leg]) / span[leg]
            self.footfalls.scuff((step, float(fraction)), int(leg), float(span[leg]) / dt)
        down_at, held = self.lifted + self.span, self.tuck[1] > 0.0
        for leg in np.flatnonzero(self.swinging & ~held & (down_at <= phase)):
            fraction = (down_at[leg] - base[leg]) / span[leg]
            self._touch(step, int(leg), float(fraction), float(span[leg]) / dt)
        up_at = self._going_up(before, base)
        due = np.flatnonzero((~self.swinging | held) & (up_at < phase))
        if not len(due):
            return
        may = self.going.may_lift()[herd.owner[due]]
        if self.going.may_rest:
            rests = zip(due.tolist(), self.going.arrived[herd.owner[due]], strict=True)
            may &= [not rest or self.is_astray(leg) for leg, rest in rests]
        lifting = [(leg, float(up_at[leg])) for leg in due[may].tolist()]
        self._foresee(lifting, soon=True)
        for leg, up in self._stuck_first(lifting):
            self._go_up(step, leg, up)
        self._found.clear()

    def _stuck_first(self, lifts: list[tuple[int, float]]) -> list[tuple[int, float]]:
        """Put legs that have nowhere to go first: others that lift with them then stay down."""
        owners = [int(self.herd.owner[leg]) for leg, _ in lifts]
        if len(set(owners)) == len(owners):
            return lifts
        free = []
        for leg, phase in lifts:
            swings = self._swings_at(leg, phase)
            free.append(not swings or self._place_for(leg, phase) is not None)
        return [lifts[i] for i in np.argsort(free, kind="stable")]

    def _going_up(self, before: Array, base: Array) -> Array:
        """Return the phases (L,) of the first foot-up after the step began.

        An end of a step belongs to the next one.

        Args:
            before: (C,) and
            base: (L,), phases of the gaits when the step began.
        """
        up_at: Array = base + np.mod(self.up - base, 1.0)
        for c in sorted(self.changing):
            own = self.herd.owner == c
            gait = self.going.paces.gait(c, float(before[c]))
            up_at[own] = gait.next_up(float(before[c]))
            if isinstance(gait, Gait) and not self.going.changes(c):
                self.changing.remove(c)
                self.up[own] = gait.up
        return up_at

    def _go_up(self, step: int, leg: int, phase: float) -> None:
        """Lift a foot at `phase`, to come down again or to be held up."""
        stays_up = self.going.paces.held(leg, phase)
        if self.tuck[1, leg] == 0.0:
            if stays_up:
                self._hold_up(leg, phase)
            else:
                self._lift(step, leg, phase)
        elif not stays_up:
            self._let_down(step, leg, phase)

    def _hold_up(self, leg: int, phase: float) -> None:
        """Hold a foot up from `phase` on."""
        self.start[leg] = self.end[leg]
        self.height[leg] = 0.0
        if self.bend is not None:
            self.bend[leg] = 0.0
        self.stoop[:, leg] = self.stoop[1, leg], 0.0
        self.tuck[:, leg] = self.tuck[1, leg], 1.0
        self.lifted[leg], self.swinging[leg] = phase, True

    def _let_down(self, step: int, leg: int, phase: float) -> None:
        """Bring a foot down that was held up: to a foothold from about where it rests."""
        way = float(self.going.way[self.herd.owner[leg]])
        x, z = self.footholds.rest(leg, way, phase)
        self.end[leg] = self.footholds.stand(leg, np.array([[x, z]]))[0]
        self._lift(step, leg, phase)
        if self.lifted[leg] == phase:
            self.tuck[:, leg] = 1.0, 0.0

    def _foresee(self, lifting: Sequence[tuple[int, float]], soon: bool = False) -> None:
        """Plan steps of all legs together that go up at their phases, as far as they are plain.

        Args:
            lifting: legs and their phases.
            soon: whether to plan those that are to go up soon with them.
        """
        lifts = [
            self._lift_of(leg, phase, self.going.gone, self.going.drive)
            for leg, phase in lifting
            if self._swings_at(leg, phase)
        ]
        expected = cache(self._expected if soon else tuple)
        self._plain.foresee(
            [lift for lift in lifts if self._is_plain(lift)],
            lambda: [lift for lift in expected() if self._is_plain(lift)],
        )
        self.scout.foresee(lifts, later=expected)

    def _expected(self) -> Sequence[Lift]:
        """Return the lifts of the next few steps as they will be if all go on as they do."""
        herd, lifts = self.herd, list[Lift]()
        base = self.going.phase[herd.owner]
        for gone, drive in self.going.foreseen():
            phase = gone[1, herd.owner]
            up_at = base + np.mod(self.up - base, 1.0)
            due = np.flatnonzero(up_at < phase).tolist()
            lifts += [
                self._lift_of(leg, float(up_at[leg]), gone, drive)
                for leg in due
                if self._swings_at(leg, float(up_at[leg]))
            ]
            base = phase
        return lifts

    def _swings_at(self, leg: int, phase: float) -> bool:
        """Tell whether a leg that goes up at `phase` swings from one foothold to the next."""
        return self.tuck[1, leg] == 0.0 and not self.going.paces.held(leg, phase)

    def _is_plain(self, lift: Lift) -> bool:
        """Tell whether a body neither stoops nor may have to brake while a foot steps."""
        going, c = self.going, int(self.herd.owner[lift.leg])
        first = int(self.herd.first_leg[c])
        own = slice(first, first + len(self.herd.paces[c].held))
        left = going.path.routes[c].length - lift.travelled
        far = float(going.braking[c]) + AHEAD * float(going.full[c])
        return left > far and not self.stoop[:, own].any()

    def _lift_of(self, leg: int, phase: float, gone: Array, drive: Array) -> Lift:
        """Return what is known of the step of a foot that lifts at `phase`.

        Args:
            leg: which.
            phase: within the step that ends with what follows.
            gone: (2, C) and
            drive: (C,) of the creatures, see `RouteProgress`.
        """
        paces, c = self.going.paces, int(self.herd.owner[leg])
        part = float(drive[c])
        back = paces.way(c, float(gone[1, c]), np.array(phase))
        way = float(gone[0, c] + back * math.sqrt(part))
        return Lift(leg, way, phase, paces.step(leg, phase), part, self.end[leg].copy())

    def about_to_lift(self, c: int, phase: float) -> float:
        """Return the first phase from `phase` on just after which a foot of a creature lifts.

        Who sets out then leaves no foot behind.
        """
        up = self.up[self.herd.owner == c]
        if not len(up):
            return phase
        soon = SOON * self.world.clock.dt / float(self.going.cycle[c])
        return phase + float(np.mod(up - soon - phase, 1.0).min())

    def is_astray(self, leg: int) -> bool:
        """Tell whether a foot of a body at rest is not where it would rest."""
        way, phase = self.going.way[self.herd.owner[leg]], self.going.phase[self.herd.owner[leg]]
        rest = self.footholds.rest(leg, float(way), float(phase))
        gap = np.linalg.norm(self.end[leg, [0, 2]] - rest)
        return bool(gap > CLOSE * self.herd.legs.lengths[leg])

    def _lift(self, step: int, leg: int, phase: float) -> None:
        """Plan the swing of a foot that lifts at `phase`; halt if it has nowhere to go."""
        herd, owner = self.herd, int(self.herd.owner[leg])
        if self.going.halted[owner]:
            return
        going, swung = self.going, self.going.paces.step(leg, phase)
        drive, way = float(going.drive[owner]), self._way_at(leg, phase)
        place = self._place_for(leg, phase)
        if place is None:
            if self.is_barred(owner):
                # It has been told, and rests as soon as it can.
                if not self.going.arrived[owner]:
                    self._halt(owner)
                return
            self._halt(owner)
            name = f"{herd.names[owner]}.{herd.leg_names[leg]}"
            self.notes.append(Note("stopped", step, name, "no foothold within reach"))
            return
        self.start[leg], self.end[leg] = self.end[leg], place.tip
        self.stoop[:, leg] = self.stoop[1, leg], place.stoop
        self.tuck[:, leg] = 0.0
        self.holds[leg] = place
        self.height[leg] = place.arch
        least = float(going.paces.number("step_height", owner, np.array(phase)))
        if self._swings is not None and self.bend is not None:
            asked = SwingRequest(swung, self.start[leg], place.tip, way, drive, least)
            planned = self._swings.plan(leg, asked, self.height[leg], self.stoop[1])
            self.height[leg], self.bend[leg] = planned
        self.lifted[leg], self.span[leg], self.swinging[leg] = phase, swung.swing, True
        heights = float(self.height[leg]), least
        self.footfalls.scuffing.plan(
            leg, swung, self.start[leg], place.tip, heights, self._bend(leg)
        )
        self._end_before(step, leg, self.scout.ahead(leg, way, phase))

    def _way_at(self, leg: int, phase: float) -> float:
        """Return the way that the body of a leg had gone at `phase`, within this step [m]."""
        going, owner = self.going, int(self.herd.owner[leg])
        back = going.paces.way(owner, float(self.going.phase[owner]), np.array([phase]))
        return float(self.going.way[owner] + back[0] * math.sqrt(float(going.drive[owner])))

    def _place_for(self, leg: int, phase: float) -> Foothold | None:
        """Return where a foot that lifts at `phase` is to come down, as far as it is known."""
        place = self._plain.of(leg)
        if place is not None:
            return place
        return self._found[leg] if leg in self._found else self._next(leg, phase)

    def _next(self, leg: int, phase: float) -> Foothold | None:
        """Return where a foot that lifts at `phase` is to come down, None if nowhere."""
        going, owner = self.going, int(self.herd.owner[leg])
        drive = float(going.drive[owner])
        others = (self.herd.owner == owner) & (np.arange(len(self.end)) != leg)
        low = float(self.stoop[1, leg]), float(self.stoop[:, others].max(initial=0.0))
        step, brakes = going.paces.step(leg, phase), float(going.braking[owner]) * drive * drive
        self._found[leg] = self.footholds.next(
            leg, self.end[leg], self._way_at(leg, phase), step, drive, brakes, low
        )
        return self._found[leg]

    def _bend(self, leg: int) -> Array | None:
        """Return what the swing of a leg has beside its arch."""
        return None if self.bend is None else self.bend[leg]

    def stand_at(self, leg: int, place: Foothold) -> None:
        """Let a foot stand somewhere, wherever it has been."""
        self.start[leg] = self.end[leg] = place.tip
        self.stoop[:, leg], self.height[leg] = place.stoop, 0.0
        self.holds[leg], self.swinging[leg] = place, False
        if self.bend is not None:
            self.bend[leg] = 0.0

    def _touch(self, step: int, leg: int, fraction: float, rate: float) -> None:
        """Put a foot down, `fraction` of a step after `step`, at a rate of the phase [1/s]."""
        self.swinging[leg] = False
        time = self.going.cycle[self.herd.owner[leg]] * float(self.span[leg])
        way = self.start[leg], float(self.height[leg]), self._bend(leg)
        self.footfalls.touch((step, fraction), leg, self.holds[leg], way, (float(time), rate))

    # --- the ends of ways -------------------------------------------------------

    def is_barred(self, c: int) -> bool:
        """Tell whether a creature's way ends at what it cannot go over."""
        return bool(self.going.path.routes[c].length == self._barred[c])

    def _end_before(self, step: int, leg: int, barrier: Barrier | None) -> None:
        """End the way of a creature before what its scout finds."""
        c = int(self.herd.owner[leg])
        route = self.going.path.routes[c]
        if barrier is None or barrier.way >= route.length:
            return
        told = self.is_barred(c)
        self._barred[c] = barrier.way
        self.going.lead(c, route.upto(barrier.way))
        if told:
            return
        name = f"{self.herd.names[c]}.{self.herd.leg_names[leg]}"
        self.notes.append(Note("stopped", step, name, barrier.cause))

    def _halt(self, c: int) -> None:
        """Let a creature that has no foothold come to rest where its feet still reach."""
        going, own = self.going, self.herd.owner == c
        way, phase = float(going.way[c]), float(going.phase[c])

        def bodies(on: Array) -> tuple[Array, Array]:
            count = len(on)
            return going.path.pose(np.full(count, c), way + on, np.full(count, phase))

        nearest, farthest = going.stopping(c)
        room = room_to_rest(self.herd, c, self.end[own], bodies, nearest, farthest)
        going.halt(c, room)
        self._barred[c] = going.path.routes[c].length
