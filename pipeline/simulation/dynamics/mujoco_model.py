"""MuJoCo models: warnings, memory, and the terrain, as all adapters need them.

MuJoCo stands a height field on its local Z: here its X is our Z and its Y our X, so that its cells
are cut along our diagonal. Callers pass the module `mujoco`, which only adapters import.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain.heightfield import HeightField


def log_warnings(mujoco: Any) -> None:
    """Sends MuJoCo's warnings to the log, unless a handler is set.

    MuJoCo itself would write a file into the working directory.
    """
    if mujoco.get_mju_user_warning() is None:
        mujoco.set_mju_user_warning(_log_warning)


def _log_warning(message: str) -> None:
    logging.getLogger(__name__).warning("MuJoCo: %s", message)


GROUND_THICKNESS = 5.0
"""Thickness of the ground [m]."""

QUAD_SUBDIVISION = 4
"""Cells that replace a cell of quadrilaterals, along each side: MuJoCo has triangles."""

BASE_MEMORY = 2**25
"""Memory of a model for contacts, committed as it is used [bytes]."""

MEMORY_PER_BODY = 2**18
"""The same for each body [bytes]."""

MIN_FIELD_HEIGHT = 1e-9
"""Least height of a height field [m]."""


def is_level(field: HeightField) -> bool:
    """Returns whether all of a terrain has one height."""
    return float(np.ptp(field.heights)) == 0.0


def memory_for(bodies: int) -> int:
    """Returns the memory that a model of so many bodies needs for contacts [bytes]."""
    return BASE_MEMORY + MEMORY_PER_BODY * bodies


def use_upward_collision(option: Any, mujoco: Any) -> None:
    """Selects the collision algorithm that pushes bodies out of a height field upward.

    A height field is prisms side by side, and the shortest way out of one can be through its
    side. This algorithm searches along the line from inside a prism; with the other one boxes
    were thrown about at 1 m/s and more.
    """
    option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_NATIVECCD)


def add_ground(
    spec: Any, mujoco: Any, field: HeightField, matter: Mapping[str, Any], boxed: bool
) -> None:
    """Adds the terrain to a model.

    Args:
        spec: the model.
        mujoco: the module.
        field: the terrain.
        matter: common options of its geoms.
        boxed: whether it is a box, which only a level terrain can be; otherwise a height field.
    """
    c, s = math.cos(0.5 * field.heading), math.sin(0.5 * field.heading)
    turned = np.array([c, 0.0, s, 0.0])
    low = float(field.heights.min())
    if boxed:
        x, z = field.size[0] / 2.0, field.size[1] / 2.0
        spec.worldbody.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=[x, GROUND_THICKNESS, z],
            pos=[field.at[0], low - GROUND_THICKNESS, field.at[1]],
            quat=turned,
            **matter,
        )
        return
    # Local X to Z, Y to X and Z to Y, then the heading.
    quat = np.zeros(4)
    mujoco.mju_mulQuat(quat, turned, np.array([0.5, -0.5, -0.5, -0.5]))
    heights = _triangulated_heights(field)
    high, (size_x, size_z) = float(heights.max()), field.size
    spec.add_hfield(
        name="terrain",
        nrow=heights.T.shape[0],
        ncol=heights.T.shape[1],
        size=[0.5 * size_z, 0.5 * size_x, max(high - low, MIN_FIELD_HEIGHT), GROUND_THICKNESS],
        userdata=heights.T.ravel().tolist(),
    )
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_HFIELD,
        hfieldname="terrain",
        pos=[field.at[0], low, field.at[1]],
        quat=quat,
        **matter,
    )


def _triangulated_heights(field: HeightField) -> Array:
    """Returns heights whose cells, cut along the main diagonal, are the surface.

    Of quadrilaterals the finer grid misses the rest of a crease that runs the other way: up to a
    twenty-fourth of the distance of their corners from one plane.
    """
    if type(field) is HeightField:
        return field.heights
    n_x, n_z = QUAD_SUBDIVISION * field.cells[0], QUAD_SUBDIVISION * field.cells[1]
    x = np.linspace(-field.size[0] / 2.0, field.size[0] / 2.0, n_x + 1)
    z = np.linspace(-field.size[1] / 2.0, field.size[1] / 2.0, n_z + 1)
    return field.height(*field.to_world(*np.meshgrid(x, z)))
