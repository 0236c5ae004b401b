"""Motion golden: the motion of a take, small enough for version control."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.production.goldens import motion_tolerance
from pipeline.production.goldens.motion_digest import (
    Fingerprints,
    header_facts,
    motion_digest,
)
from pipeline.production.goldens.motion_marks import Mark, marks_of
from pipeline.production.goldens.packed_series import Series
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Take

MAX_NUMBERS = 125_000
"""Numbers of a golden, about 60 kB of text; longer scenes keep every second, third, ... row."""

GROUND_POINTS = 400
"""Vertices of the ground that are kept, about."""


def stride_of(take: Take) -> int:
    """Return the stride of the rows of `take` that are kept."""
    rows, nodes, channels = len(take.positions), len(take.nodes), len(take.channels)
    numbers = rows * (7 * nodes + channels / take.header.samples)
    return max(1, math.ceil(numbers / MAX_NUMBERS))


def sampled_rows(rows: int, stride: int) -> NDArray[np.int64]:
    """Return the numbers of every `stride`-th of `rows` rows, and of the last."""
    picked = np.arange(0, rows, max(stride, 1), dtype=np.int64)
    return np.union1d(picked, [rows - 1]).astype(np.int64) if rows else picked


def channel_stride(stride: int, samples: int) -> int:
    """Return the stride of channels, which are compared only at frames."""
    return stride * samples


def sampled(
    take: Take, stride: int, nodes: Sequence[str], channels: Sequence[str]
) -> dict[str, Array]:
    """Return the arrays of a take at the kept rows, (rows, numbers) each, unrounded.

    Args:
        take: any take.
        stride: of the rows of poses.
        nodes: names of its nodes, in order.
        channels: names of its channels, in order.
    """
    j = _indices(nodes, [node.name for node in take.nodes])
    c = _indices(channels, [channel.name for channel in take.channels])
    rows = sampled_rows(len(take.positions), stride)
    frames = sampled_rows(len(take.values), channel_stride(stride, take.header.samples))
    ground = take.terrain.vertices
    points = sampled_rows(len(ground), math.ceil(len(ground) / GROUND_POINTS))
    return {
        "positions": _flat(take.positions[rows][:, j]),
        "rotations": _flat(take.rotations[rows][:, j]),
        "alive": _flat(take.alive[rows][:, j]),
        "scales": _flat(_scales(take)[rows][:, j]),
        "values": _flat(take.values[frames][:, c]),
        "terrain": _flat(ground[points]),
    }


def _indices(wanted: Sequence[str], names: Sequence[str]) -> NDArray[np.int64]:
    place = {name: k for k, name in enumerate(names)}
    return np.array([place[name] for name in wanted], dtype=np.int64)


def _scales(take: Take) -> Array:
    """Return the scales (K, J, 3) of all nodes, by default 1."""
    scales = np.ones_like(take.positions)
    scales[:, list(take.scaled)] = take.scales
    return scales


def _flat(values: NDArray[Any]) -> Array:
    return values.reshape(len(values), math.prod(values.shape[1:])).astype(np.float64)


MAX_TEXT = 100_000
"""Characters of all series; above, the number of rows is halved."""


@dataclass(frozen=True, slots=True)
class GroundSummary:
    """Summary of the ground.

    Attributes:
        cells: along x and z.
        material: by name.
        vertices: number of vertices.
        forbidden: number of forbidden cells.
    """

    cells: tuple[int, ...]
    material: str
    vertices: int
    forbidden: int


@dataclass(frozen=True, eq=False)
class MotionGolden:
    """The motion of a take.

    Attributes:
        scene: its name.
        title: of the scene.
        facts: rate, frames, samples, steps and seed, which comparable takes share.
        versions: as in the take's header.
        digest: of the motion, exact.
        nodes: their names.
        channels: name -> unit.
        stride: of the rows of poses.
        series: name -> rounded arrays of `sampled`.
        fingerprints: of the exact bits.
        marks: contacts, sound events and notes.
        land: the ground.
        predictable: step up to which poses agree on every class of processor; None for the whole
            film, which holds unless the motion is chaotic.
    """

    scene: str
    title: str
    facts: dict[str, Any]
    versions: dict[str, str]
    digest: str
    nodes: tuple[str, ...]
    channels: dict[str, str]
    stride: int
    series: dict[str, Series]
    fingerprints: Fingerprints
    marks: tuple[Mark, ...]
    land: GroundSummary
    predictable: int | None = None


def golden_of(take: Take, scene: str, predictable: int | None = None) -> MotionGolden:
    """Return the golden of a take of the scene called `scene`."""
    nodes = tuple(node.name for node in take.nodes)
    channels = {channel.name: channel.unit for channel in take.channels}
    stride = stride_of(take)
    series = _series(take, stride, nodes, channels)
    while stride < len(take.positions) and _text_length(series) > MAX_TEXT:
        # Particles and wing beats are hard to pack.
        stride *= 2
        series = _series(take, stride, nodes, channels)
    return MotionGolden(
        scene=scene,
        title=take.header.title,
        facts=header_facts(take.header),
        versions=dict(take.header.versions),
        digest=motion_digest(take),
        nodes=nodes,
        channels=channels,
        stride=stride,
        series=series,
        fingerprints=Fingerprints.of(take),
        marks=marks_of(take),
        land=ground_summary(take),
        predictable=predictable,
    )


def _series(
    take: Take, stride: int, nodes: tuple[str, ...], channels: dict[str, str]
) -> dict[str, Series]:
    return {
        name: Series.of(values, _quanta(name, values, channels))
        for name, values in sampled(take, stride, nodes, list(channels)).items()
    }


def _text_length(series: dict[str, Series]) -> int:
    return sum(len(one.packed()["packed"]) for one in series.values())


def ground_summary(take: Take) -> GroundSummary:
    """Return the summary of a take's ground."""
    ground = take.terrain
    forbidden = int(np.count_nonzero(ground.forbidden))
    return GroundSummary(tuple(ground.cells), ground.material, len(ground.vertices), forbidden)


def _quanta(name: str, values: Array, channels: dict[str, str]) -> Array:
    if name == "values":
        bounds = [motion_tolerance.channel_tolerance(unit) for unit in channels.values()]
        return motion_tolerance.CHANNEL_QUANTUM * np.array(bounds)
    return np.full(values.shape[1], motion_tolerance.QUANTA[name])
