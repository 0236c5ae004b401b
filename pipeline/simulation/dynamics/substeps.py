"""Sub-steps: how finely a step is divided so that no body sinks too deep into another.

A body that hits something at speed v sinks in by v/ω, and ω h is given: a higher speed needs
shorter sub-steps and stiffer springs. So no body sinks in by more than `MAX_DEPTH` of its
half thickness, and within a sub-step none moves by more than ω h times that: no body passes
through another.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.compiled import Record, Records, compiled
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.impact_law import STIFFNESS
from pipeline.simulation.dynamics.kinematic_bodies import KinematicBodies
from pipeline.simulation.dynamics.mujoco_callback import array_at, native_callback
from pipeline.simulation.dynamics.record_array import zero_records
from pipeline.simulation.dynamics.rigid_body import Bodies, BodyModel
from pipeline.simulation.dynamics.terrain_grid import FRAME, frame_of, surface_at
from pipeline.simulation.dynamics.vectors import length, minus, row
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain.heightfield import HeightField

MAX_SUBSTEP = 1.0 / 900.0
"""Longest sub-step [s]."""

MAX_SUBSTEPS = 2000
"""Largest number of sub-steps of one step."""

MAX_DEPTH = 0.5
"""Largest depth, as a fraction of the least distance from centre to face."""

HOLD_STEPS = 24
"""Steps for which sub-steps stay as short as they were: a spring that softens under load loses
energy."""


LIMITS = np.dtype([("reach", "f8"), ("thin", "f8"), ("gone", "?")], align=True)
"""Farthest point and nearest facet of a body [m]; whether it was removed."""


ARRAY_NAMES = ("limits", "qpos", "qvel", "moves", "frame", "vertices", "paths")
COUNT_NAMES = ("bodies", "things", "points", "pushers")
ADDRESSES = np.dtype([*((name, "i8") for name in (*ARRAY_NAMES, *COUNT_NAMES)), ("quickest", "f8")])
"""Addresses and lengths of the arguments of `_quickest`, and its result."""

FLOAT64, INT32 = np.dtype("f8"), np.dtype("i4")


class Substeps:
    """Number of sub-steps of each step.

    Args:
        builds: N bodies.
        pushers: corners (V, 3) of P kinematic bodies, each in its own frame [m].
        field: the terrain.
        step: length of a step [s].
        qpos: (N + P, 7) p and q of bodies and kinematic bodies, a live view.
        qvel: (N + P, 6) v and w, a live view.
        moves: (N + P,) 0 for sleeping bodies, a live view.

    Attributes:
        limits: (N,) `LIMITS`.
        reach: (N,) distances of the farthest points of bodies [m].
    """

    def __init__(
        self,
        builds: Sequence[BodyModel],
        pushers: Sequence[Array],
        field: HeightField,
        step: float,
        qpos: Array,
        qvel: Array,
        moves: NDArray[np.int32],
    ) -> None:
        bodies = Bodies.of(builds)
        self.reach = bodies.reach
        self.limits = zero_records(len(builds), LIMITS)
        self.limits["reach"], self.limits["thin"] = bodies.reach, bodies.thin
        self.far = np.array([np.linalg.norm(corners, axis=1).max() for corners in pushers])
        self.step = step
        self.least = math.ceil(step / MAX_SUBSTEP)
        self._recent = deque([self.least], maxlen=HOLD_STEPS)
        self._paths = np.zeros((len(pushers), 5))
        frame, vertices = np.array([frame_of(field)]), np.ascontiguousarray(field.vertices)
        arrays = (self.limits, qpos, qvel, moves, frame, vertices, self._paths)
        counts = (len(builds), len(qpos), len(vertices), len(pushers))
        at = np.array([(*(a.ctypes.data for a in arrays), *counts, 0.0)], dtype=ADDRESSES)
        self._held, self._quickest = (*arrays, at), at["quickest"]
        self._at, self._look = at.ctypes.data, _native_quickest()

    def count(self, pushers: KinematicBodies) -> int:
        """Returns the number of sub-steps of the next step."""
        if len(self._paths):
            self._paths[:] = pushers.paths(self.far)
        # One address instead of many arrays: passing those takes longer than a step of one body.
        self._look(self._at, 0)
        need = math.ceil(self.step * self._quickest.item() / (MAX_DEPTH * STIFFNESS))
        self._recent.append(min(max(need, self.least), MAX_SUBSTEPS))
        return max(self._recent)


@cache
def _native_quickest() -> Callable[[int, int], None]:
    """Returns the native function that writes the result of `_quickest` beside its arguments."""

    def look(where: int, _: int) -> None:
        at = array_at(where, 1, ADDRESSES)[0]
        at.quickest = _quickest(
            array_at(at.limits, at.bodies, LIMITS),
            array_at(at.qpos, 7 * at.things, FLOAT64).reshape(-1, 7),
            array_at(at.qvel, 6 * at.things, FLOAT64).reshape(-1, 6),
            array_at(at.moves, at.things, INT32),
            array_at(at.frame, 1, FRAME)[0],
            array_at(at.vertices, 3 * at.points, FLOAT64).reshape(-1, 3),
            array_at(at.paths, 5 * at.pushers, FLOAT64).reshape(-1, 5),
        )

    return native_callback(look)


@compiled
def _quickest(
    limits: Records,
    qpos: Array,
    qvel: Array,
    moves: NDArray[np.int32],
    frame: Record,
    vertices: Array,
    paths: Array,
) -> float:
    """Returns the greatest speed of a body or against it, in its thickness [1/s].

    Args:
        limits: (N,) `LIMITS`.
        qpos: see `Substeps`.
        qvel: see `Substeps`.
        moves: see `Substeps`.
        frame: of the terrain.
        vertices: of the terrain, see `Grid`.
        paths: (P, 5) start of kinematic bodies, reach including the way of two steps [m], and speed
            [m/s].
    """
    most = 0.0
    for i in range(len(limits)):
        p, speed = (qpos[i, 0], qpos[i, 1], qpos[i, 2]), 0.0
        if moves[i] != 0 and not limits[i].gone:
            v, w = qvel[i, :3], qvel[i, 3:]
            height, _ = surface_at(frame, vertices, p[0], p[2])
            # A falling body will be faster when it reaches the ground.
            falling = 2.0 * GRAVITY * max(p[1] - height - limits[i].thin, 0.0)
            speed = math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + falling)
            speed += math.sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]) * limits[i].reach
        pushed = 0.0
        for k in range(len(paths)):
            if length(minus(p, row(paths, k))) - limits[i].reach < paths[k, 3]:
                pushed = max(pushed, paths[k, 4])
        most = max(most, (speed + pushed) / limits[i].thin)
    return most
