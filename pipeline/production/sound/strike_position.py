"""Contact spots: where on itself a thing is struck, along its longest axis."""

from __future__ import annotations

import numpy as np

from pipeline.simulation.detect.scenery import Solid, solids_of
from pipeline.simulation.spatial import Array, matrix, unturn
from pipeline.simulation.take import SoundEvent, Take


class ContactSpots:
    """Finds spots on the solids of a take.

    Args:
        take: what happened.
    """

    def __init__(self, take: Take) -> None:
        self._take = take
        solids = solids_of(take.parts, take.meshes)
        self._solids = {take.nodes[node].name: solid for node, solid in solids.items()}
        self._axes: dict[str, tuple[Array, float, float]] = {}

    def spot(self, event: SoundEvent) -> float | None:
        """Return where the part that sounds is struck, 0 to 1; None if that is not known.

        What touches with a limb does so with its last link.
        """
        name = self._name(event)
        if name is None:
            return None
        take, solid = self._take, self._solids[name]
        row = min(event.track[0], len(take.positions) - 1)
        R_WN = matrix(take.rotations[row, solid.node])
        p_NC = unturn(R_WN, np.array(event.place) - take.positions[row, solid.node])
        axis, first, last = self._axis(name, solid)
        at = float(((p_NC + take.nodes[solid.node].rest) * axis).sum())
        return round(min(max((at - first) / (last - first), 0.0), 1.0), 4) if last > first else None

    def _name(self, event: SoundEvent) -> str | None:
        """Return the name of the node that touches; None if it is not of one piece."""
        for name in (f"{event.who}.{event.part}", event.part, event.who):
            if name in self._solids:
                return name
            links = [n for n in self._solids if n.rpartition(".")[0] == name]
            last = max((n for n in links if n.rpartition(".")[2].isdecimal()), default=None)
            if last is not None:
                return last
        return None

    def _axis(self, name: str, solid: Solid) -> tuple[Array, float, float]:
        """Return the longest axis of a solid, and where it begins and ends on it [m]."""
        if name not in self._axes:
            corners = solid.mesh.vertices.astype(float)
            spread = corners - corners.mean(axis=0)
            _, axes = np.linalg.eigh((spread[:, :, None] * spread[:, None, :]).sum(axis=0))
            axis = axes[:, -1]
            # Which way it points must not hang on how it was found.
            axis = axis * np.copysign(1.0, axis[np.abs(axis).argmax()])
            along = (corners * axis).sum(axis=1)
            self._axes[name] = axis, float(along.min()), float(along.max())
        return self._axes[name]
