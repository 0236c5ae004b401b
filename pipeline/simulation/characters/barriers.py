"""Barriers: what of other rooms people go round, as circles on the ground.

A solid is seen as the box around it. What is long is a row of circles, so that nobody goes round
a wall as round a tower of the wall's length.
"""

from __future__ import annotations

import numpy as np

from pipeline.simulation.characters.layout import Numbers, Structures
from pipeline.simulation.characters.solids import SOLID
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground

LOW, HEADROOM = 0.07, 1.9
"""What ends so little above the ground is stepped over; what begins so high is gone under [m]."""

LIGHT = 15.0
"""What gives way and weighs less than this is no barrier, for people walk on into it: about a
quarter of what they weigh [kg]."""

MOST = 32
"""Circles of one solid."""


class Barriers:
    """The circles around solids, as they are now.

    Args:
        ground: the terrain.

    Attributes:
        middles: (n, 2) x and z [m].
        radii: (n,) [m].
        keys: (n,) numbers that a circle keeps while its solid stays as it lies.
        wholes: (n,) numbers of the things that they are of: limbs of one creature are one thing.
    """

    def __init__(self, ground: Ground) -> None:
        self._ground = ground
        self.put(np.zeros(0, dtype=SOLID))

    def put(self, solids: Structures) -> None:
        """Look at these solids (S,) `SOLID` from now on."""
        self._solids = solids
        self._which: Numbers = np.flatnonzero(solids["inverse_mass"] <= 1.0 / LIGHT)
        self._seen = b""
        self.middles, self.radii = np.zeros((0, 2)), np.zeros(0)
        self.keys: Numbers = np.zeros(0, dtype=np.int64)
        self.wholes: Numbers = np.zeros(0, dtype=np.int64)

    def look(self) -> bool:
        """See where the solids are now; tell whether anything is in anybody's way."""
        solids = self._solids
        if not len(self._which):
            return False
        seen = solids["p"].tobytes() + solids["R"].tobytes() + solids["here"].tobytes()
        if seen != self._seen:
            self._seen = seen
            self._look()
        return bool(len(self.radii))

    def _look(self) -> None:
        which = self._which
        which = which[self._solids["here"][which]]
        solids = self._solids[which]
        R, half = solids["R"], solids["half"]
        middle = solids["p"] + (R @ solids["middle"][:, :, None])[:, :, 0]
        # Of its axes in the world, as long as half of the box (S, axis, 3).
        axes = np.swapaxes(R, 1, 2) * half[:, :, None]
        rise = np.abs(axes[:, :, 1]).sum(axis=1)
        floor = self._ground.height(middle[:, 0], middle[:, 2])
        stands = (middle[:, 1] + rise > floor + LOW) & (middle[:, 1] - rise < floor + HEADROOM)
        self._lay(which[stands], middle[stands][:, [0, 2]], axes[stands][:, :, [0, 2]])

    def _lay(self, which: Numbers, middle: Array, axes: Array) -> None:
        """Lay rows of circles along shadows.

        Args:
            which: (S,) numbers of the solids.
            middle: (S, 2) [m].
            axes: (S, 3, 2) half of each edge of the box, seen from above [m].
        """
        longest = np.argmax((axes * axes).sum(axis=2), axis=1)
        ahead = axes[np.arange(len(axes)), longest]
        ahead = ahead / np.maximum(np.hypot(*ahead.T), 1e-9)[:, None]
        across = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1)
        long = np.abs((axes * ahead[:, None]).sum(axis=2)).sum(axis=1)
        wide = np.abs((axes * across[:, None]).sum(axis=2)).sum(axis=1)
        balls = self._solids["radius"][which]
        counts = np.clip(np.ceil(long / np.maximum(wide, 1e-3) - 1e-6), 1, MOST).astype(np.int64)
        counts[balls > 0.0] = 1
        radii = np.where(balls > 0.0, balls, np.hypot(long / counts, wide))
        row = np.repeat(np.arange(len(which)), counts)
        number = np.arange(len(row)) - np.repeat(np.cumsum(counts) - counts, counts)
        place = (2.0 * number + 1.0) / counts[row] - 1.0
        self.middles = middle[row] + (place * long[row])[:, None] * ahead[row]
        self.radii = radii[row]
        self.keys = which[row] * MOST + number
        self.wholes = self._solids["whole"][which[row]]
