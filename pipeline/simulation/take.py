"""Take: the result of a simulation, and the only thing that leaves it.

Rows are samples, S per frame; row 0 is frame 1, and S rows follow the last frame's. The camera is
not in it: a take can be filmed again with another look.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from dataclasses import MISSING, dataclass, field, fields, replace
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
    *("nodes", "channels", "parts", "contacts", "events"),
    *("notes", "mechanisms", "legs", "aliases", "orders", "faces", "beats"),
)
"""Attributes of a take that are tables of records."""

OPTIONAL_TABLES = ("mechanisms", "legs", "aliases", "orders", "faces", "beats")
"""Tables left out where they are empty: earlier takes have none, and keep their digests."""


@dataclass(frozen=True, slots=True)
class Header:
    """What a take is, and what it was made by.

    Attributes:
        key: digest of all that the simulation read; equal keys mean equal takes on one class of
            processor with one set of versions.
        title: of the scene.
        rate: frames per second.
        frames: number of frames.
        samples: rows per frame (S).
        steps: world steps per frame.
        seed: of the scene.
        versions: versions of what computed it, of the language and the class of processor, by name.
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
        """Returns the header as plain values."""
        plain = {f.name: getattr(self, f.name) for f in fields(self) if f.name != "rate"}
        return {**plain, "rate": [self.rate.numerator, self.rate.denominator]}

    @staticmethod
    def from_dict(plain: dict[str, Any]) -> Header:
        """Returns the header that `as_dict` wrote."""
        others = {name: value for name, value in plain.items() if name != "rate"}
        return Header(rate=Fraction(*plain["rate"]), **others)


@dataclass(frozen=True, slots=True)
class Node:
    """A moving frame.

    Attributes:
        name: unique, such as "bug.l1.2".
        performer: name of its performer.
        parent: number of its parent node, -1 for none.
        rest: its position in the frame of its meshes' vertices [m].
    """

    name: str
    performer: str
    parent: int
    rest: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Channel:
    """A scalar time series, such as a joint value or a gait phase."""

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
        paint: (V, 4) float32 linear colour in place of the material's, and its share; (0, 4) for
            none.
        hair: (V, 3) float32 of a coat, from root to tip in the rest frame [m]; (0, 3) for none.
        targets: (n, 2) int32 vertex, and the unit of its performer's face that moves it; (0, 2) for
            none.
        offsets: (n, 3) float32 by which it moves at the unit's full action, in the rest frame [m].
        creases: (V, 3) float32 by which a vertex moves where its two nodes are turned by a right
            angle or more, by the sine of a smaller one, in the rest frame [m]; (0, 3) for none.
        twists: (V, 3) float32 middle direction of the limb of a vertex in the rest frame, where it
            hangs along -Y, as long as the share of the second node's twist that the vertex does not
            take; (0, 3) for none.
    """

    vertices: NDArray[np.float32]
    faces: NDArray[np.uint32]
    nodes: NDArray[np.int32]
    weights: NDArray[np.float32]
    uv: NDArray[np.float32] = field(default_factory=lambda: np.zeros((0, 2), np.float32))
    paint: NDArray[np.float32] = field(default_factory=lambda: np.zeros((0, 4), np.float32))
    hair: NDArray[np.float32] = field(default_factory=lambda: np.zeros((0, 3), np.float32))
    targets: NDArray[np.int32] = field(default_factory=lambda: np.zeros((0, 2), np.int32))
    offsets: NDArray[np.float32] = field(default_factory=lambda: np.zeros((0, 3), np.float32))
    creases: NDArray[np.float32] = field(default_factory=lambda: np.zeros((0, 3), np.float32))
    twists: NDArray[np.float32] = field(default_factory=lambda: np.zeros((0, 3), np.float32))


OPTIONAL_ARRAYS = ("paint", "hair", "targets", "offsets", "creases", "twists")
"""Arrays of meshes that may be empty, the last ones of a mesh."""


OWN, UNSEEN = -1, -2
"""Special values of `Part.look`: its own mesh; or no mesh, covered by another part's look."""


@dataclass(frozen=True, slots=True)
class Part:
    """One solid and its appearance.

    Mass, impacts and sound follow from its mesh; the render mesh may be another.

    Attributes:
        name: unique, such as "bug.l1.2".
        performer: name of its performer.
        mesh: number of its mesh.
        material: by name.
        size: characteristic length [m].
        life: first row in which it is visible, and the first in which it no longer is.
        look: number of its render mesh; `OWN` or `UNSEEN`.
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
        """Number of the visible mesh; `UNSEEN` if there is none."""
        return self.mesh if self.look == OWN else self.look


@dataclass(frozen=True, slots=True)
class Contact:
    """The start of a contact.

    Attributes:
        step: last step before it.
        fraction: of a step after that, in [0, 1).
        performer: name of the performer.
        part: its part, such as "l1".
        other: thing touched, such as "terrain".
        place: position [m].
        normal: of the surface touched.
        speed: approach speed along the normal; of rolling or sliding, the greatest tangential
            speed [m/s].
        energy: kinetic energy at this speed [J].
        material: of the part.
        surface: material of the other.
        size: characteristic length of the part [m].
        kind: "touch" if the part comes to rest, "scuff" if it brushes over the other, "hit" if it
            strikes freely, "roll" and "slide" along the other, "lift" if it leaves the other, with
            its body's speed.
        until: last step of rolling or sliding.
        speeds: of rolling or sliding, at each row [m/s].
        places: of rolling or sliding, at each row [m].
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
    """A sound.

    Attributes:
        step: last step before it.
        fraction: of a step after that, in [0, 1).
        frame: first frame that shows it; may lie after the last.
        cause: "footfall", "scuff", ...
        who: performer that sounds.
        part: its part that sounds.
        other: the other performer or thing.
        place: position [m].
        strength: speed of the approach or the motion [m/s].
        energy: of the impact [J].
        size: characteristic length of the source [m].
        material: of the source.
        surface: material of the other.
        track: first and last row of a lasting sound, equal for an onset.
        strengths: of a lasting sound, at each row [m/s].
        places: of a lasting sound, at each row [m].
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
class TakeNote:
    """A message to the author, of a kind such as stopped, toppled or overlaps.

    `drawn` is about a likely mistake in a figure's drawing. Orders have records instead.
    """

    kind: str
    step: int
    part: str
    text: str


NEVER_GIVEN = "never given"


@dataclass(frozen=True, slots=True)
class OrderRecord:
    """What became of an order.

    Attributes:
        who: name of the performer.
        text: the order as its author wrote it.
        step: from which it was given.
        end: step at which it ended, -1 while it lasts.
        outcome: "done", "begun" for what has no end, "replaced" by another order, "given up",
            "cut off" by the end of the film, or "never given".
        reason: why it was given up or never given.
    """

    who: str
    text: str
    step: int
    end: int
    outcome: str
    reason: str = ""


@dataclass(frozen=True, slots=True)
class BeatRecord:
    """What became of a beat, or of a goal, of the story.

    Attributes:
        name: of the beat or goal.
        choice: name of the way in which it was played, "" for the only one.
        step: at which it began, or was reached.
        end: step at which it was over.
        outcome: "played", "cut off" by the end of the film, or "never played"; of a goal
            "reached" or "never reached".
        reason: why it was picked, or why it never was.
        tension: that it leads to, 0 to 1.
        ending: why it was over.
    """

    name: str
    choice: str
    step: int
    end: int
    outcome: str
    reason: str
    tension: float = 0.0
    ending: str = ""

    @property
    def is_played(self) -> bool:
        """Whether it is a beat that was played, if only in part."""
        return self.outcome in ("played", "cut off", "playing")

    def ended(self, step: int, outcome: str, ending: str) -> BeatRecord:
        """Returns the record of the beat when it is over."""
        return replace(self, end=step, outcome=outcome, ending=ending)


@dataclass(frozen=True, slots=True)
class Face:
    """A face that moves, by the name of its performer."""

    performer: str


@dataclass(frozen=True, eq=False)
class TerrainRecord:
    """The ground of a take.

    Attributes:
        vertices: (V, 3) [m].
        faces: (F, 3) uint32.
        cells: cells along x and z.
        forbidden: (n_z, n_x) cells without footholds.
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
        header: versions and key.
        nodes: J moving frames.
        positions: (K, J, 3) of the nodes [m].
        rotations: (K, J, 4) quaternions wxyz with continuous sign.
        alive: (K, J).
        scales: (K, n, 3) of the nodes in `scaled`.
        scaled: numbers of the nodes that have a scale.
        channels: C time series.
        values: (K, C) of the channels.
        meshes: surfaces that follow nodes.
        parts: solids and their appearance.
        terrain: the ground.
        contacts: in the order of time.
        events: sound events in the order of time.
        notes: messages to the author.
        mechanisms: joints and masses of the creatures on legs.
        legs: legs of these creatures, with the stances that their gaits planned.
        aliases: names of drawing nodes for the nodes of creatures.
        orders: of the script, and what became of them, in the order of time.
        faces: F faces that move.
        beats: of the story, and its goals, in the order of time.
        expressions: (K, F, n) float32 units and gaze of these, in the order of
            `face_units.COLUMNS`; empty without faces.
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
    notes: tuple[TakeNote, ...]
    mechanisms: tuple[Mechanism, ...] = ()
    legs: tuple[Leg, ...] = ()
    aliases: tuple[NodeAlias, ...] = ()
    orders: tuple[OrderRecord, ...] = ()
    faces: tuple[Face, ...] = ()
    beats: tuple[BeatRecord, ...] = ()
    expressions: NDArray[np.float32] = field(
        default_factory=lambda: np.zeros((0, 0, 0), np.float32)
    )

    def arrays(self) -> Iterator[tuple[str, NDArray[np.generic]]]:
        """Yields the name and the values of every array, in a fixed order."""
        for name in ("positions", "rotations", "alive", "scales", "values"):
            yield name, getattr(self, name)
        if self.faces:
            # Left out of takes without faces, which keep the digests that they had before.
            yield "expressions", self.expressions
        for name in ("vertices", "faces", "forbidden"):
            yield f"terrain/{name}", getattr(self.terrain, name)
        # Concatenated meshes: a handful of arrays, however many meshes there are.
        for name in self._mesh_arrays:
            values = [getattr(mesh, name) for mesh in self.meshes]
            yield f"meshes/{name}", np.concatenate(values) if values else np.zeros((0, 2))

    @property
    def _mesh_arrays(self) -> list[str]:
        """Arrays of meshes; optional ones only up to the last that there is.

        So takes without them keep the digests that they had before there were any.
        """
        names = [f.name for f in fields(Mesh)]
        while names[-1] in OPTIONAL_ARRAYS and not any(
            len(getattr(mesh, names[-1])) for mesh in self.meshes
        ):
            names.pop()
        return names

    @property
    def mesh_sizes(self) -> list[list[int]]:
        """Lengths of the arrays of each mesh."""
        names = self._mesh_arrays
        return [[len(getattr(mesh, name)) for name in names] for mesh in self.meshes]

    def tables(self) -> dict[str, list[list[Any]]]:
        """Returns all tables as rows of plain values.

        Trailing columns with default values are left out, so that digests of takes written before
        these columns existed stay the same.
        """
        return {name: [_plain(row) for row in getattr(self, name)] for name in self._table_names()}

    def _table_names(self) -> list[str]:
        return [name for name in TABLES if name not in OPTIONAL_TABLES or getattr(self, name)]

    def _json_pieces(self) -> Iterator[str]:
        """Yields, piece by piece, all but the arrays as one JSON text with sorted keys."""
        head, scaled, sizes = self.header.as_dict(), self.scaled, self.mesh_sizes
        yield f'{{"header": {_json(head)}, "meshes": {_json(sizes)}, "scaled": {_json(scaled)}, '
        yield '"tables": {'
        for i, name in enumerate(sorted(self._table_names())):
            yield f'{", " if i else ""}"{name}": ['
            # Row by row: for a long film the whole text would take as much memory as the contacts.
            for k, row in enumerate(getattr(self, name)):
                yield (", " if k else "") + _json(_plain(row))
            yield "]"
        yield f'}}, "terrain": {_json([self.terrain.cells, self.terrain.material])}}}'

    @cached_property
    def digest(self) -> str:
        """Digest of everything, as hexadecimal digits."""
        state = hashlib.blake2b(digest_size=20)
        for piece in self._json_pieces():
            state.update(piece.encode())
        for name, values in self.arrays():
            state.update(f"{name}{values.dtype.str}{values.shape}".encode())
            for chunk in row_chunks(values):
                state.update(np.ascontiguousarray(values[chunk]).data)
        return state.hexdigest()


def _plain(row: DataclassInstance) -> list[Any]:
    columns = fields(row)
    values = [getattr(row, f.name) for f in columns]
    while columns[len(values) - 1].default is not MISSING and (
        values[-1] == columns[len(values) - 1].default
    ):
        values.pop()
    return values


def _json(value: Any) -> str:
    return json.dumps(value, sort_keys=True)
