"""Perception."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.characters.body_arrays import IntArray
from pipeline.simulation.characters.person_controller import SLIM, CharacterView
from pipeline.simulation.characters.person_record import PELVIS
from pipeline.simulation.spatial import Array


class Surroundings:
    """All characters by arrays, one row each.

    Attributes:
        view: where they are.
        kinds: what they are.
        people: (C,) who has the joints of people.
        radius: (C,) of the circle on the ground around each [m].
        places: (C, 3) their middles, of people their pelvises [m].
        velocities: (C, 3) of these [m/s].
        low: (2,) least x and z of the terrain [m].
        high: (2,) likewise the greatest.
        now: the time [s].
    """

    def __init__(self, view: CharacterView, kinds: Sequence[str], heights: Sequence[float]) -> None:
        self.view, self.kinds = view, tuple(kinds)
        owners = view.arrays.owners
        self._firsts: IntArray = owners["nodes"][:, 0].copy()
        self._counts: Array = owners["nodes"][:, 1].astype(float)
        self.people = np.array([k in view.people for k in range(len(kinds))], dtype=bool)
        self._pelvises = self._firsts[self.people] + PELVIS
        self.radius = np.array([view.circle(k)[1] for k in range(len(kinds))])
        self.radius[self.people] = SLIM * np.array(heights)[self.people]
        self.low, self.high = view.edges
        self._p, self._before = view.arrays.p, view.arrays.previous
        self.now = -1.0
        self.look(0.0, 1.0)

    def look(self, now: float, h: float) -> None:
        """See where everybody is now, and how fast; `h` is a sub-step [s]."""
        if now == self.now:
            return
        self.now = now
        self.places = self._middles(self._p)
        self.velocities = (self.places - self._middles(self._before)) / h

    def _middles(self, p: Array) -> Array:
        middles: Array = np.add.reduceat(p, self._firsts, axis=0) / self._counts[:, None]
        middles[self.people] = p[self._pelvises]
        return middles


SPAN = 12.0
"""How long what is out of view is remembered [s]."""

SIGHT_RANGE = 25.0
"""How far somebody sees [m]."""

VIEW_HALF_ANGLE = math.radians(95.0)
"""How far to the side of where it looks."""

TOUCH_RANGE = 0.9
"""What is nearer than this is felt or heard, if not seen [m]."""


class Memory:
    """Where somebody believes the others to be.

    Attributes:
        places: (C, 3) last known [m].
        velocities: (C, 3) then [m/s].
        seen: (C,) when each was last in view [s].
        in_view: (C,) who is.
        away: (C,) how far over the ground each is believed to be [m].
    """

    def __init__(self, surroundings: Surroundings) -> None:
        # Whoever begins a film knows who is there.
        self.places = surroundings.places.copy()
        self.velocities = np.zeros_like(self.places)
        self.seen = np.zeros(len(self.places))
        self.in_view: NDArray[np.bool_] = np.ones(len(self.places), dtype=bool)
        self.away = np.zeros(len(self.places))

    def look(self, surroundings: Surroundings, me: int, gaze: float) -> None:
        """Take in what is in view of one who looks along a heading [rad]."""
        x, z, _ = self._from(surroundings.places, surroundings.places[me])
        distance = np.sqrt(x * x + z * z)
        ahead = x * math.cos(gaze) - z * math.sin(gaze)
        near = distance < surroundings.radius + TOUCH_RANGE
        self.in_view = near | (
            (distance < SIGHT_RANGE) & (ahead > math.cos(VIEW_HALF_ANGLE) * distance)
        )
        self.in_view[me] = False
        self.places[self.in_view] = surroundings.places[self.in_view]
        self.velocities[self.in_view] = surroundings.velocities[self.in_view]
        self.seen[self.in_view] = surroundings.now
        _, _, self.away = self._from(self.places, surroundings.places[me])

    @staticmethod
    def _from(places: Array, me: Array) -> tuple[Array, Array, Array]:
        x, z = places[:, 0] - me[0], places[:, 2] - me[2]
        return x, z, np.sqrt(x * x + z * z)

    def fresh(self, now: float) -> Array:
        """Return (C,) how well each is remembered, from 1 in view to 0."""
        left: Array = np.clip(1.0 - (now - self.seen) / SPAN, 0.0, 1.0)
        return left


NEAR_CAREGIVER, FAR_FROM_CAREGIVER = 1.5, 9.0
"""Distances from the caregiver at which nothing is to be feared, and at which much is [m]."""

GROWS = 0.26
"""How fast anxiety grows that far away in one who is very anxious [1/s]."""

CALMS = 0.02
"""How fast it goes by itself where one is safe [1/s]."""

SOOTHES = 0.75
"""How fast it goes in a hug [1/s]."""

SHOCK = 0.12
"""What a blow that just hurts adds."""


def exposed(distance: float) -> float:
    """Return how far from safety somebody is, from 0 to 1."""
    return min(max((distance - NEAR_CAREGIVER) / (FAR_FROM_CAREGIVER - NEAR_CAREGIVER), 0.0), 1.0)


def felt(anxiety: float, trait: float, distance: float, hugged: bool, dt: float) -> float:
    """Return what anxiety is a while later.

    Args:
        anxiety: from 0 to 1.
        trait: how anxious somebody is by nature, from 0 to 1.
        distance: from the caregiver [m].
        hugged: whether it hugs.
        dt: the while [s].
    """
    if hugged:
        return anxiety * math.exp(-SOOTHES * dt)
    gain = GROWS * trait * exposed(distance)
    loss = CALMS if distance < NEAR_CAREGIVER else 0.0
    return min(max(anxiety + (gain - loss) * dt, 0.0), 1.0)


INTEREST = {
    "ball": 0.8,
    "ragdoll": 0.45,
    "merry-go-round": 0.35,
    "child": 0.35,
    "adult": 0.3,
    "box": 0.08,
    "bench": 0.05,
}
"""How interesting things and people are by nature."""

LIKED = {"ball": 0.8, "ragdoll": 0.6, "merry-go-round": 0.5, "child": 0.2, "adult": 0.1}
"""How good they are by nature; what is not here is neither good nor bad."""

NEARNESS = 8.0
"""At this distance something is half as interesting as at hand [m]."""

MOVING = 0.12
"""What a metre a second adds to salience."""

KEEPS = 0.08
"""What the present focus is ahead of others, so that it does not flicker."""

CHANCE = 0.05
"""How much salience changes by chance from thought to thought."""


class Attention:
    """What somebody attends to.

    Attributes:
        interest: (C,) by nature.
        liked: (C,) by nature.
        bond: the number of the caregiver, -1 for none.
        fears: (C,) how much each frightens, from 0 to 1, such as after a blow.
        salience: (C,).
        valence: (C,) from -1 to 1.
        priority: (C,) of watching, from 0 to about 1.
        focus: number of the most salient one, -1 if there is none.
    """

    def __init__(self, kinds: tuple[str, ...], me: int, bond: int, curiosity: float) -> None:
        self.me, self.bond = me, bond
        drawn = 0.6 + 0.8 * curiosity
        self.interest = drawn * np.array([INTEREST.get(kind, 0.1) for kind in kinds])
        self.liked = np.array([LIKED.get(kind, 0.0) for kind in kinds])
        self.fears = np.zeros(len(kinds))
        self.salience, self.valence = np.zeros(len(kinds)), self.liked.copy()
        self.priority = np.zeros(len(kinds))
        self.focus = -1

    def appraise(self, memory: Memory, anxiety: float, chance: Array, now: float) -> None:
        """Appraise all, and choose the focus.

        Args:
            memory: where they are.
            anxiety: from 0 to 1.
            chance: (C,) random numbers from -1 to 1.
            now: the time [s].
        """
        fresh = memory.fresh(now)
        v = memory.velocities
        speed = np.sqrt(v[:, 0] ** 2 + v[:, 2] ** 2)
        near = NEARNESS / (NEARNESS + memory.away)
        lively = np.minimum(MOVING * speed, 0.3)
        self.valence = np.clip(self.liked - 1.5 * self.fears, -1.0, 1.0)
        self.salience = fresh * near * (self.interest + lively + self.fears) * (1 + CHANCE * chance)
        self.priority = np.maximum(self.fears * near, 0.06 * near * (self.interest > 0.2))
        if self.bond >= 0:
            self.valence[self.bond] = min(0.3 + anxiety, 1.0)
            self.salience[self.bond] += anxiety
            far = exposed(float(memory.away[self.bond]))
            self.priority[self.bond] = 0.02 + 0.7 * far + 0.4 * anxiety * far
        self.salience[self.me] = self.priority[self.me] = 0.0
        if self.focus >= 0:
            self.salience[self.focus] += KEEPS
        best = int(self.salience.argmax())
        self.focus = best if self.salience[best] > 0.1 else -1


RATE = 1.5
"""Glances a second at what has a priority of 1."""

LASTS = (0.55, 0.95)
"""How long a glance lasts [s]."""

BETWEEN = 0.5
"""How long eyes rest on their way between two glances, at least [s]."""

ON_TARGET, ON_FOCUS = 1.6, 0.8
"""How long they rest on where somebody goes, and on what else it attends to [s]."""


class Glances:
    """Where one looks.

    Attributes:
        at: number of whom it looks at, -1 for straight ahead.
        glancing: whether that is a glance aside.
    """

    def __init__(self, count: int, rng: np.random.Generator) -> None:
        self._need = 0.5 * rng.random(count)
        self._rng = rng
        self._until, self._rested = 0.0, 0.0
        self.at, self.glancing = -1, False

    def look(self, now: float, dt: float, priority: Array, focus: int, target: int) -> None:
        """Choose whom to look at for the next `dt` [s].

        Args:
            now: the time [s].
            dt: since it was last chosen [s].
            priority: (C,) of watching each.
            focus: of attention, -1 for none.
            target: where it goes, -1 for nowhere.
        """
        self._need += RATE * dt * priority
        if self.at >= 0:
            self._need[self.at] = 0.0
        if self.glancing and now < self._until:
            return
        if self.glancing:
            self.glancing, self._rested = False, now + BETWEEN
        due = int(self._need.argmax())
        if self._need[due] > 1.0 and now >= self._rested and due not in (focus, target):
            low, high = LASTS
            self.at, self.glancing = due, True
            self._until = now + low + (high - low) * float(self._rng.random())
            return
        if focus < 0 or target < 0 or focus == target:
            self.at = target if focus < 0 else focus
            return
        # Both in turn.
        turn = now % (ON_TARGET + ON_FOCUS)
        self.at = target if turn < ON_TARGET else focus
