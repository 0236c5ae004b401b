"""Face tracker: the faces of people, from what they feel, are told to show, and look at, and hands.

Feelings rise fast and fade slowly. Eyes jump to what is looked at before the head has turned, and
rest on it while the head follows; lids blink, and go down with the gaze. Angry people make
fists, unless their hands have something to do.

Source: Bentivoglio et al. 1997 for the rate of blinks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.expressions import face_of
from pipeline.simulation.face_units import HAND_SHAPES, HANDS, UNITS
from pipeline.simulation.seeds import generator
from pipeline.simulation.spatial import Array
from pipeline.spec.expression import EMOTIONS

BLINK, WIDE = UNITS.index("blink"), UNITS.index("lids_wide")
PAIN = EMOTIONS.index("pain")
ANGER = EMOTIONS.index("anger")

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

MAX_EYE_SIDE, MAX_EYE_UP, MAX_EYE_DOWN = np.radians([28.0, 14.0, 18.0])
"""Turns of the eyes against the head: farther up or down lids would hide the irises."""

EYE_TIME = 0.02
"""Time constant of a saccade [s]."""

LID_FOLLOWS = 1.3
"""Share of the lids' way, for a turn of the gaze down by a radian."""

STUNNED_LIDS = 0.7
"""Share of their way by which the lids of a stunned person are down."""

HAND_TIME = 0.12
"""Time constant of a hand that takes another shape [s]."""


@dataclass(frozen=True, eq=False)
class FaceInputs:
    """What moves the faces of P people, at one row.

    Attributes:
        felt: (P, 6) emotions of minds, from 0 to 1.
        told: (P, 6) emotions that orders ask for; NaN where no order asks.
        pain: (P,) felt since the start.
        eyes: (P, 2) turns of the eyes that are wanted, left and up [rad].
        stun: (P,) slackness after a blow, 0 to 1.
        grips: (P, 2) how far the left and the right hand grip, 0 to 1.
        flat: (P, 2) how far they are stretched.
    """

    felt: Array
    told: Array
    pain: Array
    eyes: Array
    stun: Array
    grips: Array
    flat: Array

    @staticmethod
    def calm(count: int) -> FaceInputs:
        """Return what moves the faces of people that feel nothing and look ahead."""
        feelings = (count, len(EMOTIONS))
        return FaceInputs(
            felt=np.zeros(feelings),
            told=np.full(feelings, np.nan),
            pain=np.zeros(count),
            eyes=np.zeros((count, 2)),
            stun=np.zeros(count),
            grips=np.zeros((count, 2)),
            flat=np.zeros((count, 2)),
        )


class FaceTracker:
    """The state of the faces and hands of P people.

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
        self._hands = np.zeros((count, len(HANDS)))
        self._blinked = np.full(count, -np.inf)
        self._due = np.array([rng.uniform(0.2, BLINK_PAUSE[1]) for rng in self._rngs])

    def faces(self, inputs: Sequence[FaceInputs]) -> NDArray[np.float32]:
        """Return the faces and hands (K, P, n) of the next rows, in the order of `COLUMNS`.

        Args:
            inputs: of each row.
        """
        names = (field.name for field in fields(FaceInputs))
        rows = FaceInputs(*(np.array([getattr(row, name) for row in inputs]) for name in names))
        hurt = self._hurts(rows.pain)
        emotions = self._emotions(np.where(np.isnan(rows.told), rows.felt, rows.told), hurt)
        eyes, self._eyes = _following(rows.eyes, self._eyes, EYE_TIME, self._dt)
        shut = np.maximum(self._blinks(len(inputs)), STUNNED_LIDS * np.minimum(rows.stun, 1.0))
        units = face_of(emotions)
        lowered = np.clip(-LID_FOLLOWS * eyes[..., 1], 0.0, 1.0)
        units[..., BLINK] = 1.0 - (1.0 - units[..., BLINK]) * (1.0 - lowered) * (1.0 - shut)
        units[..., WIDE] *= 1.0 - shut
        shapes = _hand_shapes(rows, emotions[..., ANGER])
        hands, self._hands = _following(shapes, self._hands, HAND_TIME, self._dt)
        self._rows += len(inputs)
        return np.concatenate([units, eyes, hands], axis=-1).astype(np.float32)

    def calm(self, count: int, grips: Array | None = None) -> NDArray[np.float32]:
        """Return the faces (K, P, n) of some rows of people that feel nothing and look ahead.

        Args:
            count: of the rows.
            grips: (K, P, 2) how far hands grip; not at all if left out.
        """
        calm = FaceInputs.calm(len(self._rngs))
        if grips is None:
            return self.faces([calm] * count)
        return self.faces([replace(calm, grips=grip) for grip in grips])

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


def _following(aims: Array, start: Array, time: float, dt: float) -> tuple[Array, Array]:
    """Return values (K, P, n) on the way to their aims, from (P, n) `start`, and the last ones.

    Args:
        aims: (K, P, n).
        start: (P, n).
        time: time constant [s].
        dt: time between rows [s].
    """
    share, found = 1.0 - np.exp(-dt / time), np.empty_like(aims)
    for k, aim in enumerate(aims):
        start = found[k] = start + share * (aim - start)
    return found, start


def _hand_shapes(rows: FaceInputs, anger: Array) -> Array:
    """Return the shapes (K, P, n) that hands aim at, in the order of `HANDS`."""
    grip = np.clip(rows.grips, 0.0, 1.0)
    flat = np.clip(rows.flat, 0.0, 1.0) * (1.0 - grip)
    fist = anger[..., None] * (1.0 - grip) * (1.0 - flat)
    shapes = {"grip": grip, "fist": fist, "flat": flat}
    return np.concatenate([shapes[name] for name in HAND_SHAPES], axis=-1)
