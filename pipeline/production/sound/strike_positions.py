"""Strike positions: the point of impact on a part, along its longest axis."""

from __future__ import annotations

import numpy as np

from pipeline.simulation.sound_detection.sound_sources import rigid_parts
from pipeline.simulation.spatial import Array, matrix, turn_inverse
from pipeline.simulation.take import SoundEvent, Take


class StrikePositions:
    """Finds the point of impact of events on the rigid parts of a take."""

    def __init__(self, take: Take) -> None:
        self._take = take
        parts = rigid_parts(take.parts, take.meshes)
        self._parts = {take.nodes[node].name: part for node, part in parts.items()}
        self._axes: dict[str, tuple[Array, float, float]] = {}

    def position(self, event: SoundEvent) -> float | None:
        """Return the point of impact along the part that sounds, 0 to 1; None if unknown.

        A limb touches with its last link.
        """
        name = self._node_name(event)
        if name is None:
            return None
        take, part = self._take, self._parts[name]
        row = min(event.track[0], len(take.positions) - 1)
        R_WN = matrix(take.rotations[row, part.node])
        p_NC = turn_inverse(R_WN, np.array(event.place) - take.positions[row, part.node])
        axis, first, last = self._long_axis(name)
        along = float(((p_NC + take.nodes[part.node].rest) * axis).sum())
        if last <= first:
            return None
        return round(min(max((along - first) / (last - first), 0.0), 1.0), 4)

    def _node_name(self, event: SoundEvent) -> str | None:
        """Return the node of a rigid part that touches; None if there is none."""
        for name in (f"{event.who}.{event.part}", event.part, event.who):
            if name in self._parts:
                return name
            links = [n for n in self._parts if n.rpartition(".")[0] == name]
            last = max((n for n in links if n.rpartition(".")[2].isdecimal()), default=None)
            if last is not None:
                return last
        return None

    def _long_axis(self, name: str) -> tuple[Array, float, float]:
        """Return the longest axis of a part, and the range of its vertices along it [m]."""
        if name not in self._axes:
            part = self._parts[name]
            axis = part.principal_axes[:, -1]
            # Eigenvectors have no sign; fix one.
            axis = axis * np.copysign(1.0, axis[np.abs(axis).argmax()])
            along = (part.mesh.vertices.astype(float) * axis).sum(axis=1)
            self._axes[name] = axis, float(along.min()), float(along.max())
        return self._axes[name]
