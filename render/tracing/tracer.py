"""Tracer interface: what turns a Mitsuba scene into light, pass by pass.

An accumulator adds up the light of several moments while the shutter is open, and images are
made once, when it closes: a frame's images are large, and four of each moment beside four of
their sum would be most of a frame's memory.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from render.frame import Image, LightLayers
from render.tracing.camera_rays import CameraView

MAX_PATHS = 1 << 17
"""Paths in flight at once, which bounds the memory."""

SQUARE = 4
"""Side of the squares of pixels whose paths are adjacent in memory."""

Sums = tuple[Any, ...]
"""Sums over all passes, lane by lane, `mi.Color3f` each: light, albedo, and more of some."""


class Accumulator(ABC):
    """The sums of one frame.

    Attributes:
        distances: of the surfaces [m], infinite where there is none: pixel by pixel and sample by
            sample of direct light, `mi.Float` each; empty where they are not kept.
    """

    distances: tuple[Any, ...] = ()

    @abstractmethod
    def add_passes(self, view: CameraView, seed: int, passes: range, total: int) -> None:
        """Add what the camera sees now; see `FullFilm.rays`.

        Args:
            view: the camera; only tracers that tell what stands still from what moves follow its
                sweep.
            seed: of all passes.
            passes: numbers of those to trace now, at one moment of the exposure.
            total: passes of the frame, over which the samples are stratified.
        """

    @abstractmethod
    def layers(self) -> LightLayers:
        """Return the mean of all passes; the accumulator is used up."""


class Tracer(ABC):
    """Traces one Mitsuba scene."""

    @abstractmethod
    def accumulator(self, kept_distances: int = 0) -> Accumulator:
        """Return an empty accumulator.

        Args:
            kept_distances: number of samples of direct light in a pixel of frames for which a
                tracer may keep their distances.
        """

    @abstractmethod
    def scene_changed(self) -> None:
        """Take note that the scene was changed in place."""

    def trace(self, sensor: Any, seed: int, passes: range, total: int) -> LightLayers:
        """Return what the sensor sees of a still scene; see `Accumulator.add_passes`."""
        accumulator = self.accumulator()
        accumulator.add_passes(CameraView(sensor), seed, passes, total)
        return accumulator.layers()


class PixelLanes:
    """The pixels of an image in the order in which they are traced, in chunks.

    Args:
        size: width and height [pixels].

    Attributes:
        size: the same.
        count: of pixels.
        chunks: numbers of pixels, row by row, `mi.UInt32` each.
    """

    def __init__(self, size: tuple[int, int]) -> None:
        self.size, self.count = size, size[0] * size[1]
        self.chunks = in_chunks(_square_order(*size))

    def first_lane(self, chunk: int) -> int:
        """Return how many pixels are traced before those of a chunk."""
        return sum(dr.width(pixels) for pixels in self.chunks[:chunk])

    def lanes(self) -> NDArray[np.uint32]:
        """Return the place in the order of tracing of each pixel, row by row."""
        order = _square_order(*self.size)
        found = np.empty_like(order)
        found[order] = np.arange(len(order), dtype=np.uint32)
        return found

    def zero_sums(self, kinds: int) -> list[Sums]:
        """Return sums of zero for each chunk, of so many kinds."""
        return [
            tuple(dr.opaque(mi.Color3f, 0.0, len(p)) for _ in range(kinds)) for p in self.chunks
        ]

    def means(self, sums: list[Sums], count: int) -> list[Image]:
        """Return the mean of each kind, (H, W, 3), of sums of `count` samples, used up."""
        kinds = [list(column) for column in zip(*sums, strict=True)]
        sums.clear()
        return [self._mean(kind, count) for kind in kinds]

    def _mean(self, sums: list[Any], count: int) -> Image:
        width, height = self.size
        values = dr.empty(mi.Float, 3 * width * height)
        for pixels in self.chunks:
            dr.scatter(values, sums.pop(0) / dr.opaque(mi.Float, count), pixels)
        return np.asarray(values).reshape(height, width, 3)


def pixels_of(area: NDArray[np.bool_]) -> NDArray[np.uint32]:
    """Return the pixels of an area (H, W) in the order in which they are traced."""
    order = _square_order(area.shape[1], area.shape[0])
    return order if area.all() else order[area.ravel()[order]]


def in_chunks(pixels: NDArray[np.uint32]) -> list[Any]:
    """Return pixels in chunks that are traced at once, `mi.UInt32` each.

    All but the last are full: Dr.Jit splits them into blocks of 2^14 for its threads, of which
    equal chunks would leave a rest for one thread to do while the others wait.
    """
    starts = range(0, max(len(pixels), 1), MAX_PATHS)
    return [mi.UInt32(pixels[start : start + MAX_PATHS]) for start in starts]


def _square_order(width: int, height: int) -> NDArray[np.uint32]:
    """Return the pixels, square after square."""
    y, x = np.mgrid[0:height, 0:width]
    across = -(-width // SQUARE)
    place = ((y // SQUARE) * across + x // SQUARE) * SQUARE**2 + (y % SQUARE) * SQUARE + x % SQUARE
    return np.argsort(place.ravel(), kind="stable").astype(np.uint32)
