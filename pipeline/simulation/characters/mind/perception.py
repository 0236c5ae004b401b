"""Perception: surroundings, short-term memory, attention, anxiety, and glances.

Source: Horswill 2008, "Example application"; Bowlby 1969 for anxiety.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.characters.body_arrays import IntArray
from pipeline.simulation.characters.person_controller import BODY_RADIUS, CharacterView
from pipeline.simulation.characters.person_record import PELVIS
from pipeline.simulation.spatial import Array

MEMORY_SPAN = 12.0  # for which characters out of view are remembered [s]
SIGHT_RANGE = 25.0  # [m]
VIEW_HALF_ANGLE = math.radians(95.0)
TOUCH_RANGE = 0.9  # within which characters are felt or heard, if not seen [m]


@dataclass(frozen=True)
class AnxietyRates:
    """How anxiety grows away from a caregiver, and is soothed.

    Attributes:
        safe: distance without fear [m].
        exposed: distance of full exposure [m].
        growth: rate there of a very anxious character [1/s].
        calming: rate of decline in safety [1/s].
        hug: rate of decay in a hug [1/s].
        shock: increase by a blow that just hurts.
    """

    safe: float = 1.5
    exposed: float = 9.0
    growth: float = 0.26
    calming: float = 0.02
    hug: float = 0.75
    shock: float = 0.12


ANXIETY = AnxietyRates()

INTEREST = {
    "ball": 0.8,
    "ragdoll": 0.45,
    "merry-go-round": 0.35,
    "child": 0.35,
    "adult": 0.3,
    "box": 0.08,
    "bench": 0.05,
}
"""Natural interest of things and people."""

VALENCE = {"ball": 0.8, "ragdoll": 0.6, "merry-go-round": 0.5, "child": 0.2, "adult": 0.1}
"""Natural valence; others are neither good nor bad."""

HALF_INTEREST_DISTANCE = 8.0  # [m]
MOTION_SALIENCE = 0.12  # added by motion [s/m]
FOCUS_BONUS = 0.08  # of the present focus, so that it does not flicker
SALIENCE_NOISE = 0.05  # relative

GLANCE_RATE = 1.5  # glances at a character of priority 1 [1/s]
GLANCE_TIME = (0.55, 0.95)  # [s]
MIN_GLANCE_PAUSE = 0.5  # [s]
TARGET_TIME, FOCUS_TIME = 1.6, 0.8  # of looking at either in turn [s]


class Surroundings:
    """All characters as arrays, one row each.

    Attributes:
        view: all characters.
        kinds: of the characters.
        people: (C,) whether each has the joints of a person.
        radius: (C,) of the circle on the ground around each [m].
        places: (C, 3) pelvises of people, middles of things [m].
        velocities: (C, 3) of these [m/s].
        low: (2,) least x and z of the terrain [m].
        high: (2,) greatest x and z of the terrain [m].
        now: the time [s].
    """

    def __init__(self, view: CharacterView, kinds: Sequence[str], heights: Sequence[float]) -> None:
        self.view, self.kinds = view, tuple(kinds)
        owners = view.arrays.owners
        self._first_nodes: IntArray = owners["nodes"][:, 0].copy()
        self._counts: Array = owners["nodes"][:, 1].astype(float)
        self.people = np.array([k in view.people for k in range(len(kinds))], dtype=bool)
        self._pelvises = self._first_nodes[self.people] + PELVIS
        self.radius = np.array([view.circle(k)[1] for k in range(len(kinds))])
        self.radius[self.people] = BODY_RADIUS * np.array(heights)[self.people]
        self.low, self.high = view.edges
        self._p, self._previous = view.arrays.p, view.arrays.previous
        self.now = -1.0
        self.update(0.0, 1.0)

    def update(self, now: float, h: float) -> None:
        """Update places and velocities; `h` is a sub-step [s]."""
        if now == self.now:
            return
        self.now = now
        self.places = self._middles(self._p)
        self.velocities = (self.places - self._middles(self._previous)) / h

    def _middles(self, p: Array) -> Array:
        middles: Array = np.add.reduceat(p, self._first_nodes, axis=0) / self._counts[:, None]
        middles[self.people] = p[self._pelvises]
        return middles


class Memory:
    """Where a character believes the others to be.

    Attributes:
        places: (C, 3) last known [m].
        velocities: (C, 3) then [m/s].
        seen: (C,) time when each was last in view [s].
        in_view: (C,) whether each is in view.
        distances: (C,) over the ground to the remembered places [m].
    """

    def __init__(self, surroundings: Surroundings) -> None:
        # At the start of a film everybody is known.
        self.places = surroundings.places.copy()
        self.velocities = np.zeros_like(self.places)
        self.seen = np.zeros(len(self.places))
        self.in_view: NDArray[np.bool_] = np.ones(len(self.places), dtype=bool)
        self.distances = np.zeros(len(self.places))

    def look(self, surroundings: Surroundings, owner: int, gaze: float) -> None:
        """Remember what is in view of a character that looks along a heading [rad]."""
        x, z, distance = self._offsets(surroundings.places, surroundings.places[owner])
        ahead = x * math.cos(gaze) - z * math.sin(gaze)
        is_near = distance < surroundings.radius + TOUCH_RANGE
        is_seen = (distance < SIGHT_RANGE) & (ahead > math.cos(VIEW_HALF_ANGLE) * distance)
        self.in_view = is_near | is_seen
        self.in_view[owner] = False
        self.places[self.in_view] = surroundings.places[self.in_view]
        self.velocities[self.in_view] = surroundings.velocities[self.in_view]
        self.seen[self.in_view] = surroundings.now
        _, _, self.distances = self._offsets(self.places, surroundings.places[owner])

    @staticmethod
    def _offsets(places: Array, origin: Array) -> tuple[Array, Array, Array]:
        x, z = places[:, 0] - origin[0], places[:, 2] - origin[2]
        return x, z, np.sqrt(x * x + z * z)

    def freshness(self, now: float) -> Array:
        """Return (C,) how well each is remembered, from 1 in view to 0."""
        return np.clip(1.0 - (now - self.seen) / MEMORY_SPAN, 0.0, 1.0)


def exposure(distance: float) -> float:
    """Return the exposure at a distance from the caregiver, from 0 to 1."""
    return min(max((distance - ANXIETY.safe) / (ANXIETY.exposed - ANXIETY.safe), 0.0), 1.0)


def next_anxiety(anxiety: float, trait: float, distance: float, hugged: bool, dt: float) -> float:
    """Return the anxiety after `dt`.

    Args:
        anxiety: from 0 to 1.
        trait: natural anxiety, from 0 to 1.
        distance: from the caregiver [m].
        hugged: whether the character hugs.
        dt: [s].
    """
    if hugged:
        return anxiety * math.exp(-ANXIETY.hug * dt)
    gain = ANXIETY.growth * trait * exposure(distance)
    loss = ANXIETY.calming if distance < ANXIETY.safe else 0.0
    return min(max(anxiety + (gain - loss) * dt, 0.0), 1.0)


class Attention:
    """What a character attends to.

    Each other character has a salience (how interesting), a valence (how good, below 0 how bad)
    and a monitoring priority (how much it wants watching). The most salient one is the focus.

    Attributes:
        fears: (C,) how much each frightens, from 0 to 1, such as after a blow.
        salience: (C,).
        valence: (C,) from -1 to 1.
        priority: (C,) of watching, from 0 to about 1.
        nearness: (C,) 1 for what is close, less for what is far.
        focus: number of the most salient character, -1 if there is none.
    """

    def __init__(
        self, kinds: tuple[str, ...], owner: int, caregiver: int, curiosity: float
    ) -> None:
        self._owner, self._caregiver = owner, caregiver
        drawn = 0.6 + 0.8 * curiosity
        self._interest = drawn * np.array([INTEREST.get(kind, 0.1) for kind in kinds])
        self._natural_valence = np.array([VALENCE.get(kind, 0.0) for kind in kinds])
        self.fears = np.zeros(len(kinds))
        self.salience, self.valence = np.zeros(len(kinds)), self._natural_valence.copy()
        self.priority, self.nearness = np.zeros(len(kinds)), np.zeros(len(kinds))
        self.focus = -1

    def appraise(self, memory: Memory, anxiety: float, noise: Array, now: float) -> None:
        """Appraise all characters, and choose the focus.

        Args:
            memory: of their places.
            anxiety: from 0 to 1.
            noise: (C,) random numbers from -1 to 1.
            now: the time [s].
        """
        v = memory.velocities
        speed = np.sqrt(v[:, 0] ** 2 + v[:, 2] ** 2)
        near = HALF_INTEREST_DISTANCE / (HALF_INTEREST_DISTANCE + memory.distances)
        self.nearness = near
        lively = np.minimum(MOTION_SALIENCE * speed, 0.3)
        interest, varied = self._interest + lively + self.fears, 1 + SALIENCE_NOISE * noise
        self.valence = np.clip(self._natural_valence - 1.5 * self.fears, -1.0, 1.0)
        self.salience = memory.freshness(now) * near * interest * varied
        self.priority = np.maximum(self.fears * near, 0.06 * near * (self._interest > 0.2))
        if self._caregiver >= 0:
            self.valence[self._caregiver] = min(0.3 + anxiety, 1.0)
            self.salience[self._caregiver] += anxiety
            far = exposure(float(memory.distances[self._caregiver]))
            self.priority[self._caregiver] = 0.02 + 0.7 * far + 0.4 * anxiety * far
        self.salience[self._owner] = self.priority[self._owner] = 0.0
        if self.focus >= 0:
            self.salience[self.focus] += FOCUS_BONUS
        best = int(self.salience.argmax())
        self.focus = best if self.salience[best] > 0.1 else -1


class Glances:
    """Where a character looks: at its focus, its target, and what wants watching.

    The need to look at a character grows with its priority; when due it gets a glance, and then
    the eyes go back.

    Attributes:
        at: number of the character looked at, -1 for straight ahead.
        glancing: whether that is a glance aside.
    """

    def __init__(self, count: int, rng: np.random.Generator) -> None:
        self._need = 0.5 * rng.random(count)
        self._rng = rng
        self._glance_end, self._pause_end = 0.0, 0.0
        self.at, self.glancing = -1, False

    def look(self, now: float, dt: float, priority: Array, focus: int, target: int) -> None:
        """Choose where to look for the next `dt` [s].

        Args:
            now: the time [s].
            dt: since the last choice [s].
            priority: (C,) of watching each.
            focus: of attention, -1 for none.
            target: that is walked to, -1 for none.
        """
        self._need += GLANCE_RATE * dt * priority
        if self.at >= 0:
            self._need[self.at] = 0.0
        if self.glancing and now < self._glance_end:
            return
        if self.glancing:
            self.glancing, self._pause_end = False, now + MIN_GLANCE_PAUSE
        due = int(self._need.argmax())
        if self._need[due] > 1.0 and now >= self._pause_end and due not in (focus, target):
            low, high = GLANCE_TIME
            self.at, self.glancing = due, True
            self._glance_end = now + low + (high - low) * float(self._rng.random())
        elif focus < 0 or target < 0 or focus == target:
            self.at = target if focus < 0 else focus
        else:
            # Both in turn.
            self.at = target if now % (TARGET_TIME + FOCUS_TIME) < TARGET_TIME else focus
