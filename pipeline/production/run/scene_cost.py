"""Scene cost: what checking, simulating and rendering a scene takes, before anything is built.

A scene's cost is a sum over its parts, each with its place in the scene, so that a refusal can
name the line that costs most. The constants were measured with `benchmarks/budgets.py`, which
prints estimates beside what runs took.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Literal

from pipeline.foreign_files.safe_file import HEIGHT_MAP, ForeignFileError, opened_file
from pipeline.spec import Scene
from pipeline.spec.body import Many
from pipeline.spec.cast import Member
from pipeline.spec.character import Character
from pipeline.spec.creature import Creature
from pipeline.spec.dancer import Dancer
from pipeline.spec.group import Group
from pipeline.spec.prop import Prop
from pipeline.spec.terrain.base import GridTerrain, TerrainConfig
from pipeline.spec.terrain.kinds import ImageTerrain, MeshTerrain, SumTerrain

MIB = 2**20

Work = Literal["check", "simulate", "score", "render"]
"""What is done: `check` builds the world, `simulate` also moves it, `score` also follows it with
the camera, `render` also shows it."""

ORDER: tuple[Work, ...] = ("check", "simulate", "score", "render")


@dataclass(frozen=True, slots=True)
class Rate:
    """What one thing of a part takes.

    Attributes:
        memory: at the peak, by kind of work in the order of `ORDER` [bytes].
        build: processor time to build it, likewise [s].
        frame: processor time in each frame of the simulation, and of the picture [s].
    """

    memory: tuple[float, float, float, float]
    build: tuple[float, float, float, float]
    frame: tuple[float, float] = (0.0, 0.0)


START = Rate((145 * MIB, 170 * MIB, 180 * MIB, 430 * MIB), (2.6, 2.9, 3.2, 11.0), (0.0015, 0.05))
"""A scene without anything: the libraries, and the kernels of the renderer."""

COMPILED = Rate((105 * MIB,) * 4, (0.8,) * 4)
"""The compiled code that scenes with bodies and people load."""

CELL = Rate((85.0, 145.0, 155.0, 400.0), (5e-7, 1e-6, 1.1e-6, 5e-6))
"""A cell of the ground."""

LINK = Rate((18e3, 74e3, 74e3, 131e3), (1.8e-4, 1.2e-3, 1.2e-3, 1.5e-3), (2.5e-5, 2.5e-4))
"""A node of the drawing of a creature."""

BODY = Rate((30e3, 125e3, 125e3, 160e3), (1e-3, 1.1e-3, 1.2e-3, 1.5e-3), (4e-4, 2e-5))
"""A rigid body or a prop."""

SMALL_BODY = Rate((2e3, 2e4, 2e4, 4e4), (2e-5, 5e-5, 6e-5, 1e-4), (3.5e-5, 1e-5))
"""A member of a group."""

PERSON = Rate((2 * MIB, 4 * MIB, 4 * MIB, 12 * MIB), (0.05, 0.06, 0.07, 0.15), (8e-4, 2e-3))
"""A person or another character."""

DANCER = Rate((5 * MIB, 7 * MIB, 7 * MIB, 14 * MIB), (0.35, 0.4, 0.4, 0.45), (2e-3, 2e-3))
"""A dancer."""

SOUND = Rate((0.0, 0.0, 3.7 * MIB, 3.7 * MIB), (0.0, 0.0, 0.02, 0.02))
"""A second of sound."""

PIXEL_MEMORY = 430.0
"""Memory of a pixel of the picture, with what its rays need [bytes]."""

PIXEL_FRAME, RAY = 2.2e-6, 5.5e-7
"""Processor time of a pixel in a frame, and of each of its camera rays [s]."""


@cache
def usable_processors() -> int:
    """Return the number of processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@dataclass(frozen=True, slots=True)
class Job:
    """The work to be done on a scene.

    Attributes:
        work: the last thing that is done.
        frames: number of frames that are rendered.
        processes: number of processes that render.
        is_simulated: whether there is a take already.
        sound: whether sound is written.
        processors: number of processors that the work may use.
    """

    work: Work
    frames: int = 0
    processes: int = 1
    is_simulated: bool = False
    sound: bool = True
    processors: int = field(default_factory=lambda: usable_processors())


@dataclass(frozen=True, slots=True)
class PartCost:
    """What one part of a scene takes.

    Attributes:
        path: of the part in the scene.
        text: what it is, such as "5,000 bodies".
        memory: at the peak [bytes].
        seconds: on this machine while nothing else keeps it busy.
        count: number of its things, 0 where it cannot be made smaller.
        unit: of the things.
    """

    path: str
    text: str
    memory: float
    seconds: float
    count: int = 0
    unit: str = ""


@dataclass(frozen=True, slots=True)
class SceneCost:
    """What a scene takes.

    Attributes:
        parts: of which it is the sum.
    """

    parts: tuple[PartCost, ...]

    @property
    def memory(self) -> float:
        """Memory at the peak [bytes]."""
        return sum(part.memory for part in self.parts)

    @property
    def seconds(self) -> float:
        """Time on this machine while nothing else keeps it busy [s]."""
        return sum(part.seconds for part in self.parts)


def scene_cost(scene: Scene, job: Job) -> SceneCost:
    """Return what a job on a scene takes, estimated from its keys and the heads of its files."""
    parts = [*_parts(scene, job)]
    if job.sound and job.work in ("score", "render"):
        parts.append(_sound(scene, job, parts))
    return SceneCost(tuple(parts))


def _parts(scene: Scene, job: Job) -> Iterator[PartCost]:
    frames = 0 if job.is_simulated or job.work == "check" else scene.n_frames
    start = _part(_length_key(scene), f"{frames:,} frames", START, 1, job, frames)
    yield _with_count(start, frames, "frames" if frames else "")
    if any(map(_is_compiled, scene.cast)):
        yield _part("cast", "compiled code", COMPILED, 1, job, frames)
    yield _ground(scene, job, frames)
    yield from _members(scene, job, frames)
    if job.work == "render":
        yield from _pictures(scene, job)


def _is_compiled(member: Member) -> bool:
    """Return whether a member is simulated by compiled code."""
    if isinstance(member, Prop):
        return member.may_fall
    return not isinstance(member, Creature | Dancer | Group)


def _members(scene: Scene, job: Job, frames: int) -> Iterator[PartCost]:
    """Yield the costs of members that are many, and of all single ones of each kind together."""
    nodes = cache(lambda name: len(scene.figures[name].sheet().marks))
    single: dict[str, tuple[int, int, int, Rate]] = {}
    for i, member in enumerate(scene.cast):
        rate, count, unit = _rate_of(member)
        if isinstance(member, Many | Group):
            path = f"cast[{i}].{'many' if isinstance(member, Many) else 'group'}"
            part = _part(path, f"{count:,} {unit}", rate, count, job, frames)
            yield _with_count(part, count, unit)
            continue
        first, number, things, _ = single.get(unit, (i, 0, 0, rate))
        more = nodes(member.figure) if isinstance(member, Creature) else 1
        single[unit] = first, number + 1, things + more, rate
    for unit, (first, number, things, rate) in single.items():
        part = _part(f"cast[{first}]", f"{number:,} {unit}", rate, things, job, frames)
        yield _with_count(part, number, unit)


def _part(path: str, text: str, rate: Rate, things: int, job: Job, frames: int) -> PartCost:
    """Return the cost of some things that cost the same."""
    k = ORDER.index(job.work)
    memory = rate.memory[k]
    if job.work == "render" and job.processes > 1:
        # Each process has a scene and a renderer of its own.
        memory += job.processes * memory
    pictures = job.frames * rate.frame[1] if job.work == "render" else 0.0
    builds = job.processes if job.work == "render" else 1
    parallel = rate.build[k] * builds + pictures
    seconds = frames * rate.frame[0] + parallel / min(builds, job.processors)
    return PartCost(path, text, things * memory, things * seconds)


def _with_count(part: PartCost, count: int, unit: str) -> PartCost:
    return PartCost(part.path, part.text, part.memory, part.seconds, count, unit)


def _ground(scene: Scene, job: Job, frames: int) -> PartCost:
    columns, rows = terrain_cells(scene.terrain)
    terms = len(scene.terrain.of) if isinstance(scene.terrain, SumTerrain) else 1
    part = _part("terrain", f"{columns:,} x {rows:,} cells", CELL, columns * rows, job, frames)
    extra = 0.5 * (terms - 1)
    key = "cells" if isinstance(scene.terrain, GridTerrain) else "file"
    path = f"terrain.{key}"
    return PartCost(
        path, part.text, part.memory, part.seconds * (1.0 + extra), columns * rows, "cells"
    )


def _sound(scene: Scene, job: Job, parts: Sequence[PartCost]) -> PartCost:
    """Return what the sound of a scene takes besides its other parts.

    Sound is written before the frames are rendered and its memory is free again then, so of both
    peaks the higher one counts.
    """
    seconds = round(scene.n_frames / scene.rate)
    k = ORDER.index(job.work)
    memory = SOUND.memory[k] * seconds
    if job.work == "render":
        before = sum(part.memory for part in _parts(scene, replace(job, work="score")))
        memory = max(before + memory - sum(part.memory for part in parts), 0.0)
    text = f"{seconds:,} s of sound"
    key = _length_key(scene)
    return PartCost(key, text, memory, SOUND.build[k] * seconds, seconds, "s of sound")


def _rate_of(member: Member) -> tuple[Rate, int, str]:
    """Return what each thing of a member costs, how many it has, and what they are."""
    if isinstance(member, Creature):
        return LINK, 1, "creatures"
    if isinstance(member, Many):
        return BODY, member.many.total, "bodies"
    if isinstance(member, Group):
        return SMALL_BODY, member.group.count, "members"
    if isinstance(member, Dancer):
        return DANCER, 1, "dancers"
    if isinstance(member, Character):
        return PERSON, 1, "characters"
    return BODY, 1, "bodies"


def _pictures(scene: Scene, job: Job) -> Iterator[PartCost]:
    film = scene.film.resolved()
    width, height = film.size
    pixels = width * height
    each = pixels * (PIXEL_FRAME + RAY * film.samples) / job.processors
    text = f"{job.frames:,} frames of {width}x{height} with {film.samples} samples"
    yield PartCost(_length_key(scene), text, 0.0, job.frames * each, job.frames, "frames")
    memory = PIXEL_MEMORY * pixels * job.processes
    yield PartCost("film.size", f"a picture of {width}x{height}", memory, 0.0)


def _length_key(scene: Scene) -> str:
    return "duration" if scene.frames is None else "frames"


def terrain_cells(terrain: TerrainConfig) -> tuple[int, int]:
    """Return the number of cells of a terrain along x and z; of a mesh, about as many."""
    if isinstance(terrain, GridTerrain):
        return terrain.cells
    if isinstance(terrain, ImageTerrain):
        if terrain.cells is not None:
            return terrain.cells
        width, height = _png_size(Path(terrain.file))
        return max(width - 1, 1), max(height - 1, 1)
    assert isinstance(terrain, MeshTerrain)
    side = round(_mesh_vertices(Path(terrain.file)) ** 0.5)
    return side, side


def _png_size(file: Path) -> tuple[int, int]:
    """Return the size in the head of a PNG file, (1, 1) of what is none: its reader says so."""
    with suppress(ForeignFileError), opened_file(file, HEIGHT_MAP) as stream:
        head = stream.read(24)
        if head[:8] == b"\x89PNG\r\n\x1a\n" and len(head) == 24:
            width, height = struct.unpack(">II", head[16:24])
            # A larger one is refused by its reader.
            return min(width, 4001), min(height, 4001)
    return 1, 1


MESH_VERTEX_BYTES = 30.0
"""Length of a vertex in a mesh file, with its share of the faces [bytes]."""


def _mesh_vertices(file: Path) -> int:
    with suppress(OSError):
        return max(min(round(file.stat().st_size / MESH_VERTEX_BYTES), 4001**2), 9)
    return 9
