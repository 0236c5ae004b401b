"""Automatic gaits: for any number of legs, and any imbalance between left and right.

The rows are timed independently, each by the legs that it has, so that a missing limb
is made up for.

Source: Sims 1987, 10.3.
"""

from __future__ import annotations

import numpy as np

from pipeline.simulation.locomotion.gaits.gait import Gait
from pipeline.simulation.locomotion.gaits.rows import Rows

FIRM = 0.84
"""Part of its turn for which a foot is in the air: feet that come down are firm before
the next ones leave."""

TROT_SWING = FIRM * 0.5

LEGS_A_WAVE = 5
"""About how many legs of a row share one wave. Long rows, a centipede's, carry several
waves at once, otherwise the feet would have to fly (Manton 1952)."""


def trot(rows: Rows) -> Gait:
    """Return the gait in which neighbours along a row and across the body take turns.

    A walk for two legs, a trot for four, a tripod gait for six.
    """
    up = np.zeros(rows.count)
    for first, row in enumerate(rows):
        for rank, leg in enumerate(row):
            up[leg] = 0.5 * ((rank + first) % 2)
    return Gait(up, np.mod(up + TROT_SWING, 1.0))


def wave(rows: Rows) -> Gait:
    """Return the gait in which each row lifts its feet in turn, from back to front.

    Both rows move together: a bound for four legs, a hop for two.
    """
    return _waves(rows, 0.0)


def ripple(rows: Rows) -> Gait:
    """Return the wave whose right row goes half a cycle after the left, an insect's.

    Source: Wilson 1966.
    """
    return _waves(rows, 0.5)


def _waves(rows: Rows, lag: float) -> Gait:
    up, swing = np.zeros(rows.count), np.zeros(rows.count)
    for first, row in enumerate(rows):
        n = len(row)
        turn = max(1, round(n / LEGS_A_WAVE)) / max(n, 1)
        for rank, leg in enumerate(row):
            up[leg] = (n - 1 - rank) * turn + first * lag
            swing[leg] = FIRM * min(turn, 0.5)
    return Gait(np.mod(up, 1.0), np.mod(up + swing, 1.0))
