"""Walking: the troupe of creatures on legs.

The gait's phase runs on; feet that reach their foot-up phase plan a step, feet that
reach their foot-down phase touch the ground. The body goes its way. What joins the two
is worked out for many moments at once, when they are written; see `posing`.

Source: Sims 1987, ch. 10.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import SimulationError
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.locomotion.carriage.idle import gather_idlers
from pipeline.simulation.locomotion.carriage.looking import looks_in
from pipeline.simulation.locomotion.footing.footholds import Foothold, Footholds
from pipeline.simulation.locomotion.footing.plain_steps import Lift, PlainSteps
from pipeline.simulation.locomotion.footing.scout import Barrier, Scout
from pipeline.simulation.locomotion.gaits.gait import Gait
from pipeline.simulation.locomotion.gaits.manners import Manners
from pipeline.simulation.locomotion.gaits.paces import Paces, Step
from pipeline.simulation.locomotion.herd import gather
from pipeline.simulation.locomotion.inventory import (
    NodeTable,
    describe,
    foot_materials,
    leg_mass,
)
from pipeline.simulation.locomotion.posing import Moment, Posing
from pipeline.simulation.locomotion.postures import Postures
from pipeline.simulation.locomotion.swings.plans import Asked, SwingPlans
from pipeline.simulation.locomotion.swings.scuffing import Scuffing
from pipeline.simulation.locomotion.swings.swing import approach_speed
from pipeline.simulation.locomotion.ways.body_path import BodyPath
from pipeline.simulation.locomotion.ways.braking import room_to_rest
from pipeline.simulation.locomotion.ways.directing import obey
from pipeline.simulation.locomotion.ways.going import Going
from pipeline.simulation.locomotion.ways.wayfinding import route_of
from pipeline.simulation.script import Orders
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Contact, ContactKind, Note
from pipeline.simulation.troupe import Facts, Rows, World
from pipeline.spec.cast import Creature
from pipeline.spec.script import ChangeGait, ChangeMood, SetSpeed

HURRY = 2.0
"""How much faster a creature may get by a change of mood or speed."""

AHEAD = 2.5
"""Strides in which a foot has done its step and stood."""

CLOSE = 0.08
"""Distance of a foot from where it rests, as a part of its leg, that is closed up."""


class Walkers:
    """All creatures on legs: their state, and how it advances.

    Attributes of the state:
        going: how far it has gone, and how fast it goes.
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
    """

    def __init__(
        self, cast: Sequence[tuple[int, Creature, Figure]], world: World, materials: Sequence[str]
    ) -> None:
        self.world = world
        self.herd = herd = gather(cast, world.moods)
        paces, manners = Paces(herd), Manners(cast, herd, world.moods)
        far = self._farthest(manners)
        routes = [
            route_of(member, herd.footprint[c], float(far[c]))
            for c, (_, member, _) in enumerate(cast)
        ]
        path = BodyPath(herd, world.ground, routes, paces)
        self.footholds = Footholds(herd, world.ground, path)
        self._plain = PlainSteps(self.footholds)
        idlers = gather_idlers(herd, world.seed)
        table = NodeTable.of(herd, idlers)
        self.postures = Postures(cast, herd, idlers, world.seed)
        self.posing = Posing(herd, path, idlers, table, self.postures, world.clock)
        self.inventory = describe(herd, idlers, table, materials, world.clock.rows)
        self.step = 0
        self._mass = leg_mass(herd)
        self._foot_materials = foot_materials(herd, materials)
        legs = len(herd.owner)
        path.bearing = manners.bearing(0.0)
        self.going = Going(herd, path, manners, world.clock.dt)
        self.up = herd.up.copy()
        self.span, self.tuck = herd.swings.copy(), np.zeros((2, legs))
        self._changing: set[int] = set()
        self.going.looks = looks_in(herd, cast)
        self.scout = Scout(self.footholds, self.going)
        self._barred = np.full(len(herd.names), np.nan)
        self.start, self.end = np.zeros((legs, 3)), np.zeros((legs, 3))
        self.height, self.lifted = np.zeros(legs), np.zeros(legs)
        self.stoop = np.zeros((2, legs))
        self._swings = SwingPlans.of(cast, self.going, world.ground)
        self.bend = None if self._swings is None else self._swings.none
        self.holds: list[Foothold] = []
        self.scuffing = Scuffing(herd, world.ground)
        self.swinging = np.zeros(legs, dtype=bool)
        self._contacts: list[Contact] = []
        self._notes: list[Note] = []
        self._told: list[Note] = []
        self._arrived: list[str] = []
        self._kept: list[Moment] = []
        self._found: dict[int, Foothold | None] = {}
        self._set_down()

    @property
    def travelled(self) -> Array:
        """(C,) way gone since the start [m]."""
        return self.going.way

    @property
    def phase(self) -> Array:
        """(C,) phases of the gaits, whole cycles counted."""
        return self.going.phase

    @property
    def halted(self) -> NDArray[np.bool_]:
        """(C,) whether it found no foothold."""
        return self.going.halted

    # --- the passes of the step -------------------------------------------------

    def read(self, orders: Orders) -> None:
        """Take in what the script asks from this step on."""
        for name, given in orders.items():
            if name in self.herd.names:
                for order in given:
                    c = self.herd.names.index(name)
                    unable = obey(self.going, c, order)
                    if self.going.changes(c):
                        self._changing.add(c)
                    if unable is not None:
                        self._told.append(Note("clamped", self.step, name, unable))

    def advance(self, step: int) -> None:
        """Go from `step` to the next."""
        self._contacts.clear()
        self._notes = self._told
        self._told = []
        before = self.phase
        going = self.going
        going.path.bearing = going.manners.bearing(going.time)
        self._arrived = self._go_on()
        self._take_steps(step, before)
        self.step = step + 1

    def _farthest(self, manners: Manners) -> Array:
        """Return how far creatures (C,) can get in the film at most [m].

        Raises:
            SceneError: if the script asks for a gait that legs do not have.
        """
        herd, clock = self.herd, self.world.clock
        stride, speed = herd.stride.copy(), herd.stride / herd.cycle
        for i, one in enumerate(self.world.script):
            if one.who not in herd.names:
                continue
            c, hurry = herd.names.index(one.who), 1.0
            if isinstance(one.do, ChangeGait):
                pace = manners.possible(c, one.do, f"script[{i}].do")
                stride[c] = max(stride[c], pace.stride)
                speed[c] = max(speed[c], pace.stride / pace.cycle)
            elif isinstance(one.do, SetSpeed | ChangeMood):
                hurry = HURRY
            speed[c] *= hurry
        return speed * float(clock.time_of(clock.last_step)) + stride

    def keep(self) -> None:
        """Keep the present state as the next row."""
        self._kept.append(
            Moment(
                step=self.step,
                gone=self.going.gone,
                drive=self.going.drive,
                start=self.start.copy(),
                end=self.end.copy(),
                height=self.height.copy(),
                lifted=self.lifted.copy(),
                span=self.span.copy(),
                swinging=self.swinging.copy(),
                stoop=self.stoop.copy(),
                tuck=self.tuck.copy(),
                bearing=self.going.path.bearing,
                routes=self.going.path.routes,
                looks=self.going.looks,
                bend=None if self.bend is None else self.bend.copy(),
            )
        )

    def write(self, rows: Rows) -> None:
        """Write nodes and channels of all rows kept."""
        poses = self.posing.poses(self._kept)
        rows.positions[:], rows.rotations[:] = poses.positions, poses.rotations
        rows.alive[:] = True
        rows.values[:] = poses.values
        self._notes.extend(poses.notes)
        self._kept.clear()

    def facts(self) -> Facts:
        """Return the contacts and notes of the last step."""
        return Facts(tuple(self._contacts), tuple(self._notes), tuple(self._arrived))

    # --- the start --------------------------------------------------------------

    def _set_down(self) -> None:
        """Put every foot where it would be if the creature had come walking."""
        herd = self.herd
        walking = np.flatnonzero(herd.walks[herd.owner]).tolist()
        self.scout.foresee_before(walking)
        for leg in walking:
            self._end_before(0, leg, self.scout.before(leg))
        # No faster than it can come to rest before what bars its way.
        slow = np.sqrt(self._barred / np.maximum(self.going.braking, 1e-9))
        self.going.drive = np.where(slow < 1.0, self.going.drive * slow, self.going.drive)
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
        return Lift(leg, 0.0, 0.0, Step(down - swing, swing, 1.0 - swing), 1.0)

    def _stay(self, c: int) -> None:
        """Let a creature that does not set out stand: it never came walking."""
        self.going.drive[c] = 0.0
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

    def _go_on(self) -> list[str]:
        """Advance on the routes; return who has come to its end."""
        going, count = self.going, len(self.herd.names)
        if not going.may_rest:
            going.advance(np.zeros(count, dtype=bool))
            return []
        stood = going.arrived
        going.advance(np.bincount(self.herd.owner[self.swinging], minlength=count) > 0)
        came = np.flatnonzero(going.arrived & ~stood)
        return [self.herd.names[c] for c in came if not self._is_barred(int(c))]

    def _is_barred(self, c: int) -> bool:
        """Tell whether a creature's way ends at what it cannot go over."""
        return bool(self.going.path.routes[c].length == self._barred[c])

    def _end_before(self, step: int, leg: int, barrier: Barrier | None) -> None:
        """End the way of a creature before what its scout finds."""
        c = int(self.herd.owner[leg])
        route = self.going.path.routes[c]
        if barrier is None or barrier.way >= route.length:
            return
        told = self._is_barred(c)
        self._barred[c] = barrier.way
        self.going.lead(c, route.upto(barrier.way))
        if told:
            return
        name = f"{self.herd.names[c]}.{self.herd.leg_names[leg]}"
        self._notes.append(Note("stopped", step, name, barrier.cause))

    def _take_steps(self, step: int, before: Array) -> None:
        """Lift the feet whose foot-up phase was passed, put down those whose foot-down was."""
        herd = self.herd
        phase, base = self.phase[herd.owner], before[herd.owner]
        span = phase - base
        for leg in self.scuffing.due(base, phase):
            fraction = (self.scuffing.at[leg] - base[leg]) / span[leg]
            self._scuff(step, int(leg), float(fraction), float(span[leg]))
        down_at, held = self.lifted + self.span, self.tuck[1] > 0.0
        for leg in np.flatnonzero(self.swinging & ~held & (down_at <= phase)):
            fraction = (down_at[leg] - base[leg]) / span[leg]
            self._touch(step, int(leg), float(fraction), float(span[leg]))
        up_at = self._going_up(before, base)
        due = np.flatnonzero((~self.swinging | held) & (up_at < phase))
        if not len(due):
            return
        may = self.going.may_lift()[herd.owner[due]]
        if self.going.may_rest:
            rests = zip(due.tolist(), self.going.arrived[herd.owner[due]], strict=True)
            may &= [not rest or self._is_astray(leg) for leg, rest in rests]
        lifting = [(leg, float(up_at[leg])) for leg in due[may].tolist()]
        self._foresee(lifting)
        for leg, up in self._stuck_first(lifting):
            self._go_up(step, leg, up)
        self._found.clear()

    def _stuck_first(self, lifts: list[tuple[int, float]]) -> list[tuple[int, float]]:
        """Put legs that have nowhere to go first: others that lift with them then stay down."""
        owners = [int(self.herd.owner[leg]) for leg, _ in lifts]
        if len(set(owners)) == len(owners):
            return lifts
        paces, free = self.going.paces, []
        for leg, phase in lifts:
            swings = not paces.held(leg, phase) and self.tuck[1, leg] == 0.0
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
        for c in sorted(self._changing):
            own = self.herd.owner == c
            gait = self.going.paces.gait(c, float(before[c]))
            up_at[own] = gait.next_up(float(before[c]))
            if isinstance(gait, Gait) and not self.going.changes(c):
                self._changing.remove(c)
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
        way = float(self.travelled[self.herd.owner[leg]])
        x, z = self.footholds.rest(leg, way, phase)
        self.end[leg] = self.footholds.stand(leg, np.array([[x, z]]))[0]
        self._lift(step, leg, phase)
        if self.lifted[leg] == phase:
            self.tuck[:, leg] = 1.0, 0.0

    def _foresee(self, lifting: Sequence[tuple[int, float]]) -> None:
        """Plan steps of all legs together that go up at their phases, as far as they are plain."""
        paces = self.going.paces
        lifts = [
            self._lift_of(leg, phase, self.end[leg])
            for leg, phase in lifting
            if self.tuck[1, leg] == 0.0 and not paces.held(leg, phase)
        ]
        self._plain.foresee([lift for lift in lifts if self._is_plain(lift)])
        self.scout.foresee(lifts)

    def _is_plain(self, lift: Lift) -> bool:
        """Tell whether a body neither stoops nor may have to brake while a foot steps."""
        going, c = self.going, int(self.herd.owner[lift.leg])
        first = int(self.herd.first_leg[c])
        own = slice(first, first + len(self.herd.paces[c].held))
        left = going.path.routes[c].length - lift.travelled
        far = float(going.braking[c]) + AHEAD * float(going.full[c])
        return left > far and not self.stoop[:, own].any()

    def _lift_of(self, leg: int, phase: float, present: Array) -> Lift:
        """Return what is known of the step of a foot that lifts at `phase`."""
        going, owner = self.going, int(self.herd.owner[leg])
        drive = float(going.drive[owner])
        way = self._way_at(leg, phase)
        return Lift(leg, way, phase, going.paces.step(leg, phase), drive, present)

    def _is_astray(self, leg: int) -> bool:
        """Tell whether a foot of a body at rest is not where it would rest."""
        way, phase = self.travelled[self.herd.owner[leg]], self.phase[self.herd.owner[leg]]
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
            if self._is_barred(owner):
                # It has been told, and rests as soon as it can.
                if not self.going.arrived[owner]:
                    self._halt(owner)
                return
            self._halt(owner)
            name = f"{herd.names[owner]}.{herd.leg_names[leg]}"
            self._notes.append(Note("stopped", step, name, "no foothold within reach"))
            return
        self.start[leg], self.end[leg] = self.end[leg], place.tip
        self.stoop[:, leg] = self.stoop[1, leg], place.stoop
        self.tuck[:, leg] = 0.0
        self.holds[leg] = place
        self.height[leg] = place.arch
        least = float(going.paces.number("step_height", owner, np.array(phase)))
        if self._swings is not None and self.bend is not None:
            asked = Asked(swung, self.start[leg], place.tip, way, drive, least)
            planned = self._swings.plan(leg, asked, self.height[leg], self.stoop[1])
            self.height[leg], self.bend[leg] = planned
        self.lifted[leg], self.span[leg], self.swinging[leg] = phase, swung.swing, True
        heights = float(self.height[leg]), least
        self.scuffing.plan(leg, swung, self.start[leg], place.tip, heights, self._bend(leg))
        self._end_before(step, leg, self.scout.ahead(leg, way, phase))

    def _way_at(self, leg: int, phase: float) -> float:
        """Return the way that the body of a leg had gone at `phase`, within this step [m]."""
        going, owner = self.going, int(self.herd.owner[leg])
        back = going.paces.way(owner, float(self.phase[owner]), np.array([phase]))
        return float(self.travelled[owner] + back[0] * math.sqrt(float(going.drive[owner])))

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

    def _bend(self, leg: int) -> Array | None:
        """Return what the swing of a leg has beside its arch."""
        return None if self.bend is None else self.bend[leg]

    def _is_posed(self, step: int, leg: int) -> bool:
        """Tell whether its author has a foot somewhere else: it meets no ground."""
        time = np.array([step * self.world.clock.dt])
        return bool(self.postures.of) and bool(self.postures.free(time)[0, leg] < 0.5)

    def _scuff(self, step: int, leg: int, fraction: float, span: float) -> None:
        """Let a foot that swings brush over the ground, `fraction` of a step after `step`."""
        heard = self.scuffing.heard(leg, span / self.world.clock.dt)
        if heard is not None and not self._is_posed(step, leg):
            scuff, speed = heard
            mass = scuff.weight * float(self._mass[leg])
            self._meet(step, fraction, leg, (scuff.place, scuff.normal), speed, mass, "scuff")

    def _touch(self, step: int, leg: int, fraction: float, span: float) -> None:
        """Put a foot down, `fraction` of a step after `step`."""
        owner = int(self.herd.owner[leg])
        self.swinging[leg] = False
        if self._is_posed(step, leg):
            return
        hold = self.holds[leg]
        time = self.going.cycle[owner] * float(self.span[leg])
        way, bend = (self.start[leg], hold.tip, self.height[leg]), self._bend(leg)
        speed = approach_speed(*way, hold.normal, time, bend)
        mass = float(self._mass[leg])
        self._meet(step, fraction, leg, (hold.place, hold.normal), speed, mass, "touch")
        slide = self.scuffing.landing(
            leg, self.start[leg], hold, float(self.height[leg]), span / self.world.clock.dt, bend
        )
        if slide is not None:
            scuff, speed = slide
            where = (scuff.place, scuff.normal)
            self._meet(step, fraction, leg, where, speed, scuff.weight * mass, "scuff")

    def _meet(
        self,
        step: int,
        fraction: float,
        leg: int,
        where: tuple[Array, Array],
        speed: float,
        mass: float,
        kind: ContactKind,
    ) -> None:
        """Note that a foot meets the ground.

        Args:
            step: the last one before it.
            fraction: of a step after that.
            leg: whose foot.
            where: (3,) place [m] and (3,) normal of the ground.
            speed: of what kind of contact it is [m/s].
            mass: that has this speed [kg].
            kind: of contact.
        """
        herd, owner = self.herd, int(self.herd.owner[leg])
        place, normal = where
        self._contacts.append(
            Contact(
                step=step,
                fraction=min(max(fraction, 0.0), np.nextafter(1.0, 0.0)),
                performer=herd.names[owner],
                part=f"{herd.names[owner]}.{herd.leg_names[leg]}",
                other="terrain",
                place=_plain(place),
                normal=_plain(normal),
                speed=speed,
                energy=0.5 * mass * speed * speed,
                material=self._foot_materials[leg],
                surface=self.world.ground.material,
                size=float(herd.legs.lengths[leg]),
                kind=kind,
            )
        )


def _plain(v: Array) -> tuple[float, float, float]:
    x, y, z = (float(c) for c in v)
    return x, y, z
