"""Events of a hop: feet and body meeting the ground, the margins until then, and their records.

While the body falls, feet in the air are tested against the ground; while it rises they are
lifted over obstacles. Legs of feet that are down are tested for their stretch and, while the body
sinks, for their fold. A take records the events as contacts and notes.

Source: Sims 1987, 9.4 and 11.1.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.inventory import foot_materials
from pipeline.simulation.locomotion.pronking.flight_swing import SwingPath
from pipeline.simulation.locomotion.pronking.hop_state import BodyState, HopState
from pipeline.simulation.locomotion.pronking.hopper import STANCE_STRETCH, Hopper
from pipeline.simulation.locomotion.swing.swing_trajectory import lowest_center_height
from pipeline.simulation.scalar_rotation import vector_tuple
from pipeline.simulation.spatial import UP, Array
from pipeline.simulation.take import Contact, ContactKind, TakeNote
from pipeline.simulation.terrain import Ground
from pipeline.simulation.troupe import World

WALL_HEIGHT = 0.06
"""Sudden lift of a foot that counts as hitting a wall, in leg lengths."""

WALL_BOUNCE = 0.2
"""Speed with which a wall throws a foot back, in that with which it came."""

LEAST_SWING = 0.1
"""Shortest time in which a foot that a wall caught reaches its landing place [s]."""

SETTLE_DISTANCE = 0.16
"""How far a body sinks after the first touch until its legs carry, in leg lengths."""

FOLD_LIMIT = 1.01
"""Nearest distance of a foot to its hip, in folded lengths."""

RISING_SPEED = 1e-9
"""Vertical speed above which a body rises [m/s]."""

HopEventKind = Literal[
    "touch", "lift", "body", "toppled", "saturated", "stopped", "misplaced", "tripped", "dropped"
]

CONTACT_KINDS: dict[str, ContactKind] = {"touch": "touch", "lift": "lift", "body": "hit"}

NOTE_KINDS = {
    "toppled": "toppled",
    "saturated": "clamped",
    "stopped": "stopped",
    "misplaced": "misplaced",
    "tripped": "tripped",
    "dropped": "dropped",
}


@dataclass(frozen=True, eq=False)
class HopEvent:
    """An event.

    Attributes:
        kind: of event.
        time: [s].
        leg: number of the leg, -1 for the body.
        place: (3,) [m].
        normal: (3,) of the ground.
        speed: along the normal [m/s].
        energy: kinetic energy of the moving mass at that speed [J].
        text: of the note.
        link: number of the link, for events of the body.
    """

    kind: HopEventKind
    time: float
    leg: int
    place: Array
    normal: Array
    speed: float
    energy: float
    text: str = ""
    link: int = 0

    @staticmethod
    def note(kind: HopEventKind, time: float, text: str, leg: int = -1) -> HopEvent:
        """Return an event that a take records as a note."""
        return HopEvent(kind, time, leg, np.zeros(3), UP, 0.0, 0.0, text)


HopEvents = list[HopEvent]
"""Events in the order of time."""


# --- feet ---------------------------------------------------------------------------


def touch(
    hopper: Hopper,
    ground: Ground,
    state: HopState,
    legs: NDArray[np.int64],
    met: NDArray[np.bool_],
    events: HopEvents,
) -> None:
    """Plant feet where they are; these are their footholds until the next lift-off.

    Args:
        hopper: the creature.
        ground: that they touch.
        state: in flight or landing.
        legs: numbers of the feet.
        met: (n,) feet that reached the ground in this step; the others were lifted over it.
        events: collects what happens.
    """
    now, own = state.body(hopper), state.swing.tips(state.time)
    tips = now.to_world(own)
    moves = now.R @ ((own - state.swing.tips(state.time - 1e-5)) / 1e-5).T
    v = state.v + np.cross(now.rate, tips - state.p) + moves.T
    if not state.down.any():
        state.first_touch_height = float(state.p[1])
    caught, floors = (
        list[int](),
        lowest_center_height(ground, tips[:, 0], tips[:, 2], hopper.foot_radii),
    )
    for leg in legs.tolist():
        (x, y, z), least = tips[leg].tolist(), float(floors[leg])
        if met[leg] and least - y > WALL_HEIGHT * hopper.leg_length:
            caught.append(leg)
        else:
            y = max(least, y)
        state.tips[leg], state.down[leg] = (x, y, z), True
        place, normal = np.array([x, y - hopper.foot_radii[leg], z]), ground.normal(x, z)
        speed = max(-float(normal @ v[leg]), 0.0)
        energy = 0.5 * hopper.mass.mass / len(hopper.hips) * speed * speed
        events.append(HopEvent("touch", state.time, leg, place, normal, speed, energy))
        if not bool(ground.steppable(x, z)):
            text = f"a foot landed in a forbidden zone, at [{x:.2f}, {z:.2f}]"
            events.append(HopEvent.note("misplaced", state.time, text, leg))
    if caught:
        _catch_feet(hopper, state, np.array(caught), tips, v, events)


def trip_on_wall(
    hopper: Hopper, state: HopState, legs: NDArray[np.int64], tips: Array, events: HopEvents
) -> None:
    """Trip on a wall with feet (n, 3) that move with the body."""
    v = state.v + np.cross(state.body(hopper).rate, tips - state.p)
    _catch_feet(hopper, state, legs, tips, v, events)


def swing_from_wall(
    swing: SwingPath,
    caught: NDArray[np.bool_],
    bodies: tuple[BodyState, BodyState],
    tips: tuple[Array, Array],
) -> SwingPath:
    """Return the paths of feet of which some go on from the wall that caught them.

    A caught foot comes up along the wall, thrown back a little, and then goes on to its landing.

    Args:
        swing: paths so far.
        caught: (n,) feet.
        bodies: before the wall was met, and now.
        tips: (n, 3) feet before the wall was met, and now if there were none [m].
    """
    (before, now), (outside, inside) = bodies, tips
    moved = (inside - outside) / max(now.time - before.time, 1e-9)
    start = np.stack([outside[:, 0], inside[:, 1], outside[:, 2]], axis=-1)
    velocity = moved * [-WALL_BOUNCE, 1.0, -WALL_BOUNCE]
    velocity[:, 1] = np.maximum(velocity[:, 1], 0.0)
    arm = start - now.p
    seen = velocity - now.v - np.cross(now.rate, arm)
    left = max(float((swing.begin + swing.time)[caught].min()) - now.time, LEAST_SWING)
    own = (start - now.origin) @ now.R
    return swing.restarted(caught, now.time, own, left, (swing.middle, seen @ now.R))


def _catch_feet(
    hopper: Hopper,
    state: HopState,
    legs: NDArray[np.int64],
    tips: Array,
    v: Array,
    events: HopEvents,
) -> None:
    """Apply the impulses of feet that a wall stops.

    Each stops the mass of its leg, as far as the body behind it does not give way: (K + 1/m) J = -v
    with K the inverse inertia of the body at the feet. Without K, long legs that are caught
    together would add energy.

    Source: Sims 1987, 9.4; Baraff and Witkin 1997, rigid body dynamics, (8.18).
    """
    R = state.body(hopper).R
    inverse = R @ np.array(hopper.inertia.inverse) @ R.T
    # Columns: what unit impulses along x and z do to momentum and angular momentum.
    unit = np.broadcast_to(np.eye(3)[[0, 2]], (len(legs), 2, 3))
    linear = unit.reshape(-1, 3).T
    angular = np.cross((tips[legs] - state.p)[:, None], unit).reshape(-1, 3).T
    gives_way = linear.T @ linear / hopper.mass.mass + angular.T @ inverse @ angular
    light = np.diag(np.repeat(1.0 / hopper.leg_masses[legs], 2))
    impulse = -np.linalg.solve(gives_way + light, v[legs][:, [0, 2]].ravel())
    state.v = state.v + linear @ impulse / hopper.mass.mass
    x, y, z = (state.attitude[1] + inverse @ angular @ impulse).tolist()
    state.attitude = state.attitude[0], (x, y, z)
    for leg in legs.tolist():
        events.append(HopEvent.note("tripped", state.time, "a foot caught on a wall", leg))


@dataclass(frozen=True, eq=False)
class EventMargins:
    """Distances until events; infinite for those that cannot happen [m].

    Attributes:
        touch: (n,) of feet above the ground.
        stretch, fold: (n,) of legs to their limits.
        belly: (1,) of the body above the ground.
        grace: (1,) that the body may sink until its legs carry.
    """

    touch: Array
    stretch: Array
    fold: Array
    belly: Array
    grace: Array

    @property
    def all(self) -> Array:
        """All margins in one array."""
        return np.concatenate([self.touch, self.stretch, self.fold, self.belly, self.grace])


def event_margins(
    hopper: Hopper, state: HopState, ground: Ground, body: BodyState, highest: float
) -> EventMargins:
    """Return the margins at a time of the phase.

    Args:
        hopper: the creature.
        state: at the start of a sub-step.
        ground: below it.
        body: at the time.
        highest: greatest height of the ground [m].
    """
    n = len(hopper.hips)
    touch, stretch, fold, belly, grace = (np.full(k, np.inf) for k in (n, n, n, 1, 1))
    falls = body.v[1] <= RISING_SPEED
    if state.phase in ("flight", "landing") and falls and not state.down.all():
        tips = body.to_world(state.swing.tips(body.time))
        if float(tips[:, 1].min()) - float(hopper.foot_radii.max()) < highest + 0.05:
            # In flight a foot may come down again, once it is drawn in.
            drawn_in = body.time >= state.swing.begin + state.swing.time
            air = ~state.down & ~(state.released & ((state.phase == "landing") | ~drawn_in))
            touch[air] = (
                tips[:, 1] - lowest_center_height(ground, tips[:, 0], tips[:, 2], hopper.foot_radii)
            )[air]
    if state.down.any() and state.phase not in ("standing",):
        legs = body.to_world(hopper.hips) - state.tips
        distance = np.sqrt((legs * legs).sum(axis=-1))
        down = state.down
        stretch[down] = (STANCE_STRETCH * hopper.leg_lengths - distance)[down]
        if state.phase in ("flight", "landing"):
            fold[down] = (distance - FOLD_LIMIT * hopper.folded_lengths)[down]
    if state.body_armed and state.phase != "standing":
        belly[0] = body_clearance(hopper, ground, body, highest)
    if state.phase == "flight" and state.down.any():
        grace[0] = body.p[1] - (state.first_touch_height - SETTLE_DISTANCE * hopper.leg_length)
    return EventMargins(touch, stretch, fold, belly, grace)


def body_clearance(
    hopper: Hopper, ground: Ground, body: BodyState, highest: float = np.inf
) -> float:
    """Return the least height of the body above the ground [m]."""
    points = body.to_world(hopper.belly_points)
    if float(points[:, 1].min()) > highest + 0.5:
        return float(points[:, 1].min()) - highest
    return float((points[:, 1] - ground.height(points[:, 0], points[:, 2])).min())


def lift_above_ground(hopper: Hopper, ground: Ground, tips: Array, highest: float) -> Array:
    """Return feet (n, 3) lifted out of the ground [m]."""
    if float(tips[:, 1].min()) - float(hopper.foot_radii.max()) > highest:
        return tips
    result = tips.copy()
    np.maximum(
        tips[:, 1],
        lowest_center_height(ground, tips[:, 0], tips[:, 2], hopper.foot_radii),
        out=result[:, 1],
    )
    return result


# --- records of a take --------------------------------------------------------------


class HopEventRecorder:
    """Converts the events of a herd to the contacts and notes of a take.

    Attributes:
        herd: the creatures.
        world: of the simulation.
        materials: of each creature's links that name none.
    """

    def __init__(self, herd: Herd, world: World, materials: Sequence[str]) -> None:
        self.herd, self.world, self.materials = herd, world, list(materials)
        self._feet = foot_materials(herd, materials)

    def part(self, leg: int) -> str:
        """Return the part name of a leg."""
        return f"{self.herd.names[self.herd.owner[leg]]}.{self.herd.leg_names[leg]}"

    def records(
        self, step: int, c: int, events: Iterable[HopEvent]
    ) -> tuple[list[Contact], list[TakeNote]]:
        """Return the contacts and notes of creature `c` in a step."""
        contacts, notes = list[Contact](), list[TakeNote]()
        for event in events:
            record = self._record(step, c, event)
            if isinstance(record, TakeNote):
                notes.append(record)
            else:
                contacts.append(record)
        return contacts, notes

    def _record(self, step: int, c: int, event: HopEvent) -> Contact | TakeNote:
        herd, name = self.herd, self.herd.names[c]
        link = herd.figures[c].skeleton.links[event.link]
        leg = int(herd.first_leg[c]) + event.leg
        part = f"{name}.{link.name}" if event.leg < 0 else self.part(leg)
        if event.kind in NOTE_KINDS:
            return TakeNote(NOTE_KINDS[event.kind], step, part, event.text)
        dt = self.world.clock.dt
        fraction = min(max(event.time / dt - step, 0.0), float(np.nextafter(1.0, 0.0)))
        body = link.material or self.materials[c]
        length = self._length(c, event.link)
        return Contact(
            step=step,
            fraction=fraction,
            performer=name,
            part=part,
            other="terrain",
            place=vector_tuple(event.place),
            normal=vector_tuple(event.normal),
            speed=event.speed,
            energy=event.energy,
            material=body if event.leg < 0 else self._feet[leg],
            surface=self.world.ground.material,
            size=length if event.leg < 0 else float(herd.legs.lengths[leg]),
            kind=CONTACT_KINDS[event.kind],
        )

    def _length(self, c: int, link: int) -> float:
        figure = self.herd.figures[c]
        return next(piece.size for piece in figure.pieces if piece.link == link)
