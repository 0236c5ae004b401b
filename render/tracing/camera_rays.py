"""Camera rays: from the lens through the pixels, also of a camera that moves on meanwhile.

Between the moments of an exposure, whatever moves jumps. That is too coarse for what passes close
to a camera that travels: blades of grass before the lens would be drawn as rows of dots. So rays
to what stands still leave from where the camera is at times spread over the moment. Rays to what
moves leave from its place at the moment itself, for they meet it as it is then.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi

from render.camera_sweep import CameraSweep
from render.tracing.stratification import (
    BSDF_PAIR,
    EMITTER_PAIR,
    PassStrata,
    StepStrata,
    sample_1d,
    sample_2d,
)

FEW = 16
"""Number of passes up to which rays go through the same places of all pixels."""

_STEP = 1 << 10
"""Step of the strata for the time of a ray: no path is so long."""


@dataclass(frozen=True)
class CameraView:
    """The camera at one moment of an exposure.

    Attributes:
        sensor: of Mitsuba, in the middle of the moment.
        sweep: its motion over the moment, None where it stands still.
    """

    sensor: Any
    sweep: CameraSweep | None = None

    def rays(
        self, pixels: Any, size: tuple[int, int], strata: PassStrata, has_still: bool
    ) -> tuple[Any, Any]:
        """Return a ray through every pixel to what stands still, and one to what moves.

        Args:
            pixels: numbers of the pixels, row by row.
            size: width and height of the image [pixels].
            strata: of the pass.
            has_still: whether the scene tells the two apart.

        Returns:
            The second is None where both are the same.
        """
        ray = camera_ray(self.sensor, pixels, size, strata.step(0))
        if self.sweep is None or not has_still:
            return ray, None
        return _swept(self.sweep, ray, pixels, strata), ray


def camera_ray(sensor: Any, pixels: Any, size: tuple[int, int], strata: StepStrata) -> Any:
    """Return a ray through every pixel. Not recorded: some lenses cannot be."""
    column, row = pixels % size[0], pixels // size[0]
    if strata.grid[0] * strata.grid[1] <= FEW:
        place = even_place(column, row, strata)
    else:
        place = sample_2d(pixels, strata, EMITTER_PAIR)
    lens = sample_2d(pixels, strata, BSDF_PAIR)
    film = mi.Point2f((mi.Float(column) + place.x) / size[0], (mi.Float(row) + place.y) / size[1])
    ray, _ = sensor.sample_ray(0.0, 0.5, film, lens)
    return mi.Ray3f(ray.o, ray.d)


def even_place(column: Any, row: Any, strata: StepStrata) -> Any:
    """Return the place in a pixel of a pass among few, on a Hammersley set.

    All pixels have the same places, so that an edge is an even staircase and stands still from
    frame to frame, where few random places make it a row of beads. In every other pixel the set
    is mirrored, for edges of either slope.
    """
    count, bits = strata.grid[0] * strata.grid[1], 0
    k: Any = strata.k
    y: Any = mi.Float(0.0)
    while 2**bits < count:
        bits += 1
        y += mi.Float((k >> (bits - 1)) & 1) / 2**bits
    x = (mi.Float(k) + 0.5) / count
    y += 0.5 / 2**bits
    return mi.Point2f(x, dr.select(((column + row) & 1) == 0, y, 1.0 - y))


def central_ray(sensor: Any, pixels: Any, size: tuple[int, int]) -> Any:
    """Return a ray through the middle of every pixel and of the lens."""
    column, row = pixels % size[0], pixels // size[0]
    film = mi.Point2f((mi.Float(column) + 0.5) / size[0], (mi.Float(row) + 0.5) / size[1])
    ray, _ = sensor.sample_ray(0.0, 0.5, film, mi.Point2f(0.5, 0.5))
    return mi.Ray3f(ray.o, ray.d)


def _swept(sweep: CameraSweep, ray: Any, pixels: Any, strata: PassStrata) -> Any:
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
