"""Errands: what somebody does until it is done, in stages.

Each is asked once a step, before control acts, and says whether it is done. What it goes on
with after that (a hug, a hand held out) it is still asked for.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from pipeline.simulation.characters.actor import SLIM, Actor
from pipeline.simulation.characters.record import (
    PELVIS,
    REACHING,
    SHOULDERS,
    SITTING,
    SPINE,
    STANDING,
)
from pipeline.simulation.characters.route import Route
from pipeline.simulation.spatial import Array

CHEST = 0.075
"""Radius of a chest, in heights."""

LONGEST = 0.95
"""Of a reach that arms are to go round somebody with."""

FLAT = 0.055
"""Depth of a back behind the spine, in heights: where hands lie that cannot meet behind it."""

WAIST = 0.085
"""Height of the narrowest place of a trunk above the pelvis, in heights."""

SEAT = 0.062
"""Height of the pelvis of one who sits above what it sits on, in heights."""

CLOSES = 0.7
"""How long arms take to close around somebody [s]."""

JOINS = 0.06
"""How near to one another hands are that join, in heights."""

PATIENCE = 1.6
"""How long a hand is waited for that cannot come quite where it should [s]."""


class Errand(Protocol):
    """Something that somebody does."""

    def go_on(self, actor: Actor, dt: float) -> bool:
        """Command somebody for the step of `dt` [s] to come; tell whether it is done."""


@dataclass
class Walk:
    """Walk to a place, round what stands on the straight way there.

    Attributes:
        goal: (2,) where to [m]; None to go as it was sent.
        route: the way round.
    """

    goal: Array | None = None
    route: Route = field(default_factory=Route)

    def go_on(self, actor: Actor, dt: float) -> bool:
        """See `Errand`."""
        me = actor.me
        if self.goal is not None and me.goes:
            middles, radii = actor.in_the_way()
            if len(radii):
                self._go_round(actor, middles, radii + SLIM * float(me.height))
        return not me.goes and actor.stands

    def _go_round(self, actor: Actor, middles: Array, reaches: Array) -> None:
        assert self.goal is not None
        within, at = np.stack(actor.stage.edges), np.array(actor.me.at)
        # An author's straight ways are kept wherever they can be gone.
        first, length = self.route.next(at, self.goal, middles, reaches, within, clearance=0.0)
        to = first - at
        # Nobody slows down for a corner as for the end of the way.
        straight = len(self.route.places) == 1
        actor.me.goal[:] = self.goal if straight else at + to * (length / math.hypot(*to))


@dataclass
class Turn:
    """Turn to a heading."""

    def go_on(self, actor: Actor, dt: float) -> bool:
        """See `Errand`."""
        done = actor.faces(math.radians(3.0)) and actor.stands
        if done:
            actor.me.faces = False
        return done


@dataclass
class Rise:
    """Stand up."""

    def go_on(self, actor: Actor, dt: float) -> bool:
        """See `Errand`."""
        actor.me.posture = STANDING
        return actor.stands


@dataclass
class SitDown:
    """Sit down on the ground."""

    def go_on(self, actor: Actor, dt: float) -> bool:
        """See `Errand`."""
        me = actor.me
        if me.seated == 0.0:
            back = 0.6 * (me.thigh + me.shin)
            x, z = me.at[0] - back * math.cos(me.heading), me.at[1] + back * math.sin(me.heading)
            me.seat[:] = back, actor.stage.height(x, z) + SEAT * me.height, -0.06
            me.goes, me.faces, me.posture = False, False, SITTING
        return bool(me.seated >= 1.0)


@dataclass
class SitOn:
    """Go to a thing, turn round and sit down on it.

    Attributes:
        owner: what it is.
        stage: 0 goes there, 1 turns round, 2 sits down.
    """

    owner: int
    stage: int = 0

    def go_on(self, actor: Actor, dt: float) -> bool:
        """See `Errand`."""
        me = actor.me
        nodes = actor.stage.nodes(self.owner)
        middle = nodes.mean(axis=0)
        ahead, half = _front(nodes, actor)
        back = max(0.92 * me.thigh, half + 0.08 * me.height - 0.04)
        spot = middle + back * ahead
        if self.stage == 0:
            actor.go(spot[0], spot[2])
            self.stage = 1
        elif self.stage == 1 and not me.goes and not me.stepping:
            actor.turn_to(math.atan2(-ahead[2], ahead[0]))
            self.stage = 2
        elif self.stage == 2 and me.seated == 0.0 and actor.faces(0.08) and actor.stands:
            me.faces, me.posture = False, SITTING
            me.seat[:] = back, float(nodes[:, 1].max()) + SEAT * me.height, 0.02
        return bool(me.seated >= 1.0)


def _front(nodes: Array, actor: Actor) -> tuple[Array, float]:
    """Return the side (3,) of a thing to sit down at, across its length, and half its depth [m]."""
    flat = nodes - nodes.mean(axis=0)
    flat[:, 1] = 0.0
    xx, zz = float((flat[:, 0] ** 2).sum()), float((flat[:, 2] ** 2).sum())
    xz = float((flat[:, 0] * flat[:, 2]).sum())
    # The longer of the two principal directions; the front is across it.
    angle = 0.5 * math.atan2(2.0 * xz, xx - zz)
    ahead = np.array([-math.sin(angle), 0.0, math.cos(angle)])
    to_me = actor.me.at - nodes.mean(axis=0)[[0, 2]]
    if ahead[0] * to_me[0] + ahead[2] * to_me[1] < 0.0:
        ahead = -ahead
    return ahead, float((flat * ahead).sum(axis=1).max())


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

    def go_on(self, actor: Actor, dt: float) -> bool:
        """See `Errand`."""
        place = actor.stage.middle(self.owner) if self.place is None else self.place
        self.time += dt
        near = True
        for k in self.hands:
            actor.put_hand(k, place)
            near = near and math.dist(actor.hand(k), place) < 0.04 * actor.me.height
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

    def go_on(self, actor: Actor, dt: float) -> bool:
        """See `Errand`."""
        me, crowd = actor.me, actor.stage.crowd
        for k in self.hands:
            self.taken.setdefault(k, actor.part(self.owner, self.part, k))
        if all(actor.held(k) >= 0 for k in self.hands):
            return True
        first = crowd.p[self.taken[self.hands[0]]]
        # Bowing and crouching bring shoulders forward over what is low.
        near = (0.8 if first[1] > 0.4 * me.height else 0.62) * actor.arm
        if actor.away(first) > near + 0.12 * actor.arm:
            actor.go(first[0], first[2], near, self.owner)
            if self.part is None:
                self.taken.clear()
            return False
        if me.goes:
            actor.face_to(first)
        self.time += dt
        close = (0.05 if self.time < PATIENCE else 0.09) * me.height
        for k in self.hands:
            node = self.taken[k]
            actor.put_hand(k, crowd.p[node])
            if math.dist(actor.hand(k), crowd.p[node]) < close:
                actor.hold(k, node)
                me.faces = False
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

    def go_on(self, actor: Actor, dt: float) -> bool:
        """See `Errand`."""
        me = actor.me
        other = actor.stage.pelvis(self.owner)
        close = CHEST * (me.height + self.size)
        away = actor.away(other)
        if self.touched == 0.0 and away > close + 0.06:
            actor.go(other[0], other[2], close - 0.06, self.owner)
            if away < close + 1.1 * actor.arm:
                # Who bows only once the other is there knocks heads.
                self._bow(actor)
                self._open(actor)
            return False
        if self.touched == 0.0:
            actor.face_to(other)
        self.touched += dt
        self._bow(actor)
        self._close(actor, other)
        if self.touched > CLOSES and math.dist(actor.hand(0), actor.hand(1)) < JOINS * me.height:
            actor.join_hands()
        return self.touched > PATIENCE

    def _bow(self, actor: Actor) -> None:
        """Come down to one who is smaller."""
        me = actor.me
        stands = float(me.floor + me.hip_height + me.belly + me.chest)
        me.down = max(stands - self._level(actor, 0) - 0.3 * actor.arm, 0.0)

    def loosen(self, actor: Actor, dt: float) -> bool:
        """Open the arms again as they were closed; tell whether they are open."""
        actor.part_hands()
        self.touched = max(min(self.touched, CLOSES) - dt, 1e-6)
        self._close(actor, actor.stage.pelvis(self.owner))
        return self.touched <= dt

    def _level(self, actor: Actor, k: int) -> float:
        """Return the height at which an arm goes round: one under, one over the other's."""
        nodes = actor.stage.nodes(self.owner)
        low, high = float(nodes[PELVIS, 1]), float(nodes[SHOULDERS, 1])
        me = actor.me
        own = float(me.floor + me.hip_height + me.belly + me.chest)
        # The taller one's arms go over, the smaller one's under.
        taller = me.height > 1.05 * self.size
        top = high + (0.02 if taller else -0.06) * self.size
        # Round the waist at the lowest: no arm is long enough for hips.
        level = min(max(own - 0.1 * me.height, low + WAIST * self.size), top)
        apart = (0.01 if taller else 0.03) * me.height
        return float(level + (apart if k == 0 else -apart))

    def _open(self, actor: Actor) -> None:
        """Hold both arms out, wide enough for the other's shoulders."""
        me = actor.me
        actor.embrace(self.owner)
        other = actor.stage.pelvis(self.owner)
        ahead = _towards(actor, other)
        right = np.array([-ahead[2], 0.0, ahead[0]])
        start = np.array([me.at[0], 0.0, me.at[1]])
        for k in range(2):
            side = (1.0 if k == 1 else -1.0) * (0.15 * self.size + 0.03)
            place = start + 0.85 * actor.arm * ahead + side * right
            place[1] = self._level(actor, k)
            actor.put_round(k, place)

    def _close(self, actor: Actor, other: Array) -> None:
        """Bring the hands together behind the other's back."""
        actor.embrace(self.owner)
        ahead = _towards(actor, other)
        right = np.array([-ahead[2], 0.0, ahead[0]])
        full = CHEST * self.size + 0.035 * actor.me.height
        reach = math.sqrt(max(actor.arm**2 - float(actor.me.shoulders) ** 2, 0.0))
        # First past the other's sides, then together.
        shut = min(self.touched / CLOSES, 1.0)
        wide = (1.0 - shut) * 0.13 * self.size + 0.02 * self.size
        for k in range(2):
            side = (1.0 if k == 1 else -1.0) * wide
            middle = self._middle(actor, self._level(actor, k))
            behind = min(full, max(LONGEST * reach - actor.away(middle), FLAT * self.size))
            actor.put_round(k, middle + behind * ahead + side * right)

    def _middle(self, actor: Actor, level: float) -> Array:
        """Return the middle (3,) of the other's trunk at a height, however it leans [m]."""
        spine = actor.stage.nodes(self.owner)[[PELVIS, SPINE, SHOULDERS]]
        x, z = (np.interp(level, spine[:, 1], spine[:, c]) for c in (0, 2))
        return np.array([x, level, z])


def _towards(actor: Actor, place: Array) -> Array:
    """Return the level direction (3,) to a place."""
    way = np.array([place[0] - actor.me.at[0], 0.0, place[2] - actor.me.at[1]])
    size = math.hypot(way[0], way[2])
    if size < 1e-9:
        return np.array([math.cos(actor.me.heading), 0.0, -math.sin(actor.me.heading)])
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

    def go_on(self, actor: Actor, dt: float) -> bool:
        """See `Errand`."""
        other = actor.stage.pelvis(self.owner)
        actor.go(other[0], other[2], 0.25 * actor.arm, self.owner)
        if actor.away(other) < 1.3 * actor.arm:
            for k in range(2):
                actor.me.arm[k] = REACHING
            self.time += dt
        done = self.time > PATIENCE
        if done:
            actor.stop()
        return done
