"""Face tracker: the faces of acting people, from what they feel, are told to show, and look at.

Feelings rise fast and fade slowly. Eyes jump to what is looked at before the head has turned, and
rest on it while the head follows; lids blink, and go down with the gaze.

Source: Bentivoglio et al. 1997 for the rate of blinks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.compiled import Records
from pipeline.simulation.expressions import face_of
from pipeline.simulation.face_units import COLUMNS, UNITS
from pipeline.simulation.people.proportions import JOINTS
from pipeline.simulation.seeds import generator
from pipeline.simulation.spatial import Array
from pipeline.spec.expression import EMOTIONS

BLINK, WIDE = UNITS.index("blink"), UNITS.index("lids_wide")
PAIN = EMOTIONS.index("pain")
HEAD = JOINTS.index("head")

RISE_TIME, FADE_TIME = 0.12, 0.5
"""Time constants of an expression that comes and goes [s]."""

PAIN_SHOWN, PAIN_FADE = 0.5, 0.9
"""Pain of a blow that shows fully [of `pain`], and the time constant of its decay [s]."""

LEAST_HURT, MAX_HURT = 1e-4, 1.5
"""Pain that no longer shows, and the most that a face remembers, in what shows fully."""

BLINK_PAUSE = 1.4, 5.6
"""Shortest and longest time between blinks [s]: 17 a minute on average."""

BLINK_CLOSING, BLINK_OPENING = 0.07, 0.14
"""Durations of both halves of a blink [s]."""

MAX_EYE_SIDE, MAX_EYE_UP, MAX_EYE_DOWN = np.radians([32.0, 18.0, 22.0])
"""Turns of the eyes against the head."""

EYE_TIME = 0.02
"""Time constant of a saccade [s]."""

LID_FOLLOWS = 1.3
"""Share of the lids' way, for a turn of the gaze down by a radian."""

STUNNED_LIDS = 0.7
"""Share of their way by which the lids of a stunned person are down."""


@dataclass(frozen=True, eq=False)
class FaceInputs:
    """What moves the faces of P people, at one row.

    Attributes:
        felt: (P, 6) emotions of minds, from 0 to 1.
        told: (P, 6) emotions that orders ask for; NaN where no order asks.
        pain: (P,) felt since the start.
    """

    felt: Array
    told: Array
    pain: Array


class FaceTracker:
    """The state of the faces of P acting people.

    Args:
        names: of the people.
        seed: of the scene.
        dt: time between rows [s].
    """

    def __init__(self, names: Sequence[str], seed: int, dt: float) -> None:
        self._rngs = [generator(seed, f"{name}.blinks") for name in names]
        self._dt, self._rows, count = dt, 0, len(names)
        self._shown = np.zeros((count, len(EMOTIONS)))
        self._hurt, self._pain = np.zeros(count), np.zeros(count)
        self._eyes = np.zeros((count, 2))
        self._blinked = np.full(count, -np.inf)
        self._due = np.array([rng.uniform(0.2, BLINK_PAUSE[1]) for rng in self._rngs])

    def faces(self, inputs: Sequence[FaceInputs], persons: Records) -> NDArray[np.float32]:
        """Return the faces (K, P, n) of the next rows, in the order of `COLUMNS`.

        Args:
            inputs: of each row.
            persons: (K, P) `PERSON` records.
        """
        felt, told = (np.array([getattr(row, name) for row in inputs]) for name in ("felt", "told"))
        hurt = self._hurts(np.array([row.pain for row in inputs]))
        emotions = self._emotions(np.where(np.isnan(told), felt, told), hurt)
        eyes = self._eyes_along(_eye_aims(persons))
        shut = np.maximum(
            self._blinks(len(inputs)), STUNNED_LIDS * np.minimum(persons["stun"], 1.0)
        )
        found = np.zeros((*hurt.shape, len(COLUMNS)), np.float32)
        units = face_of(emotions)
        lowered = np.clip(-LID_FOLLOWS * eyes[..., 1], 0.0, 1.0)
        units[..., BLINK] = 1.0 - (1.0 - units[..., BLINK]) * (1.0 - lowered) * (1.0 - shut)
        units[..., WIDE] *= 1.0 - shut
        found[..., : len(UNITS)], found[..., len(UNITS) :] = units, eyes
        self._rows += len(inputs)
        return found

    def _hurts(self, pain: Array) -> Array:
        """Return how much pain shows (K, P), from 0 to 1, from the pain felt since the start."""
        blows = np.maximum(np.diff(pain, axis=0, prepend=self._pain[None]), 0.0) / PAIN_SHOWN
        self._pain = pain[-1]
        found = np.zeros_like(blows)
        if not (blows.any() or (self._hurt > LEAST_HURT).any()):
            self._hurt = np.zeros_like(self._hurt)
            return found
        decay = np.exp(-self._dt / PAIN_FADE)
        for k, blow in enumerate(blows):
            self._hurt = found[k] = np.minimum(decay * self._hurt + blow, MAX_HURT)
        return np.minimum(found, 1.0)

    def _emotions(self, target: Array, hurt: Array) -> Array:
        """Return the emotions (K, P, 6) that show on the way to these."""
        # Pain takes the face over.
        target = target * (1.0 - hurt[..., None])
        target[..., PAIN] = np.maximum(target[..., PAIN], hurt)
        rise, fade = (1.0 - np.exp(-self._dt / time) for time in (RISE_TIME, FADE_TIME))
        shown = self._shown
        for k, wanted in enumerate(target):
            away = wanted - shown
            shown = target[k] = shown + np.where(away > 0.0, rise, fade) * away
        self._shown = shown
        return target

    def _eyes_along(self, aims: Array) -> Array:
        """Return the turns of the eyes (K, P, 2) on the way to their aims [rad]."""
        share, eyes = 1.0 - np.exp(-self._dt / EYE_TIME), self._eyes
        for k, aim in enumerate(aims):
            eyes = aims[k] = eyes + share * (aim - eyes)
        self._eyes = eyes
        return aims

    def _blinks(self, count: int) -> Array:
        """Return how shut lids are in the next rows (K, P), from 0 to 1."""
        times = self._dt * (self._rows + np.arange(count))
        since = times[:, None] - self._blinked
        for k in np.flatnonzero(self._due <= times[-1]).tolist():
            while self._due[k] <= times[-1]:
                start = self._blinked[k] = self._due[k]
                later = times >= start
                since[later, k] = times[later] - start
                self._due[k] = start + self._rngs[k].uniform(*BLINK_PAUSE)
        closing, opening = since / BLINK_CLOSING, 1.0 - (since - BLINK_CLOSING) / BLINK_OPENING
        return np.clip(np.minimum(closing, opening), 0.0, 1.0)


def _eye_aims(persons: Records) -> Array:
    """Return (..., 2) the turns of the eyes to what is looked at: left and up [rad].

    The head faces along the gaze of the record.
    """
    x, y, z = np.moveaxis(persons["look_at"] - persons["targets"][..., HEAD, :], -1, 0)
    left = np.arctan2(-z, x) - persons["gaze"][..., 0]
    left = np.remainder(left + np.pi, 2.0 * np.pi) - np.pi
    up = np.arctan2(y, np.hypot(x, z)) - persons["gaze"][..., 1]
    # What is behind is not looked at with the eyes alone.
    looks = persons["has_look_target"] & (np.abs(left) < 0.5 * np.pi)
    aims = np.stack(
        [np.clip(left, -MAX_EYE_SIDE, MAX_EYE_SIDE), np.clip(up, -MAX_EYE_DOWN, MAX_EYE_UP)],
        axis=-1,
    )
    return np.where(looks[..., None], aims, 0.0)
