"""Smooth paths: what shakes evened out over time, and what must not be undercut."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array


def smoothed(path: Array, sigma: float) -> Array:
    """Return `path` (F, d) under a gaussian of `sigma` frames, carried on straight at its ends."""
    reach = _reach(sigma)
    # Point reflection at both ends keeps position and speed.
    padded = (
        np.pad(path, ((reach, reach), (0, 0)), mode="reflect", reflect_type="odd")
        if len(path) > 1
        else np.repeat(path, 2 * reach + 1, axis=0)
    )
    return _evened(padded, sigma)


def envelope(least: Array, sigma: float) -> Array:
    """Return a path (F,) that is nowhere below `least` (F,), as smooth as a gaussian of `sigma`.

    The highest within the reach of the gaussian comes first: every value that is averaged is
    then at least what is needed. Its second difference is at most 0.25 / sigma² of what it
    rises and falls in all (the steepest slope of a gaussian's density).
    """
    reach = _reach(sigma)
    padded = np.pad(least, 2 * reach, mode="edge")
    crest = np.lib.stride_tricks.sliding_window_view(padded, 2 * reach + 1).max(axis=-1)
    result: Array = _evened(crest[:, None], sigma)[:, 0]
    # The weights add up to one but for rounding.
    return np.maximum(result, least)


def _reach(sigma: float) -> int:
    return max(1, math.ceil(3.0 * sigma))


def _evened(padded: NDArray[np.float64], sigma: float) -> Array:
    reach = _reach(sigma)
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma) ** 2)
    kernel /= kernel.sum()
    return np.stack([np.convolve(column, kernel, mode="valid") for column in padded.T], axis=-1)
