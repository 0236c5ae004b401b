"""Expressions: emotions as actions of the face.

Source: Ekman, Friesen and Hager 2002 for joy, sadness, anger and fear; Prkachin 1992 for pain;
curiosity is the interest of Izard 1979.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from pipeline.simulation.face_units import UNITS
from pipeline.simulation.spatial import Array
from pipeline.spec.expression import EMOTIONS, Emotion
from pipeline.spec.script import Express

EXPRESSIONS: Mapping[Emotion, Mapping[str, float]] = {
    "joy": {
        "smile": 1.0,
        "cheek_up": 0.8,
        "lids_tight": 0.3,
        "jaw": 0.35,
        "lip_up": 0.3,
        "brow_inner_up": 0.25,
        "brow_outer_up": 0.2,
    },
    "sadness": {"brow_inner_up": 1.0, "brow_down": 0.3, "corner_down": 1.0, "blink": 0.3},
    "anger": {
        "brow_down": 1.0,
        "lids_wide": 0.35,
        "lids_tight": 0.6,
        "press": 0.8,
        "corner_down": 0.35,
    },
    "fear": {
        "brow_inner_up": 1.0,
        "brow_outer_up": 0.5,
        "brow_down": 0.25,
        "lids_wide": 1.0,
        "stretch": 0.8,
        "jaw": 0.55,
    },
    "pain": {
        "brow_down": 0.9,
        "cheek_up": 1.0,
        "lids_tight": 1.0,
        "blink": 0.75,
        "lip_up": 1.0,
        "stretch": 0.6,
        "jaw": 0.3,
    },
    "curiosity": {
        "brow_inner_up": 0.75,
        "brow_outer_up": 1.0,
        "lids_wide": 0.5,
        "jaw": 0.12,
        "smile": 0.2,
    },
}
"""Full actions of units by emotion."""

ACTIONS: Array = np.array(
    [[EXPRESSIONS[emotion].get(unit, 0.0) for unit in UNITS] for emotion in EMOTIONS]
)
"""(emotions, units)."""


OPENING: Array = np.ones_like(ACTIONS)
"""Powers of an emotion with which its actions grow, (emotions, units)."""
# A smile keeps the lips together; they part for a laugh.
OPENING[EMOTIONS.index("joy"), [UNITS.index(unit) for unit in ("jaw", "lip_up")]] = 3.0


EASE = {"smile": 0.22, "cheek_up": 0.15, "brow_inner_up": 0.12, "brow_outer_up": 0.15}
"""Actions of units in a face that shows no emotion: slack muscles look sad or absent."""

AT_EASE: Array = np.array([EASE.get(unit, 0.0) for unit in UNITS])


def told_emotions(order: Express) -> list[float]:
    """Return the emotions (6,) that an order asks to show, NaN for those that are felt."""
    if order.express == "own":
        return [math.nan] * len(EMOTIONS)
    return [order.strength if emotion == order.express else 0.0 for emotion in EMOTIONS]


def face_of(emotions: Array) -> Array:
    """Return the units (..., n) of a face that shows emotions (..., 6), each from 0 to 1.

    Units of several emotions do not add up beyond their full action. The less they are, the more
    the face is at ease.
    """
    acts = np.clip(emotions[..., :, None], 0.0, 1.0) ** OPENING * ACTIONS
    ease = (1.0 - np.clip(emotions.max(axis=-1), 0.0, 1.0))[..., None] * AT_EASE
    return np.maximum(1.0 - np.prod(1.0 - np.clip(acts, 0.0, 1.0), axis=-2), ease)
