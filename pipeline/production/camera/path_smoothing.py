"""Smooth paths: what shakes evened out over time, and what must not be undercut."""

from __future__ import annotations

import math

import numpy as np

from pipeline.simulation.spatial import Array


def smoothed(path: Array, sigma: float) -> Array:
    """Return `path` (F, d) under a gaussian of `sigma` frames, carried on beyond its ends.

    There it goes on along a line fitted to it, from which it departs as it did before, seen in
    a mirror: a straight, even path is left as it is, and one that bounces begins and ends
    no less calm than it goes.
    """
    if len(path) < 2:
        return path.copy()
    reach = _reach(sigma)
    padded = np.concatenate([_beyond(path, reach)[::-1], path, _beyond(path[::-1], reach)])
    kernel = _kernel(sigma)
    return np.stack([np.convolve(column, kernel, mode="valid") for column in padded.T], axis=-1)


def _beyond(path: Array, count: int) -> Array:
    """Return `count` places that come before `path` (F, d), the nearest first."""
    near = path[: count + 1]
    t = np.arange(len(near)) - 0.5 * (len(near) - 1)
    slope = (t[:, None] * near).sum(axis=0) / (t * t).sum()
    # A path that is shorter than the reach goes there and back again in the mirror.
    steps = np.arange(1, count + 1)
    mirrored = np.pad(np.arange(len(near)), (count, 0), mode="reflect")[:count][::-1]
    result: Array = near[mirrored] - (steps + mirrored)[:, None] * slope
    return result


def envelope(least: Array, sigma: float) -> Array:
    """Return a path (F,) that is nowhere below `least` (F,), as smooth as a gaussian of `sigma`.

    The highest within the reach of the gaussian comes first: every value that is averaged is
    then at least what is needed. Its second difference is at most 0.25 / sigma² of what it
    rises and falls in all (the steepest slope of a gaussian's density).
    """
    reach = _reach(sigma)
    padded = np.pad(least, 2 * reach, mode="edge")
    crest = np.lib.stride_tricks.sliding_window_view(padded, 2 * reach + 1).max(axis=-1)
    result: Array = np.convolve(crest, _kernel(sigma), mode="valid")
    # The weights add up to one but for rounding.
    return np.maximum(result, least)


def _reach(sigma: float) -> int:
    return max(1, math.ceil(3.0 * sigma))


def _kernel(sigma: float) -> Array:
    reach = _reach(sigma)
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma) ** 2)
    result: Array = kernel / kernel.sum()
    return result
