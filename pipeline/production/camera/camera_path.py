"""Camera path: eye, target, up and field of view of a camera at every frame; smoothing of paths."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from pipeline.simulation.spatial import Array, normalized
from render.shot import CameraPose, Lens


@dataclass(frozen=True, eq=False)
class CameraPath:
    """Eye, target, up and field of view of a camera at F frames.

    Attributes:
        eye: (F, 3) [m].
        target: (F, 3) [m].
        up: (F, 3) direction that is up in the frame.
        fov_deg: (F,) vertical field of view [degrees].
    """

    eye: Array
    target: Array
    up: Array
    fov_deg: Array

    @property
    def tangent(self) -> Array:
        """Half the height of the frame (F,) at a distance of 1."""
        return np.tan(np.radians(self.fov_deg) / 2.0)

    @property
    def axes(self) -> tuple[Array, Array, Array]:
        """Unit vectors ahead, to the right and up in the frame, each (F, 3)."""
        ahead = normalized(self.target - self.eye)
        right = normalized(np.cross(ahead, self.up))
        return ahead, right, np.cross(right, ahead)

    def smoothed(self, smooth: Callable[[Array], Array]) -> CameraPath:
        """Return the path with eye, target and up smoothed by `smooth`, (F, 3) -> (F, 3)."""
        return CameraPath(smooth(self.eye), smooth(self.target), smooth(self.up), self.fov_deg)

    def raised(self, lift: Array, *, with_target: bool = False) -> CameraPath:
        """Return the path with its eye, and optionally its target, `lift` (F,) higher [m]."""
        rise = np.zeros_like(self.eye)
        rise[:, 1] = lift
        return replace(self, eye=self.eye + rise, target=self.target + rise * with_target)

    def poses(self, lenses: tuple[Lens | None, ...]) -> list[CameraPose]:
        """Return the pose of every frame with its lens."""
        return [
            CameraPose(_rounded(e), _rounded(t), _rounded(u), float(fov), lens)
            for e, t, u, fov, lens in zip(
                self.eye, self.target, self.up, self.fov_deg.tolist(), lenses, strict=True
            )
        ]


def _rounded(v: Array) -> tuple[float, float, float]:
    # To a micrometre, so that the last bits of a processor's arithmetic re-render no frame.
    x, y, z = (round(float(c), 6) + 0.0 for c in v)
    return x, y, z


def smoothed(path: Array, sigma: float) -> Array:
    """Return `path` (F, d) filtered by a gaussian of `sigma` frames.

    Beyond its ends it is extended along a fitted line, with its deviations from the line
    mirrored: an even, straight path is unchanged, and a bouncing one is as smooth at its ends.
    """
    if len(path) < 2:
        return path.copy()
    reach = _reach(sigma)
    padded = np.concatenate([_extension(path, reach)[::-1], path, _extension(path[::-1], reach)])
    kernel = _kernel(sigma)
    return np.stack([np.convolve(column, kernel, mode="valid") for column in padded.T], axis=-1)


def _extension(path: Array, count: int) -> Array:
    """Return `count` points before `path` (F, d), the nearest first."""
    near = path[: count + 1]
    t = np.arange(len(near)) - 0.5 * (len(near) - 1)
    slope = (t[:, None] * near).sum(axis=0) / (t * t).sum()
    # A path shorter than the reach is reflected repeatedly.
    steps = np.arange(1, count + 1)
    mirrored = np.pad(np.arange(len(near)), (count, 0), mode="reflect")[:count][::-1]
    return near[mirrored] - (steps + mirrored)[:, None] * slope


def envelope(least: Array, sigma: float) -> Array:
    """Return a path (F,) that is nowhere below `least` (F,), as smooth as a gaussian of `sigma`.

    The maximum over the reach of the gaussian is filtered, so that every averaged value is at
    least the lower bound. The second difference is at most 0.25 / sigma² of the total variation
    (the steepest slope of a gaussian's density).
    """
    reach = _reach(sigma)
    padded = np.pad(least, 2 * reach, mode="edge")
    crest = np.lib.stride_tricks.sliding_window_view(padded, 2 * reach + 1).max(axis=-1)
    result: Array = np.convolve(crest, _kernel(sigma), mode="valid")
    # The weights sum to 1 up to rounding.
    return np.maximum(result, least)


def _reach(sigma: float) -> int:
    return max(1, math.ceil(3.0 * sigma))


def _kernel(sigma: float) -> Array:
    reach = _reach(sigma)
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma) ** 2)
    return kernel / kernel.sum()
