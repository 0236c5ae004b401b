"""Strike positions: the point of impact on a part, along its longest axis."""

from __future__ import annotations

import numpy as np

from pipeline.production.sound.sounding_parts import RigidPart
from pipeline.simulation.spatial import Array, matrix, turn_inverse
from pipeline.simulation.take import SoundEvent, Take


class StrikePositions:
    """Finds the point of impact of events on the rigid parts of a take."""

    def __init__(self, take: Take) -> None:
        self._take = take
        self._axes: dict[int, tuple[Array, float, float]] = {}

    def position(self, event: SoundEvent, part: RigidPart) -> float | None:
        """Return the point of impact along a part, 0 to 1; None if unknown."""
        take = self._take
        row = min(event.track[0], len(take.positions) - 1)
        R_WN = matrix(take.rotations[row, part.node])
        p_NC = turn_inverse(R_WN, np.array(event.place) - take.positions[row, part.node])
        axis, first, last = self._long_axis(part)
        along = float(((p_NC + take.nodes[part.node].rest) * axis).sum())
        if last <= first:
            return None
        return round(min(max((along - first) / (last - first), 0.0), 1.0), 4)

    def _long_axis(self, part: RigidPart) -> tuple[Array, float, float]:
        """Return the longest axis of a part, and the range of its vertices along it [m]."""
        if part.node not in self._axes:
            axis = part.principal_axes[:, -1]
            # Eigenvectors have no sign; fix one.
            axis = axis * np.copysign(1.0, axis[np.abs(axis).argmax()])
            along = (part.mesh.vertices.astype(float) * axis).sum(axis=1)
            self._axes[part.node] = axis, float(along.min()), float(along.max())
        return self._axes[part.node]
