"""Mind arrays: what all minds of a troupe know and feel, one row for each mind.

M minds, C characters.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.characters.body_arrays import NOBODY, RecordArray
from pipeline.simulation.characters.mind.sight import WALK
from pipeline.simulation.dynamics.record_array import zero_records
from pipeline.simulation.spatial import Array

NOISE_ROWS = 8
"""Thoughts for which a mind draws random numbers at once: each draw has its cost."""

MIND = np.dtype(
    [
        # Numbers of its character, its `PERSON` record, and its caregiver or NOBODY.
        ("owner", "i8"),
        ("person", "i8"),
        ("caregiver", "i8"),
        # Natural anxiety; anxiety and anger now, all from 0 to 1; distance of the caregiver [m].
        ("natural_anxiety", "f8"),
        ("anxiety", "f8"),
        ("anger", "f8"),
        ("caregiver_distance", "f8"),
        # Whether it returns to its caregiver, and has somebody in its arms.
        ("returns", "?"),
        ("hugs", "?"),
        # The most salient character or NOBODY, and its salience; the time of the last thought [s].
        ("focus", "i8"),
        ("focus_salience", "f8"),
        ("now", "f8"),
        # Row of its noise that the next thought takes.
        ("noise_row", "i8"),
        # Joy in what it does, from 0 to 1, before its worries.
        ("delight", "f8"),
    ],
    align=True,
)
"""A mind."""


class MindArrays(NamedTuple):
    """What all minds know and feel.

    Attributes:
        minds: (M,) `MIND`.
        places: (M, C, 3) where each believes the others to be [m].
        velocities: (M, C, 3) of these when they were last in view [m/s].
        seen: (M, C) time when each was last in view [s].
        in_view: (M, C) whether each is in view.
        distances: (M, C) over the ground to the remembered places [m].
        interest: (M, C) natural interest in each.
        lasting_fears: (M, C) to which fears fall in time, such as of a foe.
        fears: (M, C) how much each frightens, from 0 to 1, such as after a blow.
        salience: (M, C) how interesting each is.
        valence: (M, C) how good each is, from -1 to 1.
        priority: (M, C) of watching each, from 0 to about 1.
        nearness: (M, C) 1 for what is close, less for what is far.
        noise: (M, NOISE_ROWS, C) random numbers from 0 to 1 for so many thoughts.
        at: (M, 2) x and z of each itself [m].
        walks: (M,) `WALK` of each.
    """

    minds: RecordArray
    places: Array
    velocities: Array
    seen: Array
    in_view: NDArray[np.bool_]
    distances: Array
    interest: Array
    lasting_fears: Array
    fears: Array
    salience: Array
    valence: Array
    priority: Array
    nearness: Array
    noise: Array
    at: Array
    walks: RecordArray


def mind_arrays(places: Array, interest: Array, valence: Array) -> MindArrays:
    """Return minds at the start of a film, when everybody is known.

    Args:
        places: (C, 3) of all characters [m].
        interest: (M, C) natural interest of each mind in each.
        valence: (C,) natural valence of each.
    """
    shape = interest.shape
    minds = zero_records(len(interest), MIND)
    minds["caregiver"] = minds["focus"] = NOBODY
    return MindArrays(
        minds,
        places=np.broadcast_to(places, (*shape, 3)).copy(),
        velocities=np.zeros((*shape, 3)),
        seen=np.zeros(shape),
        in_view=np.ones(shape, dtype=bool),
        distances=np.zeros(shape),
        interest=interest,
        lasting_fears=np.zeros(shape),
        fears=np.zeros(shape),
        salience=np.zeros(shape),
        valence=np.broadcast_to(valence, shape).copy(),
        priority=np.zeros(shape),
        nearness=np.zeros(shape),
        noise=np.zeros((shape[0], NOISE_ROWS, shape[1])),
        at=np.zeros((len(interest), 2)),
        walks=zero_records(len(interest), WALK),
    )
