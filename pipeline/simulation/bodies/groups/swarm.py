"""Swarm: insects around a point, each on a randomly excited spring.

Each coordinate x of a member, relative to the centre, obeys x'' = -k x - d x' + noise. Its
distribution after any time is normal, with the mean of the free oscillation and a covariance that
grows to the stationary one. So steps are exact, and the look of a swarm does not depend on their
length.

Source: Sims 1987, 3.2; Uhlenbeck and Ornstein 1930.
"""

from __future__ import annotations

import math

import numpy as np

from pipeline.simulation.bodies.groups import member_meshes
from pipeline.simulation.bodies.groups.group_rule import (
    CastIndex,
    CastPoses,
    GroupContext,
    GroupRule,
)
from pipeline.simulation.row_slice import Rows
from pipeline.simulation.seeds import generator
from pipeline.simulation.spatial import UP, Array, from_directions
from pipeline.simulation.take import Contact
from pipeline.spec.group import Swarm

DAMPING = 1.2
"""d, in units of the square root of k; below 2 it oscillates."""


class SwarmRule(GroupRule):
    """A swarm."""

    default_material = "black chitin"

    def __init__(self, setting: GroupContext, config: Swarm) -> None:
        self.setting = setting
        self.config = config
        self.chance = generator(*setting.seed)
        x, v = config.radius / math.sqrt(3.0), config.speed / math.sqrt(3.0)
        self.deviation = np.array([x, v])
        self.root = v / x
        shape = (config.count, 3)
        # The stationary distribution: a swarm has no beginning.
        self.x = x * self.chance.standard_normal(shape)
        self.v = v * self.chance.standard_normal(shape)
        rows = setting.world.clock.rows
        self.inventory = member_meshes.inventory(
            setting.name,
            setting.material,
            rows,
            config.count,
            [("", member_meshes.insect(config.size))],
            config.size,
        )
        self._around: int | None = None
        self._time = 0.0
        self._middle: Array | None = None

    def bind(self, cast: CastIndex) -> None:
        """See `Rule`."""
        if self.config.around is not None:
            path = f"{self.setting.path}.group.around"
            self._around = cast.number(self.config.around, path)

    def send(self, time: float, goal: tuple[float, float]) -> None:
        """See `Rule`; a swarm stays where it is."""

    def write(self, rows: Rows, times: Array, others: CastPoses) -> list[Contact]:
        """See `Rule`."""
        for k, time in enumerate(times):
            middle = self.setting.place if self._around is None else others.p[k, self._around]
            span = float(time) - self._time
            drift = np.zeros(3)
            if span > 0.0:
                self._advance(span)
                if self._middle is not None:
                    drift = (middle - self._middle) / span
            self._time, self._middle = float(time), middle
            p = middle + self.x
            p[:, 1] = np.maximum(p[:, 1], self.setting.height(p) + self.config.size)
            rows.positions[k] = p
            rows.rotations[k] = from_directions(_level(self.v + drift), np.tile(UP, (len(p), 1)))
        return []

    def _advance(self, span: float) -> None:
        """Advances by `span` [s]."""
        step, spread = oscillated(self.root, DAMPING, span, self.deviation)
        first, second = self.chance.standard_normal((2, *self.x.shape))
        x = step[0, 0] * self.x + step[0, 1] * self.v + spread[0, 0] * first
        v = step[1, 0] * self.x + step[1, 1] * self.v
        self.v = v + spread[1, 0] * first + spread[1, 1] * second
        self.x = x


def oscillated(root: float, damping: float, span: float, deviation: Array) -> tuple[Array, Array]:
    """Returns the transition of a stochastic oscillator over a time.

    Args:
        root: square root of k [1/s].
        damping: d in units of that, below 2.
        span: [s].
        deviation: (2,) stationary standard deviations of position and velocity.

    Returns:
        Φ (2, 2), and L (2, 2) with L Lᵀ = S - Φ S Φᵀ, S being the stationary covariance.
    """
    fade = 0.5 * damping * root
    swing = math.sqrt(root * root - fade * fade)
    c, s = math.cos(swing * span), math.sin(swing * span) / swing
    free = [[c + fade * s, s], [-root * root * s, c - fade * s]]
    step = math.exp(-fade * span) * np.array(free)
    left = np.diag(deviation**2) - (step * deviation**2) @ step.T
    a = math.sqrt(max(left[0, 0], 0.0))
    b = left[1, 0] / a if a > 0.0 else 0.0
    return step, np.array([[a, 0.0], [b, math.sqrt(max(left[1, 1] - b * b, 0.0))]])


def _level(v: Array) -> Array:
    """Returns directions (N, 3) of velocities, none of them vertical."""
    level = v.copy()
    level[:, 1] *= 0.4
    level[:, 0] += 1e-9
    return level
