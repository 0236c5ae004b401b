"""Blending of walking and jumping poses.

At the start and the end of a jump both poses stand on the same feet; only the bodies are blended.
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
    """One jumping creature at one moment.

    Attributes:
        blend: from its walking pose (0) to its jumping pose (1).
        R: (3, 3) orientation of its body.
        p: (3,) place of its body [m].
        tips: (n, 3) feet [m]; None after landing, when it stands or steps like a walker.
        down: (n,) which feet are on the ground, or step.
        speed: over the ground [m/s].
        limp: whether it has fallen.
    """

    blend: float
    R: Array
    p: Array
    tips: Array | None
    down: NDArray[np.bool_]
    speed: float
    limp: bool


class JumpHandover:
    """The jumping creatures of a herd at n moments.

    Attributes:
        herd: the creatures.
        entries: moment, creature, and its body.
        down: (n, L) feet on the ground or walking.
        limp: (n, C) fallen creatures.
    """

    def __init__(self, herd: Herd, bodies: Sequence[Mapping[int, JumpingBody]]) -> None:
        self.herd = herd
        self.entries = [(k, c, body) for k, row in enumerate(bodies) for c, body in row.items()]
        self.down = np.ones((len(bodies), len(herd.owner)), dtype=bool)
        self.limp = np.zeros((len(bodies), len(herd.names)), dtype=bool)
        for k, c, body in self.entries:
            self.down[k, herd.owner == c] = body.down
            self.limp[k, c] = body.limp

    def bodies(self, R_WB: Array, p_WB: Array) -> None:
        """Blend bodies (n, C, 3, 3), (n, C, 3) in place towards their jumping poses [m]."""
        for k, c, body in self.entries:
            if body.blend == 1.0:
                R_WB[k, c], p_WB[k, c] = body.R, body.p
                continue
            p_WB[k, c] += body.blend * (body.p - p_WB[k, c])
            q, r = quaternion(np.stack([R_WB[k, c], body.R]))
            r = r if (q * r).sum() >= 0.0 else -r
            mean = q + body.blend * (r - q)
            R_WB[k, c] = matrix((mean / np.sqrt((mean * mean).sum()))[None])[0]

    def walking_weights(self) -> Array:
        """Return how far creatures walk (n, C), 1, rather than jump, 0."""
        result = np.ones(self.limp.shape)
        for k, c, body in self.entries:
            result[k, c] = 1.0 - body.blend
        return result

    def feet(self, tips: Array) -> Array:
        """Return feet (n, L, 3) with those of jumping creatures replaced [m]."""
        result = tips.copy()
        for k, c, body in self.entries:
            if body.tips is not None:
                result[k, self.herd.owner == c] = body.tips
        return result

    def speeds(self, speeds: Array) -> None:
        """Blend the speeds (n, C) of jumping creatures in place [m/s]."""
        for k, c, body in self.entries:
            speeds[k, c] += body.blend * (body.speed - speeds[k, c])
