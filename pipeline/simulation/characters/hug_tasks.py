"""Hug tasks: putting both arms around somebody, letting go again, and hugging back.

Source: Horswill 2008, "Hugging".
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from pipeline.simulation.characters.body_arrays import NOBODY
from pipeline.simulation.characters.contact_tasks import CLOSING_INTERVAL, HELD_INTERVAL, PATIENCE
from pipeline.simulation.characters.encounter import (
    CLOSING_RATE,
    Encounter,
    closing_pace,
)
from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.characters.person_record import (
    PELVIS,
    SHOULDERS,
    SPINE,
    SWINGING,
)
from pipeline.simulation.characters.person_tasks import (
    Approach,
    Task,
    place_text,
    shoulder_height,
)
from pipeline.simulation.people.proportions import BACK_DEPTH, TRUNK_BREADTH
from pipeline.simulation.spatial import Array


@dataclass(frozen=True)
class HugShape:
    """Where arms go in a hug; lengths in heights of the partner or the person.

    Attributes:
        chest_radius: of either of the two.
        hand_depth: of the wrist of a hand that lies on a back, in heights of the person.
        hand_side: of such a wrist beside the spine, in heights of the person: the middle of the
            hand lies on the spine.
        side: of the wrist of a large hand beside the spine at most.
        open_side: of hands that pass the partner's sides, off its trunk.
        unsettled: by how much farther off a back hands stay until they are behind it.
        waist: height of the narrowest place of a trunk above the pelvis.
        blades: depth of a smaller one's shoulder blades below its shoulders, where hands lie.
        apart: of both hands above and below their middle, in heights of the person.
        descent: of hands below the own shoulders without a bow, in arm lengths.
        reach: largest part of an arm's reach to go around with.
        least_reach: part of that which an arm goes over the ground at least.
        closing_time: of the arms [s].
    """

    chest_radius: float = 0.075
    hand_depth: float = 0.014
    hand_side: float = 0.05
    side: float = 0.065
    open_side: float = 0.05
    unsettled: float = 0.05
    waist: float = 0.095
    blades: float = 0.09
    apart: float = 0.025
    descent: float = 0.42
    reach: float = 0.93
    least_reach: float = 0.5
    closing_time: float = 0.7


HUG = HugShape()

WRAP_POINTS = 24  # corners of the oval that arms go around

STEP_BACK = 0.25  # after a hug that an order ends [m]
OPEN_TIME = 0.7  # of the arms after a hug [s]
HUG_REACHED = 0.06  # from touching, within which arms close [m]
LOST_HUG = 0.45  # from touching, at which a partner is gone, in arm lengths
HUG_DEPTH = 0.02  # by which two press against each other [m]
GENTLER = 1.2  # rate of the last steps, in the usual one, by the size of a smaller partner
SLOWEST_CLOSING = 0.6  # of that rate, in the usual one
HUG_HELD = 0.08  # from touching, within which two are together [m]
HUG_PATIENCE = 3.0  # of one that gets no nearer with its arms closed [s]
TURNING_ROOM = 1.3  # from touching, left to a partner that turns, in the distance of touching
WAITING_ROOM = 1.5  # from touching, left to a partner that walks, in arm lengths
EMBRACE_DESCENT = 0.8  # of the hands below the own shoulders of one that does not face its partner
FACING = math.radians(40.0)  # turned away by less, one bows to a partner
BACK_HEIGHT = 0.65  # of hands on a back, from the pelvis up to the shoulders
TOUCHING = 0.5  # share of the closing time after which arms touch a partner
LOOSENED = 0.2  # distance from a trunk of arms that open, in that of arms that close
RECEIVING = 1.4  # opening of arms that receive somebody, in that of arms that close around one
STOOP_REACH = 0.4  # of hands below the own shoulders, beyond which one bows, in arm lengths


@dataclass
class Hug(Task):
    """Go to a character, put both arms around it, and lay the hands on its back.

    Attributes:
        owner: number of the partner.
        size: height of the partner [m].
        touched: time since the two touch [s], 0 before.
        encounter: with the partner.
        is_gentle: whether the last steps are slow.
        is_near: whether the person has opened its arms.
        is_answered: whether the partner has accepted or declined.
        is_turning: whether the partner is still turning to the person, which needs room.
        meeting: (2,) where the partner is walking to, which is kept clear until it is there [m];
            None for a partner that does not walk.
        apart: time for which the arms are closed and the two are not together [s].
        approach: to the partner.
    """

    owner: int
    size: float
    touched: float = 0.0
    encounter: Encounter = field(default_factory=Encounter)
    is_gentle: bool = True
    is_near: bool = False
    is_answered: bool = False
    is_turning: bool = False
    meeting: Array | None = None
    apart: float = 0.0
    approach: Approach = field(default_factory=Approach)

    @property
    def interval(self) -> int:
        """See `Task`; arms that are around somebody move little."""
        if self.touched == 0.0:
            return 1
        return HELD_INTERVAL if self.touched > 2.0 * HUG.closing_time else CLOSING_INTERVAL

    def closeness(self, controller: PersonController) -> float:
        """Return the distance between the two pelvises at which the bodies touch [m]."""
        return HUG.chest_radius * (float(controller.record.height) + self.size)

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        partner = controller.view.pelvis(self.owner)
        closeness = self.closeness(controller)
        distance = controller.ground_distance(partner)
        if self.touched == 0.0 and self.meeting is not None:
            self._keep_clear(controller, self.meeting, closeness, dt)
            return False
        if self.touched == 0.0 and distance > closeness + HUG_REACHED:
            share = self.encounter.share_of_way(controller, partner, closeness, dt)
            room = TURNING_ROOM * closeness if self.is_turning else -HUG_DEPTH
            stop = closeness + max(room, share - HUG_DEPTH)
            reason = self.approach.walk_to(controller, partner, stop, self.owner, dt)
            self.stick(reason, self.approach)
            if self.is_gentle:
                # The legs of a taller one would hurt a smaller one at the usual pace.
                ratio = GENTLER * self.size / float(controller.record.height)
                rate = CLOSING_RATE * min(max(ratio, SLOWEST_CLOSING), 1.0)
                self.most_pace = closing_pace(controller, distance - closeness - share, rate)
            if distance < closeness + 1.1 * controller.arm:
                self.is_near = True
                # Bowing only once the partner is there would knock heads.
                self._bow(controller)
                self._open_arms(controller)
            return False
        self.most_pace = math.inf
        if self.touched == 0.0:
            controller.face_to(partner)
        elif distance > closeness + LOST_HUG * controller.arm:
            # In a hug a person lets its partner go, and does not reach after it.
            self.is_lost, self.touched = self.touched > PATIENCE, 0.0
            return self.is_lost
        is_done = self.touched > PATIENCE
        if self.touched < TOUCHING * HUG.closing_time <= self.touched + dt:
            # Arms lie around somebody without pressing on it.
            controller.touched.append(controller.view.names[self.owner])
        self.touched += dt
        self._bow(controller)
        self._close_arms(controller)
        if not is_done and distance > closeness + HUG_HELD:
            self._draw_near(controller, partner, dt)
            self.touched = min(self.touched, PATIENCE)
        return self.touched > PATIENCE

    def _draw_near(self, controller: PersonController, partner: Array, dt: float) -> None:
        """Step up to a partner that the closed arms have not got hold of; give up in the end."""
        closeness = self.closeness(controller)
        self.most_pace = closing_pace(controller, 0.0)
        controller.go(partner[0], partner[2], closeness - HUG_DEPTH, self.owner)
        self.apart += dt
        if self.apart > HUG_PATIENCE:
            gap = controller.ground_distance(partner) - closeness
            self.stick(f"stays {gap:.2f} m away at {place_text(controller)}")

    def _keep_clear(
        self, controller: PersonController, meeting: Array, closeness: float, dt: float
    ) -> None:
        """Wait beside the place (2,) to which the partner walks [m]."""
        person = controller.record
        room = closeness + WAITING_ROOM * controller.arm
        place = np.array([meeting[0], 0.0, meeting[1]])
        left = controller.ground_distance(place)
        self.most_pace = math.inf
        if left > 0.85 * room:
            self.approach.walk_to(controller, place, room, NOBODY, dt)
            return
        # Off the place, with the eyes on the partner.
        way = -controller.direction_to(place if left > 0.1 else controller.view.pelvis(self.owner))
        controller.go(place[0] + room * way[0], place[2] + room * way[2])
        if left > 0.1:
            person.has_facing, person.facing = True, math.atan2(way[2], -way[0])

    def _bow(self, controller: PersonController) -> None:
        level = self._arm_level(controller, 0)
        controller.record.stoop_depth = max(
            shoulder_height(controller) - level - HUG.descent * controller.arm, 0.0
        )

    def loosen(self, controller: PersonController, dt: float) -> bool:
        """Open the arms as they were closed; tell whether they are open."""
        self.touched = max(min(self.touched, HUG.closing_time) - dt, 1e-6)
        self._lay_arms(controller, LOOSENED * HUG.unsettled * self.size)
        return self.touched <= dt

    def _arm_level(self, controller: PersonController, k: int) -> float:
        """Return the height at which an arm goes around: one under, one over the partner's."""
        nodes = controller.view.nodes(self.owner)
        low, high = float(nodes[PELVIS, 1]), float(nodes[SHOULDERS, 1])
        person = controller.record
        own = shoulder_height(controller)
        # The taller one's arms go over, the smaller one's under.
        is_taller = person.height > 1.05 * self.size
        top = high - (HUG.blades if is_taller else 0.06) * self.size
        # Round the waist at the lowest: no arm is long enough for hips.
        level = min(max(own - 0.1 * person.height, low + HUG.waist * self.size), top)
        apart = HUG.apart * float(person.height)
        return float(level + (apart if k == 0 else -apart))

    def _open_arms(self, controller: PersonController) -> None:
        """Hold both arms out, wide enough for the partner's shoulders."""
        person = controller.record
        controller.embrace(self.owner)
        ahead = controller.direction_to(controller.view.pelvis(self.owner))
        right = np.array([-ahead[2], 0.0, ahead[0]])
        start = np.array([person.at[0], 0.0, person.at[1]])
        for k in range(2):
            side = (1.0 if k == 1 else -1.0) * (0.15 * self.size + 0.03)
            place = start + 0.85 * controller.arm * ahead + side * right
            place[1] = self._arm_level(controller, k)
            controller.put_hand_around(k, place)

    def _close_arms(self, controller: PersonController) -> None:
        """Bring the hands together behind the partner's back."""
        # Hands that came nearer before they have passed the partner's arms would catch on them.
        settled = min(max(self.touched / HUG.closing_time - 1.0, 0.0), 1.0)
        self._lay_arms(controller, (1.0 - settled) * HUG.unsettled * self.size)

    def _lay_arms(self, controller: PersonController, off: float) -> None:
        """Lay the arms around the partner, at a distance from its trunk [m]."""
        controller.embrace(self.owner)
        opened = 1.0 - min(self.touched / HUG.closing_time, 1.0)
        for k in range(2):
            level = self._arm_level(controller, k)
            place = place_on_back(controller, self, k, level, (opened, off))
            controller.put_hand_around(k, place)


def place_on_back(
    controller: PersonController,
    hug: Hug | ReturnHug,
    k: int,
    level: float,
    opening: tuple[float, float],
) -> Array:
    """Return (3,) where the wrist of a hand that lies on somebody's back is.

    The arm goes around the partner's trunk as far as it reaches.

    Args:
        controller: of the person.
        hug: the partner and its size.
        k: number of the hand.
        level: height on the back [m].
        opening: how far the arms are open, from 0 on the partner's back to 1 beside it and beyond
            where they receive it; and how far they are off its trunk [m].
    """
    height, size = float(controller.record.height), hug.size
    ahead = controller.direction_to(controller.view.pelvis(hug.owner))
    aside = (1.0 if k == 1 else -1.0) * np.array([-ahead[2], 0.0, ahead[0]])
    spine = controller.view.nodes(hug.owner)[[PELVIS, SPINE, SHOULDERS]]
    x, z = (np.interp(level, spine[:, 1], spine[:, c]) for c in (0, 2))
    middle = np.array([x, level, z])
    start = controller.shoulder(k) - middle
    opened, off = opening
    off += HUG.hand_depth * height
    breadth = TRUNK_BREADTH * size + off + opened * HUG.open_side * size
    side = min(HUG.hand_side * height, HUG.side * size)
    end = math.acos(min((side + opened * (breadth - side)) / breadth, 1.0))
    reach = HUG.reach * controller.arm
    behind, beside = wrapped(
        (float(start @ ahead), float(start @ aside)),
        (BACK_DEPTH * size + off, breadth),
        end,
        # What is too high or too low is reached for all the same.
        math.sqrt(max(reach**2 - float(start[1]) ** 2, (HUG.least_reach * reach) ** 2)),
    )
    return middle + behind * ahead + beside * aside


def wrapped(
    start: tuple[float, float], oval: tuple[float, float], end: float, length: float
) -> tuple[float, float]:
    """Return where a string around an oval ends: behind its middle, and beside it [m].

    Args:
        start: of the string, likewise.
        oval: its reach behind and beside its middle [m].
        end: angle on the oval from its side to its back, beyond which the string does not go [rad].
        length: of the string [m].
    """
    angles = np.linspace(-0.5 * math.pi, end, WRAP_POINTS)
    points = np.stack([oval[0] * np.sin(angles), oval[1] * np.cos(angles)], axis=1)
    normals = np.stack([oval[1] * np.sin(angles), oval[0] * np.cos(angles)], axis=1)
    offsets = np.array(start) - points
    seen = np.flatnonzero((offsets * normals).sum(axis=1) > 0.0)
    # From inside it comes out at the nearest place.
    first = int(seen[-1]) if len(seen) else int((offsets * offsets).sum(axis=1).argmin())
    line = np.concatenate([[start], points[first:]])
    gone = np.concatenate([[0.0], np.linalg.norm(np.diff(line, axis=0), axis=1).cumsum()])
    behind, beside = (float(np.interp(length, gone, line[:, c])) for c in range(2))
    return behind, beside


@dataclass
class LoosenHug(Task):
    """Open the arms around a partner and step back, so that no arm is torn out.

    Attributes:
        hug: that ends.
        back: distance to step back [m].
        time: since the arms are open [s].
    """

    hug: Hug
    back: float = 0.0
    time: float = 0.0

    @property
    def interval(self) -> int:
        """See `Task`."""
        return CLOSING_INTERVAL

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        if self.time > 0.0 or self.hug.loosen(controller, dt):
            if self.time == 0.0:
                self._step_back(controller)
            self.time += dt
        self.is_lost = self.time > OPEN_TIME
        return self.is_lost

    def _step_back(self, controller: PersonController) -> None:
        """Let the arms sink, and step back facing the partner."""
        person = controller.record
        partner = controller.view.pelvis(self.hug.owner)
        x, z = person.at[0] - partner[0], person.at[1] - partner[2]
        share = self.back / max(math.hypot(x, z), 0.1)
        controller.go(person.at[0] + share * x, person.at[1] + share * z)
        person.has_facing, person.facing = True, math.atan2(z, -x)
        for k in range(2):
            if not controller.is_holding(k):
                person.arm_mode[k] = SWINGING


@dataclass
class ReturnHug(Task):
    """Bend down to an approaching partner with open arms, and put both hands on its back.

    Attributes:
        owner: number of the partner.
        size: height of the partner [m].
        closes: whether the partner is near enough for the hands to close.
        opens: whether the hands come off again.
        time: since they close or come off [s].
    """

    owner: int
    size: float
    closes: bool = False
    opens: bool = False
    time: float = 0.0

    @property
    def interval(self) -> int:
        """See `Task`; arms that are around somebody move little."""
        is_held = self.time > HUG.closing_time and not self.opens
        return HELD_INTERVAL if is_held else CLOSING_INTERVAL

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        person = controller.record
        nodes = controller.view.nodes(self.owner)
        partner, low = nodes[SHOULDERS], float(nodes[PELVIS, 1])
        if self.time == 0.0:
            controller.stop()
            controller.face_to(partner)
        controller.embrace(self.owner)
        self.time += dt if self.closes or self.opens else 0.0
        top, level = shoulder_height(controller), low + BACK_HEIGHT * (float(partner[1]) - low)
        person.stoop_depth = max(top - level - STOOP_REACH * controller.arm, 0.0)
        if not controller.is_facing(FACING):
            # It would bow past the partner.
            person.stoop_depth, level = 0.0, max(level, top - EMBRACE_DESCENT * controller.arm)
        share = min(self.time / HUG.closing_time, 1.0)
        opened = share if self.opens else 1.0 - share
        for k in range(2):
            apart = HUG.apart * float(person.height) * (1.0 if k == 0 else -1.0)
            place = place_on_back(controller, self, k, level + apart, (RECEIVING * opened, 0.0))
            controller.put_hand_around(k, place)
        return self.time > HUG.closing_time
