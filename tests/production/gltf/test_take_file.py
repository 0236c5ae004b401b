"""Takes as binary glTF, read back and posed by a reader of its own, against the renderer's skin."""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from pipeline.production.gltf.take_file import take_glb
from pipeline.production.shots.skinning import Skin, visible_parts
from pipeline.simulation.simulate import simulate
from pipeline.simulation.spatial import matrix
from pipeline.simulation.take import Take
from pipeline.spec import read_scene

Array = NDArray[np.float64]

SCENE = """\
pronk: 1
frames: 8
terrain: {kind: flat, size: [8, 8], cells: [8, 8]}
cast:
  - {name: bug, figure: beetle, walk: {}}
  - {name: tom, figure: cat, at: [0, 2], walk: {}}
  - {name: ball, body: {shape: sphere}, at: [2, 1, 0]}
"""

COMPONENTS = {5126: np.float32, 5125: np.uint32, 5123: np.uint16}
SHAPES = {"SCALAR": (), "VEC2": (2,), "VEC3": (3,), "VEC4": (4,), "MAT4": (4, 4)}


@dataclass
class Reader:
    """Reads a GLB by the specification alone."""

    asset: dict[str, Any]
    buffer: bytes

    @staticmethod
    def of(content: bytes) -> Reader:
        """Return a reader of a file."""
        magic, version, length = struct.unpack("<4sII", content[:12])
        assert (magic, version, length) == (b"glTF", 2, len(content))
        size, kind = struct.unpack("<I4s", content[12:20])
        assert kind == b"JSON"
        rest = content[20 + size :]
        assert struct.unpack("<I4s", rest[:8]) == (len(rest) - 8, b"BIN\0")
        return Reader(json.loads(content[20 : 20 + size]), rest[8:])

    def values(self, index: int) -> NDArray[Any]:
        """Return the array of an accessor."""
        entry = self.asset["accessors"][index]
        view = self.asset["bufferViews"][entry["bufferView"]]
        assert view["byteOffset"] % 4 == 0
        piece = self.buffer[view["byteOffset"] :][: view["byteLength"]]
        shape = SHAPES[entry["type"]]
        return np.frombuffer(piece, COMPONENTS[entry["componentType"]]).reshape(-1, *shape)

    def track(self, node: int, path: str, row: int) -> Array | None:
        """Return a key of a node's track, None if it has none."""
        (motion,) = self.asset["animations"]
        for channel in motion["channels"]:
            if channel["target"] == {"node": node, "path": path}:
                keys = self.values(motion["samplers"][channel["sampler"]]["output"])
                return keys[min(row, len(keys) - 1)].astype(float)
        return None

    def worlds(self, row: int) -> dict[int, Array]:
        """Return the world matrices of all nodes."""
        found: dict[int, Array] = {}

        def visit(node: int, above: Array) -> None:
            entry = self.asset["nodes"][node]
            place = self.track(node, "translation", row)
            turned = self.track(node, "rotation", row)
            scale = self.track(node, "scale", row)
            local = np.eye(4)
            if turned is not None:
                assert abs(np.linalg.norm(turned) - 1.0) < 1e-5
                local[:3, :3] = matrix(np.roll(turned, 1))
            local[:3, :3] *= 1.0 if scale is None else scale
            local[:3, 3] = entry.get("translation", (0, 0, 0)) if place is None else place
            found[node] = above @ local
            for child in entry.get("children", ()):
                visit(child, found[node])

        for top in self.asset["scenes"][0]["nodes"]:
            visit(top, np.eye(4))
        return found

    def posed(self, row: int) -> dict[str, Array]:
        """Return the vertices of all parts in the world by the part's name."""
        worlds, result = self.worlds(row), {}
        for number, entry in enumerate(self.asset["nodes"]):
            if "part" not in entry.get("extras", {}):
                continue
            (primitive,) = self.asset["meshes"][entry["mesh"]]["primitives"]
            names = primitive["attributes"]
            points = self.values(names["POSITION"]).astype(float)
            points = np.concatenate([points, np.ones((len(points), 1))], axis=-1)
            mats = worlds[number][None]
            if "skin" in entry:
                skin = self.asset["skins"][entry["skin"]]
                inverse = self.values(skin["inverseBindMatrices"]).transpose(0, 2, 1)
                bones = np.array([worlds[joint] for joint in skin["joints"]]) @ inverse
                joints, weights = self.values(names["JOINTS_0"]), self.values(names["WEIGHTS_0"])
                np.testing.assert_allclose(weights.sum(axis=-1), 1.0, atol=1e-6)
                mats = (bones[joints] * weights[..., None, None]).sum(axis=1)
            result[entry["extras"]["part"]] = (mats @ points[..., None])[..., :3, 0]
        return result


def expected(take: Take, row: int) -> dict[str, Array]:
    skin, parts = Skin.of(take), visible_parts(take)
    whole = skin.posed(take, row).astype(float)
    return {part.name: whole[skin.starts[i] : skin.starts[i + 1]] for i, part in enumerate(parts)}


def error(take: Take, content: bytes, row: int) -> float:
    got, right = Reader.of(content).posed(row), expected(take, row)
    assert got.keys() == right.keys()
    return max(float(np.abs(got[name] - right[name]).max()) for name in right)


@pytest.fixture(scope="module")
def take() -> Take:
    return simulate(read_scene(SCENE))


def test_every_row_shows_what_the_renderer_shows(take: Take) -> None:
    content = take_glb(take, helpers=7)
    assert len(take.positions) > 30
    for row in (0, 13, len(take.positions) - 1):
        assert error(take, content, row) < 1e-3


def test_more_helpers_come_nearer_to_the_renderer(take: Take) -> None:
    few, many = (error(take, take_glb(take, helpers=n), 17) for n in (0, 7))
    assert many < 0.2 * few


def test_rotations_keep_their_sign_from_row_to_row(take: Take) -> None:
    reader = Reader.of(take_glb(take))
    (motion,) = reader.asset["animations"]
    seen = 0
    for channel in motion["channels"]:
        if channel["target"]["path"] == "rotation":
            keys = reader.values(motion["samplers"][channel["sampler"]]["output"])
            assert ((keys[1:] * keys[:-1]).sum(axis=-1) > 0.0).all()
            seen += len(keys) > 1
    assert seen > 20


def test_the_static_pose_is_the_rest_pose(take: Take) -> None:
    reader = Reader.of(take_glb(take))
    nodes = reader.asset["nodes"]
    place: dict[int, Array] = {}

    def visit(node: int, above: Array) -> None:
        place[node] = above + np.array(nodes[node].get("translation", (0, 0, 0)))
        for child in nodes[node].get("children", ()):
            visit(child, place[node])

    for top in reader.asset["scenes"][0]["nodes"]:
        visit(top, np.zeros(3))
    named = {entry["name"]: i for i, entry in enumerate(nodes)}
    for node in take.nodes:
        np.testing.assert_allclose(place[named[node.name]], node.rest, atol=1e-6)


def test_what_is_gone_or_scaled_does_not_take_its_children_along(take: Take) -> None:
    hidden, scaled = 1, 2
    assert take.nodes[scaled].parent == hidden
    alive = take.alive.copy()
    alive[5:, hidden] = False
    scales = np.tile([1.0, 2.0, 0.5], (len(alive), 1, 1))
    changed = replace(take, alive=alive, scaled=(scaled,), scales=scales)
    content = take_glb(changed, helpers=7)
    worlds = Reader.of(content).worlds(9)
    named = {entry["name"]: i for i, entry in enumerate(Reader.of(content).asset["nodes"])}
    child = take.nodes[3].name
    np.testing.assert_allclose(worlds[named[child]][:3, 3], take.positions[9, 3], atol=1e-5)
    shown = worlds[named[f"{take.nodes[hidden].name}~shown"]]
    assert not shown[:3, :3].any()
    stretched = worlds[named[f"{take.nodes[scaled].name}~shown"]][:3, :3]
    np.testing.assert_allclose(np.linalg.norm(stretched, axis=0), [1.0, 2.0, 0.5], atol=1e-5)


def test_a_part_is_seen_only_in_its_life(take: Take) -> None:
    number = next(i for i, part in enumerate(take.parts) if part.performer == "ball")
    parts = list(take.parts)
    parts[number] = replace(parts[number], life=(3, 6))
    content = take_glb(replace(take, parts=tuple(parts)))
    name = parts[number].name
    spans = [
        float(np.ptp(Reader.of(content).posed(row)[name], axis=0).max()) for row in (2, 3, 5, 6)
    ]
    assert [span > 0.1 for span in spans] == [False, True, True, False]


def test_paint_is_baked_into_the_colours_of_vertices(take: Take) -> None:
    seen = [part.seen for part in take.parts if part.performer == "ball"]
    meshes = list(take.meshes)
    n = len(meshes[seen[0]].vertices)
    red = np.tile(np.array([1.0, 0.0, 0.0, 1.0], np.float32), (n, 1))
    meshes[seen[0]] = replace(meshes[seen[0]], paint=red)
    reader = Reader.of(take_glb(replace(take, meshes=tuple(meshes)), ground=False))
    node = next(
        entry
        for entry in reader.asset["nodes"]
        if entry.get("extras", {}).get("part", "").startswith("ball")
    )
    (primitive,) = reader.asset["meshes"][node["mesh"]]["primitives"]
    np.testing.assert_array_equal(reader.values(primitive["attributes"]["COLOR_0"]), red[:, :3])
    assert all(entry["name"] != "terrain" for entry in reader.asset["nodes"])
