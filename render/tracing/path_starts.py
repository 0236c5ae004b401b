"""Path starts: where paths of indirect light leave the surfaces that the camera sees.

Samples of direct light have found these surfaces already. One sample of each pixel of indirect
light hands its hit on, so that no ray is traced twice: at full size one of the samples for each
path, and at half the size one of the four pixels that it covers, in turn.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from render.tracing.tracer import PixelLanes


@dataclass
class PathStarts:
    """First segments of all paths of a pass, in the order in which they are traced.

    Attributes:
        origin: of the camera rays [m].
        direction: of the camera rays, unit vectors.
        hit: what they meet.
    """

    origin: mi.Point3f
    direction: mi.Vector3f
    hit: mi.PreliminaryIntersection3f

    @staticmethod
    def of(count: int) -> PathStarts:
        """Return starts of so many paths, to be written to."""
        starts = PathStarts(
            dr.zeros(mi.Point3f, count),
            dr.zeros(mi.Vector3f, count),
            dr.zeros(mi.PreliminaryIntersection3f, count),
        )
        dr.make_opaque(starts)
        return starts

    def write(self, origin: Any, way: Any, hit: Any, lanes: Any, active: Any) -> None:
        """Let paths start with these rays; no two of them the same path.

        Args:
            origin: of rays from the camera [m].
            way: of the rays, unit vectors.
            hit: what they meet.
            lanes: of the paths.
            active: which rays start one.
        """
        dr.scatter(self.origin, origin, lanes, active)
        dr.scatter(self.direction, way, lanes, active)
        dr.scatter(self.hit, hit, lanes, active)
        dr.eval(self)

    def read(self, lanes: Any) -> tuple[Any, Any]:
        """Return the rays and hits of paths."""
        origin = dr.gather(mi.Point3f, self.origin, lanes)
        direction = dr.gather(mi.Vector3f, self.direction, lanes)
        return mi.Ray3f(origin, direction), dr.gather(mi.PreliminaryIntersection3f, self.hit, lanes)


@dataclass(frozen=True)
class StartLanes:
    """Which samples of direct light start which paths.

    Attributes:
        width: of the frame [pixels].
        is_half: whether indirect light has half the size.
        chunks: path of each pixel of direct light, chunk by chunk, `mi.UInt32` each.
    """

    width: int
    is_half: bool
    chunks: tuple[Any, ...]

    @staticmethod
    def of(direct: PixelLanes, indirect: PixelLanes) -> StartLanes:
        """Return the lanes for pixels of direct and of indirect light."""
        width, height = direct.size
        is_half = indirect.size != direct.size
        lanes = indirect.lanes().reshape(indirect.size[1], indirect.size[0])
        if is_half:
            lanes = lanes.repeat(2, axis=0)[:height].repeat(2, axis=1)[:, :width]
        found = np.ascontiguousarray(lanes).ravel()
        chunks = tuple(mi.UInt32(found[np.array(pixels)]) for pixels in direct.chunks)
        return StartLanes(width, is_half, chunks)

    def of_pass(self, chunk: int, pixels: Any, k: int, samples: int) -> tuple[Any, Any]:
        """Return the path of each pixel of a chunk, and whether the pass starts it.

        Args:
            chunk: number of the chunk.
            pixels: of the chunk.
            k: number of the pass of direct light.
            samples: of direct light for each path.
        """
        # In turn, because places in the pixel go by the low bits of the number of the pass.
        is_start = k % samples == (k // samples) % samples
        if not self.is_half:
            return self.chunks[chunk], dr.opaque(mi.Bool, is_start)
        # One after the other of the four pixels, first those on a diagonal; the diagonals of
        # neighbours cross, so that no direction is preferred.
        turn = k // samples
        x, y = pixels % self.width, pixels // self.width
        across = dr.opaque(mi.UInt32, (turn ^ turn >> 1) & 1)
        down = dr.opaque(mi.UInt32, turn & 1)
        flip = ((x >> 1) + (y >> 1)) & 1
        is_chosen = ((x & 1) == (across ^ flip)) & ((y & 1) == down)
        return self.chunks[chunk], is_chosen & dr.opaque(mi.Bool, is_start)
