"""Leading: more room ahead of who moves across the picture than behind."""

from __future__ import annotations

import numpy as np

from pipeline.production.camera.camera_path import Seen
from pipeline.simulation.curves import bounded
from pipeline.simulation.spatial import Array

LEAD = 0.1
"""How far a performer that moves is put back from the middle, as a part of the picture."""

LEAD_SPEED = 0.12
"""Speed at which that is nearly reached, in pictures a second."""


def ahead_of(velocity: Array, seen: Seen, lead: float | None, aspect: float) -> Array:
    """Return how far ahead of what it looks at (F, 3) a camera should look [m].

    It lies in the plane of the picture, along the motion as it is seen there, and grows with
    its speed: who stands still is in the middle.

    Args:
        velocity: (F, 3) of what it looks at [m/s].
        seen: the camera, with no room ahead.
        lead: the part of the picture, as the author says it; None for the usual one.
        aspect: width by height of the picture.
    """
    _, right, upward = seen.axes
    high = 2.0 * seen.tangent * np.linalg.norm(seen.target - seen.eye, axis=-1)
    across = np.einsum("fk,fk->f", velocity, right) / (high * aspect)
    along = np.einsum("fk,fk->f", velocity, upward) / high
    speed = np.hypot(across, along) / LEAD_SPEED
    slope = np.divide(bounded(speed), speed, out=np.ones_like(speed), where=speed > 1e-9)
    part = (LEAD if lead is None else lead) / LEAD_SPEED * slope
    sideways = (part * across * high * aspect)[:, None] * right
    shift: Array = sideways + (part * along * high)[:, None] * upward
    return shift
