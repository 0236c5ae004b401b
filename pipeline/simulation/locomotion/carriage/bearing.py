"""Bearing: how creatures carry themselves, whatever the gait that they go in.

Heads high or low, tails up or down, a body that is held nose up, how much all of it sways,
wanders and swings. Moods are told by it; a creature without a mood has the neutral one.

Source: Sims 1987, 3.2.4 and 9.1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from pipeline.simulation.spatial import Array


@dataclass(frozen=True, eq=False)
class Bearing:
    """The bearing of C creatures, at one moment (C,) or at several (n, C).

    Whoever changes it while they go does so little by little: it is followed at once. Joints
    keep their limits and bodies `MOST_PITCH` whatever it asks for.

    Attributes:
        head_raise: by how much necks are raised [rad].
        head_turn: how far heads look where they go, as a factor; 1 all the way.
        tail_raise: by how much tails are raised [rad].
        body_pitch: by how much bodies are held nose up [rad].
        sway: factor on what swings with the gait.
        wander: factor on what moves of its own accord.
        looseness: factor on what trails behind and swings on: 0 stiff, 1 as usual, 2 floppy.
    """

    head_raise: Array
    head_turn: Array
    tail_raise: Array
    body_pitch: Array
    sway: Array
    wander: Array
    looseness: Array

    @staticmethod
    def neutral(count: int) -> Bearing:
        """Return the bearing of `count` creatures in no mood."""
        none, one = np.zeros(count), np.ones(count)
        return Bearing(none, one, none, none, one, one, one)

    @staticmethod
    def stacked(moments: Sequence[Bearing]) -> Bearing:
        """Return those of several moments as one (n, C)."""
        first, names = moments[0], [f.name for f in fields(Bearing)]
        if all(one is first for one in moments):
            # No mood changes in most films, nor in most dozens of rows.
            shape = len(moments), len(first.sway)
            return Bearing(*(np.broadcast_to(getattr(first, name), shape) for name in names))
        return Bearing(*(np.stack([getattr(one, name) for one in moments]) for name in names))
