"""Take: what happened, and the only thing that leaves the simulation.

Rows are samples, S a frame; row 0 is frame 1, and S rows follow the last frame's.
The camera is not in it: a take can be filmed again with another look.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from dataclasses import MISSING, dataclass, field, fields
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.mechanism import Leg, Mechanism, NodeAlias
from pipeline.simulation.row_storage import row_chunks
from pipeline.simulation.spatial import Array

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

FORMAT = 1
"""Version of the take's layout."""

Place = tuple[float, float, float]

ContactKind = Literal["touch", "scuff", "hit", "roll", "slide", "lift"]

TABLES = (
    "nodes",
    "channels",
    "parts",
    "contacts",
    "events",
    "notes",
    "told",
    "mechanisms",
    "legs",
    "aliases",
)
"""Attributes of a take that are tables of records."""

OPTIONAL_TABLES = ("told", "mechanisms", "legs", "aliases")
"""Tables left out where they are empty: earlier takes have none, and keep their digests."""


@dataclass(frozen=True, slots=True)
class Header:
    """What a take is, and by what it was made.

    Attributes:
        key: digest of all that the simulation read; equal keys mean equal takes on one
            class of processor with one set of versions.
        title: of the scene.
        rate: frames a second.
        frames: number of frames.
        samples: rows a frame (S).
        steps: world steps a frame.
        seed: of the scene.
        versions: name -> version of what computed it, the language and the class of
            processor among them.
        format: of the take.
    """

    key: str
    title: str
    rate: Fraction
    frames: int
    samples: int
    steps: int
    seed: int
    versions: dict[str, str]
    format: int = FORMAT

    def as_dict(self) -> dict[str, Any]:
        """Return the header as plain values."""
        plain = {f.name: getattr(self, f.name) for f in fields(self) if f.name != "rate"}
        return {**plain, "rate": [self.rate.numerator, self.rate.denominator]}

    @staticmethod
    def from_dict(plain: dict[str, Any]) -> Header:
        """Return the header that `as_dict` wrote."""
        words = {name: value for name, value in plain.items() if name != "rate"}
        return Header(rate=Fraction(*plain["rate"]), **words)


@dataclass(frozen=True, slots=True)
class Node:
    """A frame that moves.

    Attributes:
        name: unique, such as "bug.l1.2".
        performer: whose it is.
        parent: number of the node it hangs on, -1 for none.
        rest: its place in the frame that its meshes' vertices are given in [m].
    """

    name: str
    performer: str
    parent: int
    rest: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Channel:
    """A number that changes over the rows, such as a joint value or a gait phase."""

    name: str
    unit: str


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles that follow at most two nodes a vertex; topology is constant.

    Attributes:
        vertices: (V, 3) float32 in the rest frame [m].
        faces: (F, 3) uint32, counter-clockwise from outside.
        nodes: (V, 2) int32 node numbers.
        weights: (V, 2) float32, summing to one.
        uv: (V, 2) float32, (0, 2) for none [m].
    """

    vertices: NDArray[np.float32]
    faces: NDArray[np.uint32]
    nodes: NDArray[np.int32]
    weights: NDArray[np.float32]
    uv: NDArray[np.float32] = field(default_factory=lambda: np.zeros((0, 2), np.float32))


OWN, UNSEEN = -1, -2
"""Looks of a part: its own mesh, or none, since another part's look covers it."""


@dataclass(frozen=True, slots=True)
class Part:
    """One solid, and what is seen of it.

    What it weighs, strikes and sounds like follows from its mesh; it may look otherwise.

    Attributes:
        name: unique, such as "bug.l1.2".
        performer: whose it is.
        mesh: number of its mesh.
        material: by name.
        size: characteristic length [m].
        life: first row in which it is seen, and the first in which it no longer is.
        look: number of the mesh that is seen in its place; `OWN` or `UNSEEN`.
    """

    name: str
    performer: str
    mesh: int
    material: str
    size: float
    life: tuple[int, int]
    look: int = OWN

    @property
    def seen(self) -> int:
        """Number of the mesh that is seen; `UNSEEN` if there is none."""
        return self.mesh if self.look == OWN else self.look


@dataclass(frozen=True, slots=True)
class Contact:
    """The begin of a contact.

    Attributes:
        step: the last step before it.
        fraction: of a step after that, in [0, 1).
        performer: who touched.
        part: with what, such as "l1".
        other: what was touched, such as "terrain".
        place: where [m].
        normal: of the surface touched.
        speed: of approach along the normal; of what rubs along the surface, at most [m/s].
        energy: of what goes at this speed [J].
        material: of the part.
        surface: material of the other.
        size: characteristic length of the part [m].
        kind: "touch" if the part comes to rest, "scuff" if it brushes over the other, "hit" if
            what moves freely strikes it, "roll" and "slide" if it does so over the other, "lift"
            if it leaves the other, with its body's speed.
        until: of what rolls or slides, the last step at which it does.
        speeds: of what rolls or slides, at each row from its step to its last [m/s].
        places: of what rolls or slides, at each of these rows [m].
    """

    step: int
    fraction: float
    performer: str
    part: str
    other: str
    place: Place
    normal: tuple[float, float, float]
    speed: float
    energy: float
    material: str
    surface: str
    size: float
    kind: ContactKind = "touch"
    until: int = -1
    speeds: tuple[float, ...] = ()
    places: tuple[Place, ...] = ()


@dataclass(frozen=True, slots=True)
class SoundEvent:
    """Something heard.

    Attributes:
        step: the last step before it.
        fraction: of a step after that, in [0, 1).
        frame: the first that shows it; may lie after the last.
        cause: "footfall", "scuff", ...
        who: performer that sounds.
        part: the part of it that sounds.
        other: with whom or what.
        place: where [m].
        strength: speed of approach or of the motion [m/s].
        energy: of the impact [J].
        size: characteristic length of what sounds [m].
        material: of what sounds.
        surface: material of the other.
        track: rows over which it lasts, (first, last), equal for an onset.
        strengths: at each of these rows, where it lasts [m/s].
        places: at each of these rows, where it lasts [m].
    """

    step: int
    fraction: float
    frame: int
    cause: str
    who: str
    part: str
    other: str
    place: Place
    strength: float
    energy: float
    size: float
    material: str
    surface: str
    track: tuple[int, int]
    strengths: tuple[float, ...] = ()
    places: tuple[Place, ...] = ()


@dataclass(frozen=True, slots=True)
class Note:
    """Something the author should know: stopped, toppled, dropped, clamped."""

    kind: str
    step: int
    part: str
    text: str


@dataclass(frozen=True, slots=True)
class Told:
    """An instruction of the script, when it was given: to `who`, from `step` on."""

    step: int
    who: str
    text: str


@dataclass(frozen=True, eq=False)
class TerrainRecord:
    """The ground as it was stood on.

    Attributes:
        vertices: (V, 3) [m].
        faces: (F, 3) uint32.
        cells: cells along x and z.
        forbidden: (n_z, n_x) cells that no foot may be put on.
        material: by name.
    """

    vertices: Array
    faces: NDArray[np.uint32]
    cells: tuple[int, int]
    forbidden: NDArray[np.bool_]
    material: str


@dataclass(frozen=True, eq=False)
class Take:
    """A finished simulation.

    Attributes:
        header: what it is.
        nodes: J frames that move.
        positions: (K, J, 3) of the nodes [m].
        rotations: (K, J, 4) quaternions wxyz with continuous sign.
        alive: (K, J).
        scales: (K, n, 3) of the few nodes that have one, `scaled` saying which.
        scaled: numbers of those nodes.
        channels: C numbers that change.
        values: (K, C) of the channels.
        meshes: surfaces that follow nodes.
        parts: solids, and what is seen of them.
        terrain: the ground.
        contacts: in the order of time.
        events: sound events in the order of time.
        notes: what the author should know.
        told: instructions given by the script, in the order of time.
        mechanisms: joints and masses of the creatures on legs.
        legs: legs of these creatures, with the stances that their gaits planned.
        aliases: names of drawing nodes for the nodes of creatures.
    """

    header: Header
    nodes: tuple[Node, ...]
    positions: Array
    rotations: Array
    alive: NDArray[np.bool_]
    scales: Array
    scaled: tuple[int, ...]
    channels: tuple[Channel, ...]
    values: Array
    meshes: tuple[Mesh, ...]
    parts: tuple[Part, ...]
    terrain: TerrainRecord
    contacts: tuple[Contact, ...]
    events: tuple[SoundEvent, ...]
    notes: tuple[Note, ...]
    told: tuple[Told, ...] = ()
    mechanisms: tuple[Mechanism, ...] = ()
    legs: tuple[Leg, ...] = ()
    aliases: tuple[NodeAlias, ...] = ()

    def arrays(self) -> Iterator[tuple[str, NDArray[np.generic]]]:
        """Yield the name and the values of every array, in a fixed order."""
        for name in ("positions", "rotations", "alive", "scales", "values"):
            yield name, getattr(self, name)
        for name in ("vertices", "faces", "forbidden"):
            yield f"terrain/{name}", getattr(self.terrain, name)
        # Meshes one after the other: a handful of arrays, however many there are.
        for f in fields(Mesh):
            values = [getattr(mesh, f.name) for mesh in self.meshes]
            yield f"meshes/{f.name}", np.concatenate(values) if values else np.zeros((0, 2))

    @property
    def mesh_sizes(self) -> list[list[int]]:
        """Rows that each mesh has in each of its arrays."""
        return [[len(getattr(mesh, f.name)) for f in fields(Mesh)] for mesh in self.meshes]

    def tables(self) -> dict[str, list[list[Any]]]:
        """Return everything that is no array as rows of plain values.

        Last columns that have their defaults are left out, so that what was written before
        there were such columns has the same digest still.
        """
        return {name: [_plain(row) for row in getattr(self, name)] for name in self._kept()}

    def _kept(self) -> list[str]:
        """Return the names of the tables that are kept."""
        return [name for name in TABLES if name not in OPTIONAL_TABLES or getattr(self, name)]

    def _words(self) -> Iterator[str]:
        """Yield, piece by piece, all that is no array as one JSON text with sorted keys."""
        head, scaled, sizes = self.header.as_dict(), self.scaled, self.mesh_sizes
        yield f'{{"header": {_json(head)}, "meshes": {_json(sizes)}, "scaled": {_json(scaled)}, '
        yield '"tables": {'
        for i, name in enumerate(sorted(self._kept())):
            yield f'{", " if i else ""}"{name}": ['
            # Row by row: of a long film the whole text would be as much memory as the contacts.
            for k, row in enumerate(getattr(self, name)):
                yield (", " if k else "") + _json(_plain(row))
            yield "]"
        yield f'}}, "terrain": {_json([self.terrain.cells, self.terrain.material])}}}'

    @cached_property
    def digest(self) -> str:
        """Digest of it all, as hexadecimal digits."""
        state = hashlib.blake2b(digest_size=20)
        for words in self._words():
            state.update(words.encode())
        for name, values in self.arrays():
            state.update(f"{name}{values.dtype.str}{values.shape}".encode())
            for some in row_chunks(values):
                state.update(np.ascontiguousarray(values[some]).data)
        return state.hexdigest()


def _plain(row: DataclassInstance) -> list[Any]:
    columns = fields(row)
    values = [getattr(row, f.name) for f in columns]
    while columns[len(values) - 1].default is not MISSING and (
        values[-1] == columns[len(values) - 1].default
    ):
        values.pop()
    return values


def _json(words: Any) -> str:
    return json.dumps(words, sort_keys=True)
