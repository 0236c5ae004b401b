"""Sampling: which of a take's numbers a golden keeps."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Take

NUMBERS = 125_000
"""A golden keeps every row while that makes no more numbers than these, about 60 kB of
text; of a longer or fuller scene it keeps every second, third, ... row."""

GROUND_POINTS = 400
"""Of the ground about so many vertices are kept."""


def stride_of(take: Take) -> int:
    """Return n for which every n-th row of `take` is few enough numbers to keep."""
    rows, nodes, channels = len(take.positions), len(take.nodes), len(take.channels)
    numbers = rows * (7 * nodes + channels / take.header.samples)
    return max(1, math.ceil(numbers / NUMBERS))


def kept_rows(rows: int, stride: int) -> NDArray[np.int64]:
    """Return the numbers of each `stride`-th of `rows` rows, and of the last."""
    picked = np.arange(0, rows, max(stride, 1), dtype=np.int64)
    return np.union1d(picked, [rows - 1]).astype(np.int64) if rows else picked


def channel_stride(stride: int, samples: int) -> int:
    """Return each how many rows channels are kept: they are not seen between frames."""
    return stride * samples


def kept(
    take: Take, stride: int, nodes: Sequence[str], channels: Sequence[str]
) -> dict[str, Array]:
    """Return what a golden keeps of a take's arrays, (rows, numbers) each, unrounded.

    Args:
        take: any take.
        stride: each how many rows poses are kept.
        nodes: names of its nodes, in the order wanted.
        channels: likewise of its channels.
    """
    j = _places(nodes, [node.name for node in take.nodes])
    c = _places(channels, [channel.name for channel in take.channels])
    rows = kept_rows(len(take.positions), stride)
    frames = kept_rows(len(take.values), channel_stride(stride, take.header.samples))
    ground = take.terrain.vertices
    points = kept_rows(len(ground), math.ceil(len(ground) / GROUND_POINTS))
    return {
        "positions": _flat(take.positions[rows][:, j]),
        "rotations": _flat(take.rotations[rows][:, j]),
        "alive": _flat(take.alive[rows][:, j]),
        "scales": _flat(_scales(take)[rows][:, j]),
        "values": _flat(take.values[frames][:, c]),
        "terrain": _flat(ground[points]),
    }


def _places(wanted: Sequence[str], names: Sequence[str]) -> NDArray[np.int64]:
    place = {name: k for k, name in enumerate(names)}
    return np.array([place[name] for name in wanted], dtype=np.int64)


def _scales(take: Take) -> Array:
    """Return the scales (K, J, 3) of all nodes, 1 where a node has none."""
    scales = np.ones_like(take.positions)
    scales[:, list(take.scaled)] = take.scales
    return scales


def _flat(values: NDArray[Any]) -> Array:
    return values.reshape(len(values), math.prod(values.shape[1:])).astype(np.float64)
