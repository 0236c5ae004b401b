"""Aloft: where walkers that jump are, and how that takes the place of where they would walk.

When a jump begins and when it has ended, both stand on the same feet: only their bodies are
brought from one to the other, little by little.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.spatial import Array, matrix, quaternion


@dataclass(frozen=True, eq=False)
class JumpingBody:
    """One creature that jumps, at one moment.

    Attributes:
        part: how far it is where its jump has it rather than its walk, 0 to 1.
        R: (3, 3) and
        p: (3,) of its body [m].
        tips: (n, 3) of its feet [m]; None when it has landed, and stands or steps as walkers do.
        down: (n,) which are on the ground, or step so.
        speed: over the ground [m/s].
        limp: whether it has fallen.
    """

    part: float
    R: Array
    p: Array
    tips: Array | None
    down: NDArray[np.bool_]
    speed: float
    limp: bool


class JumpHandover:
    """The creatures of a herd that jump, at n moments.

    Attributes:
        herd: that they belong to.
        entries: number of the moment, creature, and how it is.
        down: (n, L) feet that are on the ground or walk.
        limp: (n, C) who has fallen.
    """

    def __init__(self, herd: Herd, aloft: Sequence[Mapping[int, JumpingBody]]) -> None:
        self.herd = herd
        self.entries = [(k, c, one) for k, row in enumerate(aloft) for c, one in row.items()]
        self.down = np.ones((len(aloft), len(herd.owner)), dtype=bool)
        self.limp = np.zeros((len(aloft), len(herd.names)), dtype=bool)
        for k, c, one in self.entries:
            self.down[k, herd.owner == c] = one.down
            self.limp[k, c] = one.limp

    def bodies(self, R_WB: Array, p_WB: Array) -> None:
        """Bring the bodies (n, C, 3, 3), (n, C, 3) to where their jumps have them [m]."""
        for k, c, one in self.entries:
            if one.part == 1.0:
                R_WB[k, c], p_WB[k, c] = one.R, one.p
                continue
            p_WB[k, c] += one.part * (one.p - p_WB[k, c])
            q, r = quaternion(np.stack([R_WB[k, c], one.R]))
            r = r if (q * r).sum() >= 0.0 else -r
            between = q + one.part * (r - q)
            R_WB[k, c] = matrix((between / np.sqrt((between * between).sum()))[None])[0]

    def feet(self, tips: Array) -> Array:
        """Return tips (n, L, 3) with those of who jumps where they are then [m]."""
        result = tips.copy()
        for k, c, one in self.entries:
            if one.tips is not None:
                result[k, self.herd.owner == c] = one.tips
        return result

    def speeds(self, speeds: Array) -> None:
        """Put in the speeds (n, C) of who jumps [m/s]."""
        for k, c, one in self.entries:
            speeds[k, c] += one.part * (one.speed - speeds[k, c])
