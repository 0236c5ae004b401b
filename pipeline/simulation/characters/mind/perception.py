"""Perception: surroundings, short-term memory, attention, anxiety, and glances.

Source: Horswill 2008, "Example application"; Bowlby 1969 for anxiety.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cache, cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.characters.body_arrays import NOBODY
from pipeline.simulation.characters.character_view import CharacterView
from pipeline.simulation.characters.mind.mind_arrays import MindArrays
from pipeline.simulation.characters.person_controller import BODY_RADIUS
from pipeline.simulation.characters.person_record import PELVIS
from pipeline.simulation.dynamics.compiled import Record, Records, bound, compiled, entry
from pipeline.simulation.dynamics.record_view import record_view
from pipeline.simulation.dynamics.vectors import hypotenuse
from pipeline.simulation.spatial import Array

MEMORY_SPAN = 12.0  # for which characters out of view are remembered [s]
SIGHT_RANGE = 25.0  # [m]
VIEW_HALF_ANGLE = math.radians(95.0)
TOUCH_RANGE = 0.9  # within which characters are felt or heard, if not seen [m]


class AnxietyRates(NamedTuple):
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


class EmotionRates(NamedTuple):
    """How feelings change, beside anxiety away from a caregiver.

    Attributes:
        hug_pain: pain that is expected from a hugged partner, and no blow.
        returning: factor of natural anxiety on the way back to the caregiver.
        calming: rate of decay of anxiety without a caregiver [1/s].
        fear_decay: of fear of a character [1/s].
        fear: by a blow that just hurts.
        anger: by a blow that just hurts.
        anger_decay: [1/s].
    """

    hug_pain: float = 2.0
    returning: float = 0.25
    calming: float = 0.1
    fear_decay: float = 0.12
    fear: float = 0.35
    anger: float = 0.25
    anger_decay: float = 0.1


EMOTION = EmotionRates()

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
        valence: (C,) natural valence, from -1 to 1.
        low: (2,) least x and z of the terrain [m].
        high: (2,) greatest x and z of the terrain [m].
        now: the time [s].
    """

    def __init__(self, view: CharacterView, kinds: Sequence[str], heights: Sequence[float]) -> None:
        self.view, self.kinds = view, tuple(kinds)
        self.people = np.array([k in view.people for k in range(len(kinds))], dtype=bool)
        self.radius = np.array([view.circle(k)[1] for k in range(len(kinds))])
        self.radius[self.people] = BODY_RADIUS * np.array(heights)[self.people]
        self.valence = np.array([VALENCE.get(kind, 0.0) for kind in kinds])
        self.low, self.high = view.edges
        self.places, self.velocities = np.zeros((2, len(kinds), 3))
        self.now = -1.0
        self.update(0.0, 1.0)

    def interest(self, curiosity: float) -> Array:
        """Return (C,) the natural interest of a character of some curiosity in each."""
        natural = np.array([INTEREST.get(kind, 0.1) for kind in self.kinds])
        return (0.6 + 0.8 * curiosity) * natural

    def update(self, now: float, h: float) -> None:
        """Update places and velocities; `h` is a sub-step [s]."""
        if now != self.now:
            self.now = now
            self._place(h)

    @cached_property
    def _place(self) -> Callable[[float], None]:
        arrays = self.view.arrays
        places = arrays.nodes, arrays.owners, self.people, self.places, self.velocities
        return bound(place_characters, *places, examples=(1.0,))


@entry
def place_characters(
    nodes: Records,
    owners: Records,
    people: NDArray[np.bool_],
    places: Array,
    velocities: Array,
    h: float,
) -> None:
    """Find the places (C, 3) [m] and velocities (C, 3) [m/s] of all characters."""
    for c in range(len(owners)):
        first, count = owners[c].nodes[0], owners[c].nodes[1]
        if people[c]:
            first, count = first + PELVIS, 1
        for k in range(3):
            now = before = 0.0
            for n in range(first, first + count):
                now += nodes[n].p[k]
                before += nodes[n].previous[k]
            places[c, k] = now / count
            velocities[c, k] = (places[c, k] - before / count) / h


@entry
def notice(
    arrays: MindArrays,
    persons: Records,
    places: Array,
    velocities: Array,
    radius: Array,
    valence: Array,
    turns: NDArray[np.int64],
    now: float,
) -> None:
    """Let minds perceive, remember, feel and attend.

    Args:
        arrays: all minds; changed.
        persons: `PERSON` records.
        places: (C, 3) of all characters [m].
        velocities: (C, 3) of all characters [m/s].
        radius: (C,) of the circles around them [m].
        valence: (C,) natural valence of each.
        turns: numbers of the minds whose turn it is.
        now: the time [s].
    """
    for n in turns:
        mind = arrays.minds[n]
        dt = now - mind.now
        mind.now = now
        _see(arrays, n, persons[mind.person].gaze[0], places, velocities, radius)
        fear_kept = math.exp(-EMOTION.fear_decay * dt)
        for c in range(len(places)):
            lasting = arrays.lasting_fears[n, c]
            arrays.fears[n, c] = lasting + (arrays.fears[n, c] - lasting) * fear_kept
        _feel(mind, arrays.distances[n], places, dt)
        _appraise(arrays, n, valence)


@compiled
def _see(
    arrays: MindArrays, n: int, gaze: float, places: Array, velocities: Array, radius: Array
) -> None:
    """Remember what is in view of a mind that looks along a heading [rad]."""
    mind = arrays.minds[n]
    known, in_view = arrays.places[n], arrays.in_view[n]
    at_x, at_z = places[mind.owner, 0], places[mind.owner, 2]
    arrays.at[n, 0], arrays.at[n, 1] = at_x, at_z
    ahead_x, ahead_z, cosine = math.cos(gaze), math.sin(gaze), math.cos(VIEW_HALF_ANGLE)
    for c in range(len(places)):
        x, z = places[c, 0] - at_x, places[c, 2] - at_z
        distance = math.sqrt(x * x + z * z)
        ahead = x * ahead_x - z * ahead_z
        is_near = distance < radius[c] + TOUCH_RANGE
        is_seen = distance < SIGHT_RANGE and ahead > cosine * distance
        in_view[c] = c != mind.owner and (is_near or is_seen)
        if in_view[c]:
            for k in range(3):
                known[c, k] = places[c, k]
                arrays.velocities[n, c, k] = velocities[c, k]
            arrays.seen[n, c], arrays.distances[n, c] = mind.now, distance
        else:
            x, z = known[c, 0] - at_x, known[c, 2] - at_z
            arrays.distances[n, c] = math.sqrt(x * x + z * z)


@compiled
def _feel(mind: Record, distances: Array, places: Array, dt: float) -> None:
    """Let anger and anxiety change for `dt` [s]."""
    mind.anger *= math.exp(-EMOTION.anger_decay * dt)
    if mind.caregiver < 0:
        mind.anxiety *= math.exp(-EMOTION.calming * dt)
        return
    x = places[mind.caregiver, 0] - places[mind.owner, 0]
    z = places[mind.caregiver, 2] - places[mind.owner, 2]
    mind.caregiver_distance = hypotenuse(x, z)
    trait = mind.natural_anxiety * (EMOTION.returning if mind.returns else 1.0)
    mind.anxiety = next_anxiety(mind.anxiety, trait, distances[mind.caregiver], mind.hugs, dt)


@entry
def exposure(distance: float) -> float:
    """Return the exposure at a distance from the caregiver, from 0 to 1."""
    return min(max((distance - ANXIETY.safe) / (ANXIETY.exposed - ANXIETY.safe), 0.0), 1.0)


@entry
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


@compiled
def _appraise(arrays: MindArrays, n: int, natural_valence: Array) -> None:
    """Appraise all characters, and choose the focus.

    Each other character has a salience, a valence and a monitoring priority. The most salient one
    is the focus.
    """
    mind, salience, priority = arrays.minds[n], arrays.salience[n], arrays.priority[n]
    distances, fears = arrays.distances[n], arrays.fears[n]
    for c in range(len(salience)):
        v = arrays.velocities[n, c]
        speed = math.sqrt(v[0] * v[0] + v[2] * v[2])
        near = HALF_INTEREST_DISTANCE / (HALF_INTEREST_DISTANCE + distances[c])
        arrays.nearness[n, c] = near
        interest = arrays.interest[n, c]
        drawn = interest + min(MOTION_SALIENCE * speed, 0.3) + fears[c]
        varied = 1.0 + SALIENCE_NOISE * (2.0 * arrays.noise[n, mind.noise_row, c] - 1.0)
        salience[c] = freshness(arrays.seen[n, c], mind.now) * near * drawn * varied
        arrays.valence[n, c] = min(max(natural_valence[c] - 1.5 * fears[c], -1.0), 1.0)
        watched = 0.06 * near if interest > 0.2 else 0.0
        priority[c] = max(fears[c] * near, watched)
    if mind.caregiver >= 0:
        arrays.valence[n, mind.caregiver] = min(0.3 + mind.anxiety, 1.0)
        salience[mind.caregiver] += mind.anxiety
        far = exposure(distances[mind.caregiver])
        priority[mind.caregiver] = 0.02 + 0.7 * far + 0.4 * mind.anxiety * far
    salience[mind.owner] = priority[mind.owner] = 0.0
    if mind.focus >= 0:
        salience[mind.focus] += FOCUS_BONUS
    best = salience.argmax()
    mind.focus = best if salience[best] > 0.1 else NOBODY
    mind.focus_salience = salience[best] if mind.focus >= 0 else 0.0


@entry
def freshness(seen: float, now: float) -> float:
    """Return how well is remembered what was last seen at a time, from 1 in view to 0."""
    return min(max(1.0 - (now - seen) / MEMORY_SPAN, 0.0), 1.0)


class Memory:
    """Where a character believes the others to be; rows of `MindArrays`.

    Attributes:
        places: (C, 3) last known [m].
        velocities: (C, 3) then [m/s].
        seen: (C,) time when each was last in view [s].
        in_view: (C,) whether each is in view.
        distances: (C,) over the ground to the remembered places [m].
    """

    def __init__(self, arrays: MindArrays, n: int) -> None:
        self.places, self.velocities = arrays.places[n], arrays.velocities[n]
        self.seen, self.in_view = arrays.seen[n], arrays.in_view[n]
        self.distances = arrays.distances[n]


class Attention:
    """What a character attends to; rows of `MindArrays`.

    Attributes:
        fears: (C,) how much each frightens, from 0 to 1, such as after a blow.
        valence: (C,) from -1 to 1.
        priority: (C,) of watching, from 0 to about 1.
        nearness: (C,) 1 for what is close, less for what is far.
    """

    def __init__(self, arrays: MindArrays, n: int) -> None:
        self._mind = record_view(arrays.minds, n)
        self.fears, self.valence = arrays.fears[n], arrays.valence[n]
        self.priority, self.nearness = arrays.priority[n], arrays.nearness[n]

    @property
    def focus(self) -> int:
        """Number of the most salient character, NOBODY if there is none."""
        return int(self._mind.focus)

    @property
    def focus_salience(self) -> float:
        """How interesting the focus is, 0 without one."""
        return float(self._mind.focus_salience)


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
        due, need = _needs_grower()(self._need, priority, GLANCE_RATE * dt, self.at)
        if self.glancing and now < self._glance_end:
            return
        if self.glancing:
            self.glancing, self._pause_end = False, now + MIN_GLANCE_PAUSE
        if need > 1.0 and now >= self._pause_end and due not in (focus, target):
            low, high = GLANCE_TIME
            self.at, self.glancing = due, True
            self._glance_end = now + low + (high - low) * float(self._rng.random())
        elif focus < 0 or target < 0 or focus == target:
            self.at = target if focus < 0 else focus
        else:
            # Both in turn.
            self.at = target if now % (TARGET_TIME + FOCUS_TIME) < TARGET_TIME else focus


@entry
def grow_needs(needs: Array, priority: Array, gain: float, seen: int) -> tuple[int, float]:
    """Let the needs to look at characters grow, and return the greatest with its number.

    Args:
        needs: (C,) to look at each; changed.
        priority: (C,) of watching each.
        gain: of a need at priority 1.
        seen: number of the character looked at, whose need is met, or NOBODY.
    """
    for c in range(len(needs)):
        needs[c] += gain * priority[c]
    if seen >= 0:
        needs[seen] = 0.0
    due = int(needs.argmax())
    return due, needs[due]


@cache
def _needs_grower() -> Callable[[Array, Array, float, int], tuple[int, float]]:
    """Return `grow_needs` for arguments of the types that it always has."""
    return bound(grow_needs, examples=(np.zeros(1), np.zeros(1), 0.0, 0))
