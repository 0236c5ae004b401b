"""Swept rays: the camera moves on within each moment of an exposure.

Between the moments of an exposure, whatever moves jumps. That is too coarse for what passes close
to a camera that travels: blades of grass before the lens would be drawn as rows of dots. So rays
to what stands still leave from where the camera is at times spread over the moment. Rays to what
moves leave from its place at the moment itself, for they meet it as it is then.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

from render.camera_sweep import CameraSweep
from render.tracing.stratification import PassStrata, sample_1d

_STEP = 1 << 10
"""Step of the strata for the time of a ray: no path is so long."""


def swept_rays(sweep: CameraSweep, ray: Any, pixels: Any, strata: PassStrata) -> Any:
    """Return rays of the middle of the moment as they leave at times spread over it."""
    time = sample_1d(pixels, strata.step(_STEP)) - 0.5
    # Numbers of their own for every frame, which literals would compile anew.
    place, shift, turn = (
        mi.Vector3f(*(dr.opaque(mi.Float, float(x)) for x in values))
        for values in (sweep.place, sweep.shift, sweep.turn)
    )
    # Turns are small: of first order they are 0.2 pixels off at 1 degree a moment.
    lever = mi.Vector3f(ray.o) - place
    origin = ray.o + time * (shift + dr.cross(turn, lever))
    return mi.Ray3f(origin, dr.normalize(ray.d + time * dr.cross(turn, ray.d)))
