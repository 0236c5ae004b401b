"""Bodies over a terrain: they fall, strike it, roll, and come to rest.

No body meets another, so each has its own sub-steps. Flights and sub-steps end where a body
strikes the ground, located on its path, so that bounce heights do not depend on the grid of
steps. A body that has lain still for a while sleeps.

Source: Sims 1987, ch. 12.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.body_record import (
    MAX_CONTACTS,
    Workspace,
    records_of,
)
from pipeline.simulation.dynamics.compiled import Records
from pipeline.simulation.dynamics.contact_solver import SOLVER_CONTACT
from pipeline.simulation.dynamics.free_motion import MAX_ORDER, SERIES_COLUMNS
from pipeline.simulation.dynamics.record_array import zero_records
from pipeline.simulation.dynamics.rigid_body import Bodies, State, dot, rotate
from pipeline.simulation.dynamics.rigid_step import (
    CONTACT_MARGIN,
    advance_bodies,
    find_contacts,
)
from pipeline.simulation.dynamics.terrain_grid import grid_of
from pipeline.simulation.spatial import Array, cross, matrix
from pipeline.simulation.terrain import Ground

Numbers = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class GroundImpact:
    """Impact of a body on the ground.

    Attributes:
        body: number of the body.
        time: from the start of the step [s].
        place: (3,) [m].
        normal: (3,) of the ground.
        speed: approach speed along the normal [m/s].
        energy: kinetic energy of the approach [J].
    """

    body: int
    time: float
    place: tuple[float, float, float]
    normal: tuple[float, float, float]
    speed: float
    energy: float


class TerrainBodies:
    """N bodies over a terrain.

    Attributes:
        bodies: their constants.
        state: their state; its arrays are views and may be written.
        ground: the terrain.
        awake: (N,) whether a body is not asleep.
    """

    def __init__(self, bodies: Bodies, state: State, ground: Ground) -> None:
        self.bodies = bodies
        self.ground = ground
        self._grid = grid_of(ground.field)
        self._records, self._shapes = records_of(bodies, state)
        self.state = State(*(self._records[name] for name in ("p", "q", "v", "w")))
        self.awake: NDArray[np.bool_] = self._records["awake"]
        self._room = workspace_of(self._records)
        self.find_contacts()

    def find_contacts(self) -> None:
        """Finds contacts anew after bodies were placed elsewhere."""
        slack = CONTACT_MARGIN * float(self.bodies.size.max())
        find_contacts(self._grid, self._shapes, self._records, self._room, slack)

    def depths(self) -> Array:
        """Returns the depth of each body in the ground (N,), negative above it [m]."""
        copies, slack = self._records.copy(), float(self.bodies.size.max())
        find_contacts(self._grid, self._shapes, copies, self._room, slack)
        return np.where(copies["count"] > 0, -copies["gap"][:, 0], -np.inf)

    def touching(self) -> tuple[NDArray[np.bool_], Array, Array, Array, Array]:
        """Returns the motion of bodies on the ground, at the nearest contact of each.

        Returns:
            Which bodies the ground holds (N,), and for these the positions of contacts (N, 3) [m],
            normals of the ground (N, 3), velocities (N, 3) [m/s], and tangential velocities of the
            contacts (N, 3) [m/s].
        """
        held = self.awake & (self._records["held"] > 0) & (self._records["count"] > 0)
        lever, normal = self._records["lever"][:, 0], self._records["normal"][:, 0]
        u = self.state.v + cross(rotate(matrix(self.state.q), self.state.w), lever)
        slip = u - dot(u, normal)[:, None] * normal
        return held, self.state.p + lever, normal, self.state.v, slip

    def drop(self, which: Numbers) -> None:
        """Removes bodies from the world: they no longer move."""
        self.awake[which] = False
        self.state.v[which] = self.state.w[which] = 0.0

    def advance(self, dt: float) -> list[GroundImpact]:
        """Advances by `dt` [s]; returns the impacts in the order of time."""
        strikes = advance_bodies(self._grid, self._shapes, self._records, self._room, dt)
        impacts = [
            GroundImpact(int(body), time, (x, y, z), (n_x, n_y, n_z), speed, energy)
            for body, time, x, y, z, n_x, n_y, n_z, speed, energy in strikes.tolist()
        ]
        return sorted(impacts, key=lambda one: (one.time, one.body))


def workspace_of(records: Records) -> Workspace:
    """Returns a workspace with room for each of some bodies."""
    vertices, edges = (int(records[name][:, 1].max()) for name in ("corners", "edges"))
    return Workspace(
        np.zeros((max(vertices, 1), 3)),
        np.zeros((max(edges, 1), 12)),
        np.zeros((MAX_ORDER + 1, SERIES_COLUMNS)),
        zero_records(MAX_CONTACTS, SOLVER_CONTACT),
    )
