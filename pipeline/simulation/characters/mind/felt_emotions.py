"""Felt emotions: how feelings show in faces, and what the take tells of minds."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.characters.mind.mind_arrays import MindArrays
from pipeline.simulation.dynamics.compiled import entry
from pipeline.simulation.spatial import Array


class FaceRates(NamedTuple):
    """How feelings show in a face.

    Attributes:
        worry: anxiety from which it looks like fear, too.
        anxious_fear: fear of full anxiety, by the anxiety beyond worry.
        anxious_sadness: sadness of full anxiety.
        hug_joy: joy in somebody's arms.
        interest: curiosity by the salience of the focus.
    """

    worry: float = 0.5
    anxious_fear: float = 0.8
    anxious_sadness: float = 0.9
    hug_joy: float = 0.9
    interest: float = 1.3


FACE = FaceRates()

JOYS: Mapping[str, float] = {"play": 0.8, "comfort": 0.5, "carry": 0.35, "push": 0.7, "ride": 0.9}
"""Joy in a face by the present behaviour."""


@entry
def show_feelings(arrays: MindArrays, felt: Array, told: Array, turns: NDArray[np.int64]) -> None:
    """Let feelings show of the minds whose turn it is.

    Args:
        arrays: all minds.
        felt: (P, 6) emotions of people, in the order of `EMOTIONS`, from 0 to 1; changed.
        told: (M, 5) channels of the take, of which the first three are set: anxiety, distance of
            the caregiver [m], and focus.
        turns: numbers of these minds.
    """
    for n in turns:
        mind, fear = arrays.minds[n], 0.0
        anxiety, anger = mind.anxiety, mind.anger
        for c in range(arrays.fears.shape[1]):
            # Far-off threats frighten less.
            fear = max(fear, arrays.fears[n, c] * arrays.nearness[n, c])
        fear = min(fear + FACE.anxious_fear * max(anxiety - FACE.worry, 0.0), 1.0)
        worried = FACE.anxious_sadness * anxiety
        calm = 1.0 - max(fear, worried, anger)
        joy = mind.delight * (1.0 - anxiety) * (1.0 - max(fear, anger))
        curiosity = min(FACE.interest * mind.focus_salience, 1.0) * calm * (1.0 - joy)
        face = felt[mind.person]
        face[0], face[1], face[2] = joy, min(worried, 1.0) * (1.0 - fear), anger
        face[3], face[4], face[5] = fear, 0.0, curiosity
        told[n, 0], told[n, 1], told[n, 2] = anxiety, mind.caregiver_distance, mind.focus
