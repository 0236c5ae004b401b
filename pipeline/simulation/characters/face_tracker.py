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
        told: (P, 6) emotions that orders ask for.
        is_told: (P,) whether an order asks for these.
        pain: (P,) felt since the start.
    """

    felt: Array
    told: Array
    is_told: NDArray[np.bool_]
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
        self._dt, self._now, count = dt, 0.0, len(names)
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
        aims = _eye_aims(persons)
        emotions, eyes = np.empty((*aims.shape[:2], len(EMOTIONS))), np.empty(aims.shape)
        shut = np.empty(aims.shape[:2])
        for k, row in enumerate(inputs):
            emotions[k], eyes[k], shut[k] = self._advance(row, aims[k])
        found = np.zeros((*aims.shape[:2], len(COLUMNS)), np.float32)
        units = face_of(emotions)
        lowered = LID_FOLLOWS * np.maximum(-eyes[..., 1], 0.0)
        shut = np.maximum(shut, STUNNED_LIDS * np.minimum(persons["stun"], 1.0))
        open_share = (1.0 - units[..., BLINK]) * (1.0 - np.minimum(lowered, 1.0)) * (1.0 - shut)
        units[..., BLINK] = 1.0 - open_share
        units[..., WIDE] *= 1.0 - shut
        found[..., : len(UNITS)], found[..., len(UNITS) :] = units, eyes
        return found

    def _advance(self, row: FaceInputs, aims: Array) -> tuple[Array, Array, Array]:
        """Advance by a row; return emotions (P, 6), eyes (P, 2) [rad], and how shut lids are."""
        dt = self._dt
        self._now += dt
        blow = np.maximum(row.pain - self._pain, 0.0)
        self._pain = row.pain
        self._hurt = np.minimum(self._hurt * np.exp(-dt / PAIN_FADE) + blow / PAIN_SHOWN, 1.5)
        target = np.where(row.is_told[:, None], row.told, row.felt)
        hurt = np.minimum(self._hurt, 1.0)
        # Pain takes the face over.
        target = target * (1.0 - hurt[:, None])
        target[:, PAIN] = np.maximum(target[:, PAIN], hurt)
        time = np.where(target > self._shown, RISE_TIME, FADE_TIME)
        self._shown = self._shown + (target - self._shown) * (1.0 - np.exp(-dt / time))
        self._eyes = self._eyes + (aims - self._eyes) * (1.0 - np.exp(-dt / EYE_TIME))
        for k in np.flatnonzero(self._now >= self._due).tolist():
            self._blinked[k] = self._now
            self._due[k] = self._now + self._rngs[k].uniform(*BLINK_PAUSE)
        since = self._now - self._blinked
        closing, opening = since / BLINK_CLOSING, 1.0 - (since - BLINK_CLOSING) / BLINK_OPENING
        return self._shown, self._eyes, np.clip(np.minimum(closing, opening), 0.0, 1.0)


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
