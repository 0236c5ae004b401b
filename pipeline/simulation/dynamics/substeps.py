"""Sub-steps: how finely a step has to be cut so that nothing sinks too deep into anything.

What hits something at speed v sinks in by v/ω, where ω h is given: more quickly means
shorter sub-steps and harder springs. Nothing sinks in by more than `DEEPEST` of its own
half thickness then, and within a sub-step nothing moves by more than ω h times that, so
nothing can pass through anything.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.body_record import zero_records
from pipeline.simulation.dynamics.compiled import Record, Records, compiled
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.impact_law import STIFFNESS
from pipeline.simulation.dynamics.kinematic_bodies import KinematicBodies
from pipeline.simulation.dynamics.mujoco_callback import array_at, native_callback
from pipeline.simulation.dynamics.rigid_body import Bodies, BodyModel
from pipeline.simulation.dynamics.terrain_grid import FRAME, frame_of, surface_at
from pipeline.simulation.dynamics.vectors import length, minus, row
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain.heightfield import HeightField

LONGEST = 1.0 / 900.0
"""A sub-step [s]."""

MOST = 2000
"""Sub-steps of one step."""

DEEPEST = 0.5
"""How far things sink in at most, as a part of their least distance from middle to face."""

CALM = 24
"""Steps for which sub-steps stay as short as they were: a spring that turns soft under load
takes energy away."""


LIMITS = np.dtype([("reach", "f8"), ("thin", "f8"), ("gone", "?")], align=True)
"""Of a body: its farthest point and its nearest facet [m]; whether it was taken away."""


ARRAYS = ("limits", "qpos", "qvel", "moves", "frame", "vertices", "paths")
COUNTS = ("bodies", "things", "points", "pushers")
AT = np.dtype([*((name, "i8") for name in (*ARRAYS, *COUNTS)), ("quickest", "f8")])
"""Addresses of what `_quickest` works with, how many there are of what, and what it says."""

NUMBER, WHOLE = np.dtype("f8"), np.dtype("i4")


class Substeps:
    """Counts the sub-steps that each step needs.

    Args:
        builds: N bodies.
        pushers: corners (V, 3) of P convex solids that push, each in its own frame [m].
        field: the terrain.
        step: that is cut [s].
        qpos: (N + P, 7) p and q of the bodies, then of those who push, as they are from now on.
        qvel: (N + P, 6) v and w of them, likewise.
        moves: (N + P,) 0 of bodies that sleep, likewise.

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
        self.least = math.ceil(step / LONGEST)
        self._recent = deque([self.least], maxlen=CALM)
        self._paths = np.zeros((len(pushers), 5))
        frame, vertices = np.array([frame_of(field)]), np.ascontiguousarray(field.vertices)
        arrays = (self.limits, qpos, qvel, moves, frame, vertices, self._paths)
        counts = (len(builds), len(qpos), len(vertices), len(pushers))
        at = np.array([(*(a.ctypes.data for a in arrays), *counts, 0.0)], dtype=AT)
        self._held, self._quickest = (*arrays, at), at["quickest"]
        self._at, self._look = at.ctypes.data, _looking()

    def count(self, pushers: KinematicBodies) -> int:
        """Return the sub-steps of the step to come, in which somebody pushes."""
        if len(self._paths):
            self._paths[:] = pushers.paths(self.far)
        # Machine code that finds all by one address: to hand over so many arrays would take
        # longer than a step of one body.
        self._look(self._at, 0)
        stiffness = self._quickest.item()
        need = math.ceil(self.step * stiffness / (DEEPEST * STIFFNESS))
        self._recent.append(min(max(need, self.least), MOST))
        return max(self._recent)


@cache
def _looking() -> Callable[[int, int], None]:
    """Return what writes the answer of `_quickest` where it finds the question."""

    def look(where: int, _: int) -> None:
        at = array_at(where, 1, AT)[0]
        at.quickest = _quickest(
            array_at(at.limits, at.bodies, LIMITS),
            array_at(at.qpos, 7 * at.things, NUMBER).reshape(-1, 7),
            array_at(at.qvel, 6 * at.things, NUMBER).reshape(-1, 6),
            array_at(at.moves, at.things, WHOLE),
            array_at(at.frame, 1, FRAME)[0],
            array_at(at.vertices, 3 * at.points, NUMBER).reshape(-1, 3),
            array_at(at.paths, 5 * at.pushers, NUMBER).reshape(-1, 5),
        )

    made: Callable[[int, int], None] = native_callback(look)
    return made


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
    """Return the greatest speed that a body has or is met with, in its thickness [1/s].

    Args:
        limits: (N,) `LIMITS`.
        qpos: see `Substeps`, and so on.
        qvel: see there.
        moves: see there.
        frame: of the terrain.
        vertices: of it, see `Grid`.
        paths: (P, 5) where those who push begin, how far they reach and go in two steps [m],
            and their speeds [m/s].
    """
    most = 0.0
    for i in range(len(limits)):
        p, speed = (qpos[i, 0], qpos[i, 1], qpos[i, 2]), 0.0
        if moves[i] != 0 and not limits[i].gone:
            v, w = qvel[i, :3], qvel[i, 3:]
            height, _ = surface_at(frame, vertices, p[0], p[2])
            # What falls will be quicker when it has come to the ground.
            falling = 2.0 * GRAVITY * max(p[1] - height - limits[i].thin, 0.0)
            speed = math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + falling)
            speed += math.sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]) * limits[i].reach
        pushed = 0.0
        for k in range(len(paths)):
            arm = minus(p, row(paths, k))
            if length(arm) - limits[i].reach < paths[k, 3]:
                pushed = max(pushed, paths[k, 4])
        most = max(most, (speed + pushed) / limits[i].thin)
    return most
