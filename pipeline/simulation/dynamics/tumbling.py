"""Tumbling: how a rigid body turns while no torque acts on it.

Euler's equations and the attitude's, in the frame of the body,

    I ω' = (I ω) × ω,        q' = q ⊗ (0, ω) / 2,

are quadratic, so each coefficient of their power series in time follows from the ones
before: no rule of a certain order is chosen, the series is cut where its terms no longer
count. It also says where the body is at any time of the step, for the price of a polynomial,
which is what an impact is looked for with. A body of isotropic inertia (`inertia: scalar`)
has no first equation: it turns at a constant rate.

Source: Sims 1987, 7.1. (7.7) lacks the gyroscopic term, which vanishes only for isotropic
inertia, and (7.9) with ω in the world is R' = Rot(ω Δt) R.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array, cross

ORDER = 12
"""Highest power of time in the series."""

MOST_TURN = 0.15
"""Angle that a step may turn by, about [rad]: the terms left out are then below 1e-13."""


@dataclass(frozen=True, eq=False)
class Tumble:
    """The turning of B bodies over one step.

    Attributes:
        q: (ORDER + 1, B, 4) coefficients of the attitude.
        w: (ORDER + 1, B, 3) of the angular velocity in the body's frame.
    """

    q: Array
    w: Array

    @staticmethod
    def of(q: Array, w: Array, inertia: Array, inverse: Array) -> Tumble:
        """Return the series from attitudes q (B, 4) and angular velocities w (B, 3) [rad/s].

        Args:
            q: attitudes wxyz.
            w: in the frame of the body.
            inertia: (B, 3, 3) [kg m²].
            inverse: (B, 3, 3) of the same.
        """
        qs, ws = np.zeros((ORDER + 1, *q.shape)), np.zeros((ORDER + 1, *w.shape))
        momenta = np.zeros_like(ws)
        qs[0], ws[0] = q, w
        momenta[0] = (inertia @ w[..., None])[..., 0]
        for k in range(ORDER):
            turning = _product(qs[: k + 1], ws[k::-1]).sum(axis=0)
            qs[k + 1] = turning * (0.5 / (k + 1))
            torque = cross(momenta[: k + 1], ws[k::-1]).sum(axis=0) / (k + 1)
            ws[k + 1] = (inverse @ torque[..., None])[..., 0]
            momenta[k + 1] = torque
        return Tumble(qs, ws)

    def at(self, time: Array) -> tuple[Array, Array]:
        """Return attitudes (B, 4) and angular velocities (B, 3) at times (B,) of the step [s]."""
        t = time[:, None]
        q, w = self.q[-1], self.w[-1]
        for k in range(ORDER - 1, -1, -1):
            q, w = self.q[k] + t * q, self.w[k] + t * w
        # Square by square: how a norm adds up is left to no library.
        length = np.sqrt(q[:, 0] ** 2 + q[:, 1] ** 2 + q[:, 2] ** 2 + q[:, 3] ** 2)
        return q / length[:, None], w

    def some(self, which: NDArray[np.int64]) -> Tumble:
        """Return the turning of some of the bodies."""
        return Tumble(self.q[:, which], self.w[:, which])


def _product(q: Array, w: Array) -> Array:
    """Return q ⊗ (0, w) (..., 4) of quaternions (..., 4) and vectors (..., 3)."""
    a, b, c, d = q[..., 0], q[..., 1], q[..., 2], q[..., 3]
    x, y, z = w[..., 0], w[..., 1], w[..., 2]
    return np.stack(
        [
            -b * x - c * y - d * z,
            a * x + c * z - d * y,
            a * y + d * x - b * z,
            a * z + b * y - c * x,
        ],
        axis=-1,
    )
