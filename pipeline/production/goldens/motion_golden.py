"""MotionGolden: how a take moved, small enough to be kept in version control."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from pipeline.production.goldens import motion_tolerance
from pipeline.production.goldens.motion_digest import facts_of, motion_digest
from pipeline.production.goldens.motion_fingerprints import Fingerprints
from pipeline.production.goldens.motion_marks import Mark, marks_of
from pipeline.production.goldens.motion_sampling import kept, stride_of
from pipeline.production.goldens.packed_series import Series
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Take

MOST_TEXT = 100_000
"""Characters of all series: where they are more, half as many rows are kept."""


@dataclass(frozen=True, slots=True)
class Land:
    """The ground in short.

    Attributes:
        cells: along x and z.
        material: by name.
        vertices: how many it has.
        forbidden: how many of its cells are.
    """

    cells: tuple[int, ...]
    material: str
    vertices: int
    forbidden: int


@dataclass(frozen=True, eq=False)
class MotionGolden:
    """How a take moved.

    Attributes:
        scene: its name.
        title: of the scene.
        facts: rate, frames, samples, steps and seed, which must be the same.
        versions: of what it was made with, as in the take's header.
        digest: of the motion, exact.
        nodes: their names.
        channels: name -> unit.
        stride: each how many rows poses are kept.
        series: name -> what `sampling.kept` keeps, rounded.
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
    land: Land
    predictable: int | None = None


def golden_of(take: Take, scene: str, predictable: int | None = None) -> MotionGolden:
    """Return the golden of a take of the scene called `scene`."""
    nodes = tuple(node.name for node in take.nodes)
    channels = {channel.name: channel.unit for channel in take.channels}
    stride = stride_of(take)
    series = _series(take, stride, nodes, channels)
    while stride < len(take.positions) and _length(series) > MOST_TEXT:
        # Particles that are born and wings that beat are hard to pack.
        stride *= 2
        series = _series(take, stride, nodes, channels)
    return MotionGolden(
        scene=scene,
        title=take.header.title,
        facts=facts_of(take.header),
        versions=dict(take.header.versions),
        digest=motion_digest(take),
        nodes=nodes,
        channels=channels,
        stride=stride,
        series=series,
        fingerprints=Fingerprints.of(take),
        marks=marks_of(take),
        land=land_of(take),
        predictable=predictable,
    )


def _series(
    take: Take, stride: int, nodes: tuple[str, ...], channels: dict[str, str]
) -> dict[str, Series]:
    return {
        name: Series.of(values, _quanta(name, values, channels))
        for name, values in kept(take, stride, nodes, list(channels)).items()
    }


def _length(series: dict[str, Series]) -> int:
    return sum(len(one.packed()["packed"]) for one in series.values())


def land_of(take: Take) -> Land:
    """Return the ground of a take in short."""
    ground = take.terrain
    forbidden = int(np.count_nonzero(ground.forbidden))
    return Land(tuple(ground.cells), ground.material, len(ground.vertices), forbidden)


def _bounds(channels: dict[str, str]) -> Array:
    return np.array([motion_tolerance.of_unit(unit) for unit in channels.values()])


def _quanta(name: str, values: Array, channels: dict[str, str]) -> Array:
    if name == "values":
        return motion_tolerance.CHANNEL_QUANTUM * _bounds(channels)
    return np.full(values.shape[1], motion_tolerance.QUANTA[name])
