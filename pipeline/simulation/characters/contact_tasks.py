"""Contact tasks."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.characters.person_record import PELVIS, REACHING, SHOULDERS, SPINE
from pipeline.simulation.spatial import Array

CHEST = 0.075
"""Radius of a chest, in heights."""

LONGEST = 0.95
"""Of a reach that arms are to go round somebody with."""

FLAT = 0.055
"""Depth of a back behind the spine, in heights: where hands lie that cannot meet behind it."""

WAIST = 0.085
"""Height of the narrowest place of a trunk above the pelvis, in heights."""

CLOSES = 0.7
"""How long arms take to close around somebody [s]."""

JOINS = 0.06
"""How near to one another hands are that join, in heights."""

PATIENCE = 1.6
"""How long a hand is waited for that cannot come quite where it should [s]."""


@dataclass
class Reach:
    """Hold hands out to a place or to somebody.

    Attributes:
        hands: which.
        place: where (3,) [m]; None for somebody.
        owner: whom.
        time: since it began [s].
    """

    hands: tuple[int, ...]
    place: Array | None
    owner: int = -1
    time: float = 0.0

    def go_on(self, controller: PersonController, dt: float) -> bool:
        """See `Errand`."""
        place = controller.view.middle(self.owner) if self.place is None else self.place
        self.time += dt
        near = True
        for k in self.hands:
            controller.put_hand(k, place)
            near = near and math.dist(controller.hand(k), place) < 0.04 * controller.record.height
        return near or self.time > PATIENCE


@dataclass
class Grab:
    """Go to something and close hands around it.

    Attributes:
        hands: which.
        owner: what or whom.
        part: the joint that is taken, None for what is nearest.
        taken: node of each hand that is on its way or holds.
        time: since it is near [s].
    """

    hands: tuple[int, ...]
    owner: int
    part: str | None = None
    taken: dict[int, int] = field(default_factory=dict)
    time: float = 0.0

    def go_on(self, controller: PersonController, dt: float) -> bool:
        """See `Errand`."""
        me, arrays = controller.record, controller.view.arrays
        for k in self.hands:
            self.taken.setdefault(k, controller.part(self.owner, self.part, k))
        if all(controller.held(k) >= 0 for k in self.hands):
            return True
        first = arrays.p[self.taken[self.hands[0]]]
        # Bowing and crouching bring shoulders forward over what is low.
        near = (0.8 if first[1] > 0.4 * me.height else 0.62) * controller.arm
        if controller.away(first) > near + 0.12 * controller.arm:
            controller.go(first[0], first[2], near, self.owner)
            if self.part is None:
                self.taken.clear()
            return False
        if me.has_goal:
            controller.face_to(first)
        self.time += dt
        close = (0.05 if self.time < PATIENCE else 0.09) * me.height
        for k in self.hands:
            node = self.taken[k]
            controller.put_hand(k, arrays.p[node])
            if math.dist(controller.hand(k), arrays.p[node]) < close:
                controller.hold(k, node)
                me.has_facing = False
        return False


@dataclass
class Hug:
    """Go to somebody, put both arms around them, and join the hands.

    Source: Horswill 2008, "Hugging".

    Attributes:
        owner: whom.
        size: height of the other [m].
        touched: how long they have touched [s], 0 before.
    """

    owner: int
    size: float
    touched: float = 0.0

    def go_on(self, controller: PersonController, dt: float) -> bool:
        """See `Errand`."""
        me = controller.record
        other = controller.view.pelvis(self.owner)
        close = CHEST * (me.height + self.size)
        away = controller.away(other)
        if self.touched == 0.0 and away > close + 0.06:
            controller.go(other[0], other[2], close - 0.06, self.owner)
            if away < close + 1.1 * controller.arm:
                # Who bows only once the other is there knocks heads.
                self._bow(controller)
                self._open(controller)
            return False
        if self.touched == 0.0:
            controller.face_to(other)
        self.touched += dt
        self._bow(controller)
        self._close(controller, other)
        if (
            self.touched > CLOSES
            and math.dist(controller.hand(0), controller.hand(1)) < JOINS * me.height
        ):
            controller.join_hands()
        return self.touched > PATIENCE

    def _bow(self, controller: PersonController) -> None:
        """Come down to one who is smaller."""
        me = controller.record
        stands = float(me.floor + me.hip_height + me.belly + me.chest)
        me.stoop_depth = max(stands - self._level(controller, 0) - 0.3 * controller.arm, 0.0)

    def loosen(self, controller: PersonController, dt: float) -> bool:
        """Open the arms again as they were closed; tell whether they are open."""
        controller.part_hands()
        self.touched = max(min(self.touched, CLOSES) - dt, 1e-6)
        self._close(controller, controller.view.pelvis(self.owner))
        return self.touched <= dt

    def _level(self, controller: PersonController, k: int) -> float:
        """Return the height at which an arm goes round: one under, one over the other's."""
        nodes = controller.view.nodes(self.owner)
        low, high = float(nodes[PELVIS, 1]), float(nodes[SHOULDERS, 1])
        me = controller.record
        own = float(me.floor + me.hip_height + me.belly + me.chest)
        # The taller one's arms go over, the smaller one's under.
        taller = me.height > 1.05 * self.size
        top = high + (0.02 if taller else -0.06) * self.size
        # Round the waist at the lowest: no arm is long enough for hips.
        level = min(max(own - 0.1 * me.height, low + WAIST * self.size), top)
        apart = (0.01 if taller else 0.03) * me.height
        return float(level + (apart if k == 0 else -apart))

    def _open(self, controller: PersonController) -> None:
        """Hold both arms out, wide enough for the other's shoulders."""
        me = controller.record
        controller.embrace(self.owner)
        other = controller.view.pelvis(self.owner)
        ahead = _towards(controller, other)
        right = np.array([-ahead[2], 0.0, ahead[0]])
        start = np.array([me.at[0], 0.0, me.at[1]])
        for k in range(2):
            side = (1.0 if k == 1 else -1.0) * (0.15 * self.size + 0.03)
            place = start + 0.85 * controller.arm * ahead + side * right
            place[1] = self._level(controller, k)
            controller.put_round(k, place)

    def _close(self, controller: PersonController, other: Array) -> None:
        """Bring the hands together behind the other's back."""
        controller.embrace(self.owner)
        ahead = _towards(controller, other)
        right = np.array([-ahead[2], 0.0, ahead[0]])
        full = CHEST * self.size + 0.035 * controller.record.height
        reach = math.sqrt(max(controller.arm**2 - float(controller.record.shoulders) ** 2, 0.0))
        # First past the other's sides, then together.
        shut = min(self.touched / CLOSES, 1.0)
        wide = (1.0 - shut) * 0.13 * self.size + 0.02 * self.size
        for k in range(2):
            side = (1.0 if k == 1 else -1.0) * wide
            middle = self._middle(controller, self._level(controller, k))
            behind = min(full, max(LONGEST * reach - controller.away(middle), FLAT * self.size))
            controller.put_round(k, middle + behind * ahead + side * right)

    def _middle(self, controller: PersonController, level: float) -> Array:
        """Return the middle (3,) of the other's trunk at a height, however it leans [m]."""
        spine = controller.view.nodes(self.owner)[[PELVIS, SPINE, SHOULDERS]]
        x, z = (np.interp(level, spine[:, 1], spine[:, c]) for c in (0, 2))
        return np.array([x, level, z])


def _towards(controller: PersonController, place: Array) -> Array:
    """Return the level direction (3,) to a place."""
    way = np.array([place[0] - controller.record.at[0], 0.0, place[2] - controller.record.at[1]])
    size = math.hypot(way[0], way[2])
    if size < 1e-9:
        return np.array(
            [math.cos(controller.record.heading), 0.0, -math.sin(controller.record.heading)]
        )
    result: Array = way / size
    return result


@dataclass
class Grapple:
    """Go to somebody with both arms ahead.

    Source: Horswill 2008, "Grappling".

    Attributes:
        owner: whom.
        time: since the arms came up [s].
    """

    owner: int
    time: float = 0.0

    def go_on(self, controller: PersonController, dt: float) -> bool:
        """See `Errand`."""
        other = controller.view.pelvis(self.owner)
        controller.go(other[0], other[2], 0.25 * controller.arm, self.owner)
        if controller.away(other) < 1.3 * controller.arm:
            for k in range(2):
                controller.record.arm_mode[k] = REACHING
            self.time += dt
        done = self.time > PATIENCE
        if done:
            controller.stop()
        return done


OPEN, BACK = 0.7, 0.45
"""How long arms stay open after a hug [s], and how far one steps back from it [m]."""

CLOSE, UPRIGHT = 0.2, 0.8
"""From this gap on somebody is embraced [m], no lower than this part of an arm under the own
shoulders."""


@dataclass
class Loosen:
    """Open the arms around somebody and step back, before anything else: no arm is torn out.

    Attributes:
        hug: that ends.
        back: how far to step back [m].
        time: since the arms are open [s].
    """

    hug: Hug
    back: float = 0.0
    time: float = 0.0

    def go_on(self, controller: PersonController, dt: float) -> bool:
        """See `Errand`."""
        if self.hug.loosen(controller, dt):
            if self.time == 0.0 and self.back > 0.0:
                other = controller.view.pelvis(self.hug.owner)
                x, z = controller.record.at[0] - other[0], controller.record.at[1] - other[2]
                share = self.back / max(math.hypot(x, z), 0.1)
                controller.go(
                    controller.record.at[0] + share * x, controller.record.at[1] + share * z
                )
                controller.record.has_facing, controller.record.facing = True, math.atan2(z, -x)
            self.time += dt
        return self.time > OPEN


@dataclass
class Embrace:
    """Put both hands on the back of one who has come, without a step and without bowing.

    Attributes:
        owner: whom.
        size: how high it stands [m].
        opens: whether the hands come off again, after.
        time: since they do, or since it began [s].
    """

    owner: int
    size: float
    opens: bool = False
    time: float = 0.0

    def go_on(self, controller: PersonController, dt: float) -> bool:
        """See `Errand`."""
        me = controller.record
        if self.time == 0.0:
            controller.stop()
            me.has_facing = False
        controller.embrace(self.owner)
        self.time += dt
        other = controller.view.middle(self.owner)
        ahead = np.array([other[0] - me.at[0], other[2] - me.at[1]])
        ahead /= max(math.hypot(ahead[0], ahead[1]), 1e-6)
        share = min(self.time / CLOSES, 1.0)
        wide = self.size * (0.2 - 0.14 * (1.0 - share if self.opens else share))
        standing = float(me.floor + me.hip_height + me.belly + me.chest)
        high = max(float(other[1]) - 0.03 * self.size, standing - UPRIGHT * controller.arm)
        for k in range(2):
            side = wide if k == 1 else -wide
            x = other[0] + 0.11 * self.size * ahead[0] - side * ahead[1]
            z = other[2] + 0.11 * self.size * ahead[1] + side * ahead[0]
            controller.put_hand(k, np.array([x, high, z]))
        return self.time > CLOSES
