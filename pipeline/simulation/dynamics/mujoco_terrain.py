"""MuJoCo terrain: bodies meet a height field at the contacts of `terrain_contacts`.

MuJoCo treats a height field as prisms side by side and finds one contact with each, so a ball is
pushed sideways by the edges between prisms whose tops lie in one plane, and which way depends on
the diagonals of the cells. Here MuJoCo's entry for a height field in its table of collision
functions is replaced while a world is stepped: normals are those of the true surface, the same as
for bodies that meet the terrain alone. For MuJoCo the ground is then only a box that tells what is
near.
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.body_record import (
    BODY,
    MAX_CONTACTS,
    Shapes,
    Workspace,
    records_of,
)
from pipeline.simulation.dynamics.compiled import Record, Records, allocating, compiled
from pipeline.simulation.dynamics.contact_solver import SOLVER_CONTACT
from pipeline.simulation.dynamics.mujoco_callback import (
    Layout,
    array_at,
    layout_of,
    native_collision,
)
from pipeline.simulation.dynamics.rigid_body import Bodies, BodyModel, State
from pipeline.simulation.dynamics.terrain_bodies import workspace_of
from pipeline.simulation.dynamics.terrain_contacts import find_body_contacts, is_under_ground
from pipeline.simulation.dynamics.terrain_grid import FRAME, Grid, frame_of, grid_of
from pipeline.simulation.dynamics.vectors import Vector, plus, row, times
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain.heightfield import HeightField

FOUND_CONTACT = np.dtype(
    [
        # Gap, negative at overlap [m]; position [m]; normal from the ground; first tangent, zero
        # for any.
        ("dist", "f8"),
        ("pos", "f8", 3),
        ("normal", "f8", 3),
        ("tangent", "f8", 3),
    ]
)
"""MuJoCo's `mjPreContact`, which a collision function fills."""

ARRAY_NAMES = (
    *("bodies", "positions", "attitudes", "owners", "frame"),
    *("vertices", "tops", "ridges", "starts", "sides"),
    *("corners", "facets", "edges"),
    *("world", "room_edges", "series", "parts"),
)
ARRAYS = np.dtype([(name, "i8", 3) for name in ARRAY_NAMES])
"""Address, rows and columns of each array that the collision function reads or writes."""

FLOAT64, INT64, INT32 = np.dtype("f8"), np.dtype("i8"), np.dtype("i4")

USER_VALUE = 1
"""User value of the data that holds the address of `ARRAYS`; the impact law has the one before."""

BODY_GEOMS = ("mjGEOM_SPHERE", "mjGEOM_BOX", "mjGEOM_MESH")
"""Types of geoms that bodies have."""


LIBRARY_NAMES = ("libmujoco.so*", "libmujoco*.dylib", "mujoco.dll")
"""File names of MuJoCo's library beside its bindings."""


class TerrainCollision:
    """Contacts of the bodies of one world with a height field.

    Args:
        builds: N bodies.
        state: a state of them.
        field: the terrain.
        model: of MuJoCo; bodies follow the world in order.
        data: its state, with room for two user values.
        mujoco: the module.
    """

    def __init__(
        self,
        builds: Sequence[BodyModel],
        state: State,
        field: HeightField,
        model: Any,
        data: Any,
        mujoco: Any,
    ) -> None:
        grid = grid_of(field)
        records, shapes = records_of(Bodies.of(builds), state)
        room = workspace_of(records)
        frame = np.array([frame_of(field)])
        owners = model.geom_bodyid
        arrays = (
            *(records, data.xpos, data.xquat, owners, frame),
            *(grid.vertices, grid.tops, grid.ridges, grid.starts, grid.sides),
            *(shapes.corners, shapes.facets, shapes.edges),
            *(room.world, room.edges, room.series, room.parts),
        )
        at = np.zeros(1, dtype=ARRAYS)
        for name, values in zip(ARRAY_NAMES, arrays, strict=True):
            at[name] = values.ctypes.data, len(values), values.size // max(len(values), 1)
        data.userdata.view(np.int64)[USER_VALUE] = at.ctypes.data
        self._held = (*arrays, at)
        self._function = _compile_collision(layout_of(mujoco))
        self._table = _collision_table(mujoco)
        terrain, geoms = mujoco.mjtGeom.mjGEOM_HFIELD, mujoco.mjtGeom
        self._entries = [(int(terrain), int(getattr(geoms, name))) for name in BODY_GEOMS]

    @contextmanager
    def installed(self) -> Iterator[None]:
        """Replaces MuJoCo's collision functions for height fields for a while."""
        address = ctypes.cast(self._function, ctypes.c_void_p).value
        before = [self._table[a][b] for a, b in self._entries]
        try:
            for a, b in self._entries:
                self._table[a][b] = address
            yield
        finally:
            for (a, b), function in zip(self._entries, before, strict=True):
                self._table[a][b] = function


@cache
def _collision_table(mujoco: Any) -> Any:
    """Returns MuJoCo's table of collision functions by the types of two geoms, a live view."""
    folder = Path(mujoco.__file__).parent
    library = next(path for name in LIBRARY_NAMES for path in sorted(folder.glob(name)))
    count = int(mujoco.mjtGeom.mjGEOM_SDF) + 1
    table = (ctypes.c_void_p * count) * count
    return table.in_dll(ctypes.CDLL(str(library)), "mjCOLLISIONFUNC")


@cache
def _compile_collision(layout: Layout) -> Any:
    """Returns the collision function, which finds its arrays by the address in the user data."""
    data_kind = layout.data

    def collide(_: int, address: int, found: int, __: int, geom: int, margin: float) -> int:
        data = array_at(address, 1, data_kind)[0]
        where = array_at(data.userdata, USER_VALUE + 1, FLOAT64).view(np.int64)[USER_VALUE]
        # MuJoCo clears the user data when it resets after an invalid state.
        if where == 0:
            return 0
        at = array_at(where, 1, ARRAYS)[0]
        number = array_at(at.owners[0], at.owners[1], INT32)[geom]
        p = row(_floats(at.positions), number)
        turn = _floats(at.attitudes)
        q = (turn[number, 0], turn[number, 1], turn[number, 2], turn[number, 3])
        body = array_at(at.bodies[0], at.bodies[1], BODY)[number - 1]
        grid = Grid(
            array_at(at.frame[0], 1, FRAME)[0],
            _floats(at.vertices),
            _floats(at.tops),
            _integers(at.ridges),
            array_at(at.starts[0], at.starts[1], INT64),
            _floats(at.sides).reshape(at.sides[1], 2, 3),
        )
        if is_under_ground(grid, body, p):
            return 0
        shapes = Shapes(_floats(at.corners), _floats(at.facets), _integers(at.edges))
        room = Workspace(
            _floats(at.world),
            _floats(at.room_edges),
            _floats(at.series),
            array_at(at.parts[0], at.parts[1], SOLVER_CONTACT),
        )
        find_body_contacts(grid, shapes, body, p, q, margin, room)
        _write_contacts(body, p, array_at(found, MAX_CONTACTS, FOUND_CONTACT))
        return body.count

    return native_collision(collide)


@allocating
def _floats(entry: Array) -> Array:
    """Returns the matrix of an entry of `ARRAYS`."""
    return array_at(entry[0], entry[1] * entry[2], FLOAT64).reshape(entry[1], entry[2])


@allocating
def _integers(entry: Array) -> NDArray[np.int64]:
    """Returns the matrix of integers of an entry of `ARRAYS`."""
    return array_at(entry[0], entry[1] * entry[2], INT64).reshape(entry[1], entry[2])


@compiled
def _write_contacts(body: Record, p: Vector, found: Records) -> None:
    """Writes the contacts of a body at p for MuJoCo."""
    for k in range(body.count):
        gap, normal, contact = body.gap[k], row(body.normal, k), found[k]
        place = plus(p, row(body.lever, k))
        if body.radius > 0.0:
            # Halfway between both surfaces.
            place = plus(place, times(0.5 * gap, normal))
        contact.dist = gap
        for i in range(3):
            contact.pos[i], contact.normal[i], contact.tangent[i] = place[i], normal[i], 0.0
