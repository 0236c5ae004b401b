"""Meshes of dancers and their drums, and the solids that others collide with."""

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
from pipeline.simulation.people.person_inventory import person_record
from pipeline.simulation.people.proportions import JOINTS, Proportions
from pipeline.simulation.people.wardrobe import Clothes
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Channel, Face, Mesh, Node, Part
from pipeline.spec.dance import Drum

DRUM_SEGMENTS = 48
"""Sides of a drum."""

DRUM_RIM_RADIUS = 0.006
"""Radius of a drum's bevelled rims [m]."""

CAPSULE_CORNERS = 20
"""Corners at each end of a limb's collision hull."""

SHIN_RADIUS = 0.028
"""Radius of a leg below the knee, per body height."""

STATIC_LINK = "pelvis"
"""Link of the frames without a link of their own: in the dynamics the legs do not move."""


@dataclass(frozen=True, eq=False)
class DancerAppearance:
    """Appearance of a dancer.

    Attributes:
        name: name of the performer.
        proportions: proportions of the body.
        clothes: clothes.
        drums: drums in front of the dancer, by name.
    """

    name: str
    proportions: Proportions
    clothes: Clothes
    drums: dict[str, Drum]

    @property
    def count(self) -> int:
        """Number of nodes: frames, then drums."""
        return len(FRAMES) + len(self.drums)

    def rest(self) -> Array:
        """Returns the rest positions (count, 3) of the nodes [m]."""
        tops = [np.array(drum.at) for drum in self.drums.values()]
        return np.concatenate([frame_origins(self.proportions), *[top[None] for top in tops]])


def frame_links() -> list[int]:
    """Returns the number of the link that moves each frame of a person."""
    return [LINKS.index(frame if frame in LINKS else STATIC_LINK) for frame in FRAMES]


def dancer_inventory(
    appearances: Sequence[DancerAppearance], torsos: Sequence[Torso], rows: int
) -> Inventory:
    """Returns the nodes, channels, meshes, parts and solids of dancers."""
    nodes, channels = list[Node](), list[Channel]()
    meshes, parts, solids = list[Mesh](), list[Part](), list[Obstacle]()
    for appearance, torso in zip(appearances, torsos, strict=True):
        first, own = len(nodes), appearance.name
        person = person_record(
            own, appearance.proportions, appearance.clothes, first, len(meshes), rows
        )
        nodes += person[0]
        meshes += person[1]
        parts += person[2]
        nodes += [
            Node(f"{own}.{name}", own, -1, drum.at) for name, drum in appearance.drums.items()
        ]
        for k, (name, drum) in enumerate(appearance.drums.items()):
            meshes.append(_drum_mesh(drum, first + len(FRAMES) + k))
            size = 2.0 * drum.radius
            part = f"{own}.{name}"
            parts.append(Part(part, own, len(meshes) - 1, drum.material, size, (0, rows)))
        channels += [Channel(f"{appearance.name}.{joint}", "rad") for joint in torso.names]
        channels += [Channel(f"{appearance.name}.{joint}.torque", "N m") for joint in torso.names]
        solids += _solids(appearance, torso, first)
    faces = tuple(Face(appearance.name) for appearance in appearances)
    return Inventory(
        *(tuple(nodes), tuple(channels), tuple(meshes), tuple(parts)),
        solids=tuple(solids),
        faces=faces,
    )


def _solids(appearance: DancerAppearance, torso: Torso, first: int) -> list[Obstacle]:
    """Returns the collision hulls of a dancer: the solids of the torso, and the shins."""
    person, h = appearance.proportions, appearance.proportions.height
    rest, found = dict(zip(JOINTS, person.rest(), strict=True)), list[Obstacle]()
    rows = [(link.name, link.place, solid) for link in torso.linkage.links for solid in link.solids]
    for side in HANDS:
        ends = np.stack([rest[f"knee_{side}"], rest[f"foot_{side}"]])
        shin = Capsule(f"shin_{side}", ends, SHIN_RADIUS * h)
        rows.append((STATIC_LINK, torso.linkage.links[0].place, shin))
    frames = frame_origins(person)
    around = directions(CAPSULE_CORNERS)
    for link, origin, solid in rows:
        # Legs are solids of the pelvis in the dynamics, and move by themselves.
        is_leg = solid.name in FRAMES and link == STATIC_LINK and solid.name != link
        name = solid.name if is_leg else link
        place = frames[FRAMES.index(name)] if is_leg else origin
        corners = (solid.ends[:, None, :] + solid.radius * around).reshape(-1, 3) - place
        node, part = first + FRAMES.index(name), f"{appearance.name}.{solid.name}"
        is_bare = solid.name.startswith(("head", "neck", "forearm", "hand", "shin"))
        material = appearance.clothes.skin if is_bare else appearance.clothes.shirt
        found.append(Obstacle(node, part, appearance.name, material, corners))
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
    """Returns an upright cylinder with bevelled rims, below the centre of its top."""
    angle = np.arange(DRUM_SEGMENTS) * (2.0 * np.pi / DRUM_SEGMENTS)
    ring = np.stack([np.sin(angle), np.zeros(DRUM_SEGMENTS), np.cos(angle)], axis=-1)
    low, outer, inner = -drum.height, drum.radius, drum.radius - DRUM_RIM_RADIUS
    levels = ((inner, low), (outer, low + DRUM_RIM_RADIUS), (outer, -DRUM_RIM_RADIUS), (inner, 0.0))
    rings = np.stack([radius * ring + [0.0, y, 0.0] for radius, y in levels])
    solid = loft(rings, rings[[0, -1]].mean(axis=1))
    return Solid(solid.vertices + np.array(drum.at), solid.faces)
