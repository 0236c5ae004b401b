"""Take file: a take as binary glTF, with its visible meshes, simple materials and all its rows.

Nodes of the take are nodes of glTF, in their hierarchy; meshes that follow one node hang on it,
others are skins. Every row is a key, so that nothing is lost between frames. A node that is scaled,
or not there all the time, has a leaf of its own for what it carries, because its children are
neither scaled nor hidden with it.

Source: Khronos, glTF 2.0 specification.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.production.gltf.binary_file import (
    ARRAY_BUFFER,
    ELEMENT_ARRAY_BUFFER,
    BinaryFile,
)
from pipeline.production.gltf.joint_tracks import (
    Binding,
    JointTrack,
    bind,
    helper_tracks,
    node_track,
    unit_rotations,
)
from pipeline.production.shots.ground_mesh import mean_color
from pipeline.production.shots.skinning import visible_parts
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Mesh, Part, Take
from render.color import linear
from render.config import MATERIALS, Material
from render.vertex_normals import vertex_normals

HELPERS = 3
"""Helper joints between two nodes: a knee is then 1 mm from the renderer's, without any 14 mm."""

Life = tuple[int, int]
_JointKey = tuple[int, int, float, Life]


def take_glb(
    take: Take,
    materials: Mapping[str, Material] | None = None,
    ground: bool = True,
    helpers: int = HELPERS,
) -> bytes:
    """Return a take as a binary glTF file.

    Args:
        take: any take.
        materials: the scene's own, by name, before those of the library.
        ground: whether the terrain is in it.
        helpers: helper joints between two nodes that share vertices.
    """
    return _Writer(take, {**MATERIALS, **(materials or {})}, helpers).content(ground)


class _Writer:
    """Writes one take."""

    def __init__(self, take: Take, materials: Mapping[str, Material], helpers: int) -> None:
        self._take = take
        self._materials = materials
        self._helpers = helpers
        self._file = BinaryFile()
        self._rotations = unit_rotations(take)
        header = take.header
        self._seconds = np.arange(len(take.positions)) / float(header.rate * header.samples)
        self._inputs: dict[int, int] = {}
        self._samplers: list[dict[str, Any]] = []
        self._channels: list[dict[str, Any]] = []
        self._made: dict[str, int] = {}
        self._joints: dict[_JointKey, int] = {}
        self._root = self._file.add("nodes", {"name": "take", "children": []})
        self._nodes: list[int] = []
        for number in range(len(take.nodes)):
            self._nodes.append(self._node(number))

    def content(self, ground: bool) -> bytes:
        """Return the bytes of the file."""
        parts = [part for part in visible_parts(self._take) if self._mesh_of(part).faces.size]
        bindings = [bind(self._mesh_of(part), self._helpers) for part in parts]
        self._add_helpers(parts, bindings)
        skinned = [self._add_part(*pair) for pair in zip(parts, bindings, strict=True)]
        top = [self._root, *(node for node in skinned if node is not None)]
        if ground:
            top.append(self._terrain())
        if self._channels:
            motion = {"name": "take", "samplers": self._samplers, "channels": self._channels}
            self._file.add("animations", motion)
        return self._file.content({"name": self._take.header.title or "take", "nodes": top})

    def _mesh_of(self, part: Part) -> Mesh:
        return self._take.meshes[part.seen]

    def _node(self, number: int) -> int:
        """Add a node of the take with its track; parents come before children."""
        node = self._take.nodes[number]
        parent = self._root if node.parent < 0 else self._nodes[node.parent]
        origin = (0.0, 0.0, 0.0) if node.parent < 0 else self._take.nodes[node.parent].rest
        place = np.subtract(node.rest, origin)
        made = self._child(parent, node.name, place, {"performer": node.performer})
        self._animate(made, node_track(self._take, self._rotations, number))
        return made

    def _child(
        self, parent: int, name: str, place: Array, extras: dict[str, Any] | None = None
    ) -> int:
        """Add a node below another, at its rest pose, which other programs bind meshes in."""
        entry: dict[str, Any] = {"name": name, "translation": [float(v) for v in place]}
        if extras:
            entry["extras"] = extras
        made = self._file.add("nodes", entry)
        self._file.lists["nodes"][parent].setdefault("children", []).append(made)
        return made

    def _animate(self, node: int, track: JointTrack) -> None:
        self._channel(node, "translation", track.positions)
        # wxyz to xyzw.
        self._channel(node, "rotation", np.roll(track.rotations, -1, axis=-1))

    def _channel(self, node: int, path: str, values: Array, steps: bool = False) -> None:
        """Add a track of all rows, of one key where nothing changes."""
        still = bool((values == values[:1]).all())
        keys = np.ascontiguousarray(values[:1] if still else values, dtype=np.float32)
        sampler = {
            "input": self._input(len(keys)),
            "output": self._file.accessor(keys),
            "interpolation": "STEP" if steps else "LINEAR",
        }
        self._samplers.append(sampler)
        target = {"node": node, "path": path}
        self._channels.append({"sampler": len(self._samplers) - 1, "target": target})

    def _input(self, count: int) -> int:
        """Return the accessor of the times of the first rows [s]; only those in use are written."""
        if count not in self._inputs:
            times = self._seconds[:count].astype(np.float32)
            self._inputs[count] = self._file.accessor(times, bounds=True)
        return self._inputs[count]

    def _add_helpers(self, parts: list[Part], bindings: list[Binding]) -> None:
        """Add the joints that stand between two nodes."""
        keys = {
            (*helper, part.life): None
            for part, binding in zip(parts, bindings, strict=True)
            for helper in binding.helpers
            if helper[2] > 0.0
        }
        tracks = helper_tracks(self._take, self._rotations, [key[:3] for key in keys])
        for key, track in zip(keys, tracks, strict=True):
            a, b, share, life = key
            first, second = self._take.nodes[a], self._take.nodes[b]
            name = f"{first.name}~{second.name}~{share:.2f}"
            made = self._child(self._root, name, np.array(second.rest))
            self._animate(made, track)
            self._show(made, a, life)
            self._joints[key] = made

    def _show(self, made: int, node: int, life: Life) -> None:
        """Give a node of glTF the scale of a take's node; none where that is not there."""
        rows = np.arange(len(self._take.positions))
        there = self._take.alive[:, node] & (rows >= life[0]) & (rows < life[1])
        scaled = node in self._take.scaled
        scales = np.ones((len(rows), 3))
        if scaled:
            scales = self._take.scales[:, self._take.scaled.index(node)]
        if scaled or not there.all():
            self._channel(made, "scale", np.where(there[:, None], scales, 0.0), not scaled)

    def _joint(self, helper: tuple[int, int, float], life: Life) -> int:
        """Return the node of glTF that a vertex follows."""
        key = (*helper, life)
        if key not in self._joints:
            node = helper[0]
            whole = life[0] <= 0 and life[1] >= len(self._take.positions)
            if whole and node not in self._take.scaled and self._take.alive[:, node].all():
                self._joints[key] = self._nodes[node]
            else:
                name = f"{self._take.nodes[node].name}~shown"
                made = self._child(self._nodes[node], name, np.zeros(3))
                self._show(made, node, life)
                self._joints[key] = made
        return self._joints[key]

    def _add_part(self, part: Part, binding: Binding) -> int | None:
        """Add a visible part; return its node if it stands at the top, as skins do."""
        mesh = self._mesh_of(part)
        extras = {"performer": part.performer, "part": part.name}
        if len(binding.helpers) == 1:
            node = binding.helpers[0][0]
            shape = self._mesh(part, mesh.vertices - np.array(self._take.nodes[node].rest))
            made = self._child(self._joint(binding.helpers[0], part.life), part.name, np.zeros(3))
            self._file.lists["nodes"][made] |= {"mesh": shape, "extras": extras}
            return None
        joints = np.zeros((len(mesh.vertices), 4), np.uint16)
        weights = np.zeros((len(mesh.vertices), 4), np.float32)
        weights[:, :2] = binding.weights
        joints[:, :2] = np.where(binding.weights > 0.0, binding.joints, 0)
        more = {
            "JOINTS_0": self._file.accessor(joints, ARRAY_BUFFER),
            "WEIGHTS_0": self._file.accessor(weights, ARRAY_BUFFER),
        }
        shape = self._mesh(part, mesh.vertices.astype(float), more)
        skin = self._skin(binding, part.life)
        return self._file.add(
            "nodes", {"name": f"{part.name}~skin", "mesh": shape, "skin": skin, "extras": extras}
        )

    def _skin(self, binding: Binding, life: Life) -> int:
        places = [self._take.nodes[b].rest for _, b, _ in binding.helpers]
        inverse = np.tile(np.eye(4, dtype=np.float32), (len(places), 1, 1))
        inverse[:, :3, 3] = -np.array(places)
        entry = {
            "skeleton": self._root,
            "joints": [self._joint(helper, life) for helper in binding.helpers],
            "inverseBindMatrices": self._file.accessor(inverse),
        }
        return self._file.add("skins", entry)

    def _mesh(self, part: Part, vertices: Array, more: Mapping[str, int] | None = None) -> int:
        """Add a mesh of one material."""
        mesh = self._mesh_of(part)
        places = vertices.astype(np.float32)
        attributes = {
            "POSITION": self._file.accessor(places, ARRAY_BUFFER, bounds=True),
            "NORMAL": self._file.accessor(vertex_normals(places, mesh.faces), ARRAY_BUFFER),
            **(more or {}),
        }
        name = part.material
        if len(mesh.paint):
            name = f"{part.material}, painted"
            base, share = self._color(part.material), mesh.paint[:, 3:]
            painted = (1.0 - share) * base + share * mesh.paint[:, :3]
            attributes["COLOR_0"] = self._file.accessor(painted.astype(np.float32), ARRAY_BUFFER)
        return self._add_mesh(
            part.name, mesh.faces, attributes, self._material(name, part.material)
        )

    def _add_mesh(
        self,
        name: str,
        faces: NDArray[np.uint32],
        attributes: Mapping[str, int],
        material: int,
    ) -> int:
        primitive = {
            "attributes": dict(attributes),
            "indices": self._file.accessor(faces.ravel().astype(np.uint32), ELEMENT_ARRAY_BUFFER),
            "material": material,
        }
        return self._file.add("meshes", {"name": name, "primitives": [primitive]})

    def _color(self, material: str) -> Array:
        """Return the mean linear colour of a material."""
        return np.array(mean_color(self._materials[material]))

    def _material(self, name: str, preset: str) -> int:
        """Return the index of a material, which is white where its mesh brings colours."""
        if name not in self._made:
            config = self._materials[preset]
            color = [1.0, 1.0, 1.0] if name != preset else self._color(preset).tolist()
            surface: dict[str, Any] = {
                "baseColorFactor": [*color, 1.0],
                "metallicFactor": config.metallic,
                "roughnessFactor": config.roughness,
            }
            entry: dict[str, Any] = {"name": name, "pbrMetallicRoughness": surface}
            if config.transmission > 0.0:
                surface["baseColorFactor"] = [*color, 1.0 - 0.7 * config.transmission]
                entry["alphaMode"] = "BLEND"
            if config.glow > 0.0:
                entry["emissiveFactor"] = linear(config.color).tolist()
            self._made[name] = self._file.add("materials", entry)
        return self._made[name]

    def _terrain(self) -> int:
        terrain = self._take.terrain
        places = terrain.vertices.astype(np.float32)
        attributes = {
            "POSITION": self._file.accessor(places, ARRAY_BUFFER, bounds=True),
            "NORMAL": self._file.accessor(vertex_normals(places, terrain.faces), ARRAY_BUFFER),
        }
        material = self._material(terrain.material, terrain.material)
        mesh = self._add_mesh("terrain", terrain.faces, attributes, material)
        return self._file.add("nodes", {"name": "terrain", "mesh": mesh})
