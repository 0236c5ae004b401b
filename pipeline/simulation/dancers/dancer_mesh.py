"""Looks: what is seen of dancers: a clothed person on its frames, and the drums before it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.dancers.torso import HANDS, LINKS, Torso
from pipeline.simulation.dynamics.linkage import Capsule
from pipeline.simulation.figures.solids import Solid, loft
from pipeline.simulation.inventory import Inventory
from pipeline.simulation.obstacles import Obstacle, directions
from pipeline.simulation.people.body_frames import FRAMES, frame_origins
from pipeline.simulation.people.person_mesh import Clothes, layer_parts, person_layers
from pipeline.simulation.people.proportions import JOINTS, Proportions
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Channel, Mesh, Node, Part
from pipeline.spec.dance import Drum

AROUND, RIM = 48, 0.006
"""Sides of a drum, and how much its rims are rounded [m]."""

CORNERS = 20
"""Corners of each end of a limb, as others run into it."""

SHIN = 0.028
"""Radius of a leg below the knee, in heights."""

FIXED = "pelvis"
"""The link that frames go with which no link moves: the legs stand still."""


@dataclass(frozen=True, eq=False)
class DancerAppearance:
    """A dancer as it is seen.

    Attributes:
        name: its.
        proportions: its.
        clothes: that it wears.
        drums: that stand before it, by name.
    """

    name: str
    proportions: Proportions
    clothes: Clothes
    drums: dict[str, Drum]

    @property
    def count(self) -> int:
        """Number of its nodes: frames, then drums."""
        return len(FRAMES) + len(self.drums)

    def rest(self) -> Array:
        """Returns (count, 3) where its nodes are at rest [m]."""
        tops = [np.array(drum.at) for drum in self.drums.values()]
        return np.concatenate([frame_origins(self.proportions), *[top[None] for top in tops]])


def frame_links() -> list[int]:
    """Returns the link that each frame of a person goes with."""
    return [LINKS.index(frame if frame in LINKS else FIXED) for frame in FRAMES]


def dancer_inventory(
    looks: Sequence[DancerAppearance], torsos: Sequence[Torso], rows: int
) -> Inventory:
    """Returns what dancers add to a take."""
    nodes, channels = list[Node](), list[Channel]()
    meshes, parts, solids = list[Mesh](), list[Part](), list[Obstacle]()
    for look, torso in zip(looks, torsos, strict=True):
        first, rest = len(nodes), look.rest().tolist()
        for name, place in zip((*FRAMES, *look.drums), rest, strict=True):
            nodes.append(Node(f"{look.name}.{name}", look.name, -1, (place[0], place[1], place[2])))
        layers = person_layers(look.proportions, look.clothes)
        own, seen = layer_parts(look.name, layers, first, len(meshes), rows)
        meshes += own
        parts += seen
        for k, (name, drum) in enumerate(look.drums.items()):
            meshes.append(_drum_mesh(drum, first + len(FRAMES) + k))
            size = 2.0 * drum.radius
            whole = f"{look.name}.{name}"
            parts.append(Part(whole, look.name, len(meshes) - 1, drum.material, size, (0, rows)))
        channels += [Channel(f"{look.name}.{joint}", "rad") for joint in torso.names]
        channels += [Channel(f"{look.name}.{joint}.torque", "N m") for joint in torso.names]
        solids += _solids(look, torso, first)
    return Inventory(
        tuple(nodes), tuple(channels), tuple(meshes), tuple(parts), solids=tuple(solids)
    )


def _solids(look: DancerAppearance, torso: Torso, first: int) -> list[Obstacle]:
    """Returns what others run into: the solids of a torso, and its legs below the knees."""
    who, h = look.proportions, look.proportions.height
    rest, found = dict(zip(JOINTS, who.rest(), strict=True)), list[Obstacle]()
    rows = [(link.name, link.place, solid) for link in torso.linkage.links for solid in link.solids]
    for side in HANDS:
        ends = np.stack([rest[f"knee_{side}"], rest[f"foot_{side}"]])
        shin = Capsule(f"shin_{side}", ends, SHIN * h)
        rows.append((FIXED, torso.linkage.links[0].place, shin))
    around = directions(CORNERS)
    for name, place, solid in rows:
        corners = (solid.ends[:, None, :] + solid.radius * around).reshape(-1, 3) - place
        node, whole = first + FRAMES.index(name), f"{look.name}.{solid.name}"
        bare = solid.name.startswith(("head", "neck", "forearm", "hand", "shin"))
        material = look.clothes.skin if bare else look.clothes.shirt
        found.append(Obstacle(node, whole, look.name, material, corners))
    return found


def _drum_mesh(drum: Drum, node: int) -> Mesh:
    solid = _drum(drum)
    count = len(solid.vertices)
    return Mesh(
        solid.vertices.astype(np.float32),
        solid.faces,
        np.full((count, 2), node, dtype=np.int32),
        np.tile(np.array([1.0, 0.0], dtype=np.float32), (count, 1)),
    )


def _drum(drum: Drum) -> Solid:
    """Returns an upright cylinder below the middle of its top, its rims rounded."""
    angle = np.arange(AROUND) * (2.0 * np.pi / AROUND)
    ring = np.stack([np.sin(angle), np.zeros(AROUND), np.cos(angle)], axis=-1)
    low, outer, inner = -drum.height, drum.radius, drum.radius - RIM
    levels = ((inner, low), (outer, low + RIM), (outer, -RIM), (inner, 0.0))
    rings = np.stack([radius * ring + [0.0, y, 0.0] for radius, y in levels])
    solid = loft(rings, rings[[0, -1]].mean(axis=1))
    return Solid(solid.vertices + np.array(drum.at), solid.faces)
