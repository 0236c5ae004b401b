"""Sub-steps: how finely a step has to be cut so that nothing sinks too deep into anything.

What hits something at speed v sinks in by v/ω, where ω h is given: more quickly means
shorter sub-steps and harder springs. Nothing sinks in by more than `DEEPEST` of its own
half thickness then, and within a sub-step nothing moves by more than ω h times that, so
nothing can pass through anything.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.compiled import Record, Records, entry
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.grid import frame_of, surface
from pipeline.simulation.dynamics.impact_law import STIFFNESS
from pipeline.simulation.dynamics.pushing import Pushers
from pipeline.simulation.dynamics.records import zeros
from pipeline.simulation.dynamics.rigid import Bodies, Build
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


class Substeps:
    """Counts the sub-steps that each step needs."""

    def __init__(
        self, builds: Sequence[Build], pushers: Sequence[Array], field: HeightField, step: float
    ) -> None:
        bodies = Bodies.of(builds)
        self.reach = bodies.reach
        self.limits = zeros(len(builds), LIMITS)
        self.limits["reach"], self.limits["thin"] = bodies.reach, bodies.thin
        self.far = np.array([np.linalg.norm(corners, axis=1).max() for corners in pushers])
        self.frame, self.vertices = frame_of(field), np.ascontiguousarray(field.vertices)
        self.step = step
        self.least = math.ceil(step / LONGEST)
        self._recent = deque([self.least], maxlen=CALM)

    def count(
        self,
        qpos: Array,
        qvel: Array,
        moves: NDArray[np.int32],
        pushers: Pushers,
    ) -> int:
        """Return the sub-steps of the step to come.

        Args:
            qpos: (N + P, 7) p and q of the bodies, then of those who push.
            qvel: (N + P, 6) v and w of them.
            moves: (N,) 0 of bodies that sleep.
            pushers: who push them.
        """
        stiffness = _quickest(
            self.limits, qpos, qvel, moves, self.frame, self.vertices, pushers.paths(self.far)
        )
        need = math.ceil(self.step * stiffness / (DEEPEST * STIFFNESS))
        self._recent.append(min(max(need, self.least), MOST))
        return max(self._recent)


@entry
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
        qpos: see `Substeps.count`, and so on.
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
            height, _ = surface(frame, vertices, p[0], p[2])
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
