"""Path: how bodies move over one sub-step, known at every time of it.

In flight the acceleration is constant and the tumbling a power series. While the ground
holds or pushes a body, its velocity and its turning go over into those after the sub-step
at a constant rate. So places are advanced exactly in both: p + v t + a t² / 2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.rigid import State, dot, turned, unturned
from pipeline.simulation.dynamics.tumbling import Tumble
from pipeline.simulation.spatial import Array, matrix


@dataclass(frozen=True, eq=False)
class Path:
    """The motion of B bodies.

    Attributes:
        start: how they begin.
        a: (B, 3) acceleration [m/s²].
        tumble: of those in flight.
        driven: (B,) which ones are not.
        turn: (B, 3) angular velocity at the begin, in the world [rad/s].
        turn_rate: (B, 3) its change, of those that are driven [rad/s²].
    """

    start: State
    a: Array
    tumble: Tumble
    driven: NDArray[np.bool_]
    turn: Array
    turn_rate: Array

    def at(self, time: Array) -> State:
        """Return how they are at times (B,) of the sub-step [s]."""
        t = time[:, None]
        p = self.start.p + t * (self.start.v + 0.5 * t * self.a)
        v = self.start.v + t * self.a
        q, w = self.tumble.at(time)
        if self.driven.any():
            angle = t * (self.turn + 0.5 * t * self.turn_rate)
            driven_q = turned_by(self.start.q, angle)
            driven_w = unturned(matrix(driven_q), self.turn + t * self.turn_rate)
            q = np.where(self.driven[:, None], driven_q, q)
            w = np.where(self.driven[:, None], driven_w, w)
        return State(p, q, v, w)

    def some(self, which: NDArray[np.int64]) -> Path:
        """Return the motion of some of them."""
        return Path(
            self.start.some(which),
            self.a[which],
            self.tumble.some(which),
            self.driven[which],
            self.turn[which],
            self.turn_rate[which],
        )


def turned_by(q: Array, angle: Array) -> Array:
    """Return attitudes (B, 4) turned by rotation vectors (B, 3) in the world [rad]."""
    half = 0.5 * np.sqrt(dot(angle, angle))
    s = 0.5 * np.sinc(half / np.pi)
    a, (b, c, d) = np.cos(half), (s[:, None] * angle).T
    w, x, y, z = q.T
    result: Array = np.stack(
        [
            a * w - b * x - c * y - d * z,
            a * x + b * w + c * z - d * y,
            a * y + c * w + d * x - b * z,
            a * z + d * w + b * y - c * x,
        ],
        axis=-1,
    )
    w, x, y, z = result.T
    result /= np.sqrt(w * w + x * x + y * y + z * z)[:, None]
    return result


def in_world(state: State) -> Array:
    """Return the angular velocities (B, 3) in the world [rad/s]."""
    return turned(matrix(state.q), state.w)
