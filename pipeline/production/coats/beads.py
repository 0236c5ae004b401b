"""Beads: drops of rain that stand on the smooth skins of performers, such as shells.

Each is a dome on a face of the skin, with which it moves. Light that goes through a drop comes out
on the side away from the sky: domes are brighter below than above, and mirror the sky.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.production.coats.pelt import skin_colors
from pipeline.production.shots.skinning import visible_parts
from pipeline.simulation.spatial import Array, cross, normalized
from pipeline.simulation.take import Mesh as TakeMesh
from pipeline.simulation.take import Part, Take
from render.config import Material
from render.shot import Mesh
from render.vertex_normals import vertex_normals

MATERIAL = "rain bead"

MATERIALS: Mapping[str, Material] = {
    MATERIAL: Material(color=(1.0, 1.0, 1.0), roughness=0.05, clearcoat=1.0)
}
"""Of beads, whose colours are those of their vertices."""

LEAST_RAIN = 0.15
"""Rain from which beads stand."""

ROUGHEST, LEAST_COAT = 0.4, 0.4
"""Roughness up to which a wet skin holds beads, and weight of the film of water from which."""

RADII = 0.0009, 0.0042
"""Of beads [m]: many small, few large."""

MOST_LARGER = 4.0
"""Greatest factor on their radii: larger drops would run off."""

SMALL = 2.8
"""Power of the chance by which there are more small beads than large ones."""

SHARE = 0.08
"""Share of a skin that is below beads in heavy rain."""

LEAST_PIXELS = 0.9
"""Mean radius in the frame, in pixels, below which beads are not seen."""

MOST = 3_000
"""Beads of a film."""

HEIGHT, SUNK = 0.62, 0.12
"""Height of a bead, and how far its rim lies below the skin, in its radius."""

AROUND = 6
"""Vertices of each of the two rings of a dome, besides its top."""

RINGS = ((0.72, 0.72), (1.0, 0.0))
"""Radius and height of the rings, in those of the bead."""

TILTS = (0.0, 0.62, 0.93)
"""Sine of the angle between the normals of the top and of the rings and that of the skin."""

BRIGHTER, DARKER = 2.4, 0.5
"""Factors on the colour of the skin on the low and on the high side of a bead."""

PALE = 0.05
"""Grey light that a bead gathers besides."""


@dataclass(frozen=True, eq=False)
class Film:
    """The beads on one part: N domes.

    Attributes:
        name: of the mesh.
        owner: name of the performer.
        corners: (N, 3) vertices of the part around each bead.
        shares: (N, 3) of these corners at its middle.
        radius: (N,) [m].
        colors: (N, M, 3) linear.
        faces: (F, 3) of all beads.
    """

    name: str
    owner: str
    corners: NDArray[np.int64]
    shares: Array
    radius: Array
    colors: NDArray[np.float32]
    faces: NDArray[np.uint32]

    def at(self, skin: NDArray[np.float32], faces: NDArray[np.uint32], alive: bool) -> Mesh:
        """Return the beads on a skin (V, 3) [m] with faces (F, 3)."""
        normals = vertex_normals(skin, faces).astype(float)
        middle = (skin.astype(float)[self.corners] * self.shares[..., None]).sum(axis=1)
        up = normalized((normals[self.corners] * self.shares[..., None]).sum(axis=1))
        out = _outward(up)
        r = self.radius[:, None, None]
        places = [middle[:, None] + HEIGHT * r * up[:, None]]
        bent = [up[:, None]]
        for (wide, high), tilt in zip(RINGS, TILTS[1:], strict=True):
            lift = HEIGHT * high - (SUNK if high == 0.0 else 0.0)
            places.append(middle[:, None] + r * (wide * out + lift * up[:, None]))
            bent.append(tilt * out + np.sqrt(1.0 - tilt * tilt) * up[:, None])
        placed = np.concatenate(places, axis=1)
        if not alive:
            # Hidden by collapsing, because the topology of a build is constant.
            placed = np.zeros_like(placed)
        return Mesh(
            *(self.name, placed.reshape(-1, 3).astype(np.float32), self.faces, MATERIAL),
            colors=self.colors.reshape(-1, 3),
            normals=np.concatenate(bent, axis=1).reshape(-1, 3).astype(np.float32),
            owner=self.owner,
        )


@dataclass(frozen=True, eq=False)
class Beads:
    """The beads of a film, by number of the visible part."""

    take: Take
    films: Mapping[int, Film]

    @staticmethod
    def of(
        take: Take,
        materials: Mapping[str, Material],
        finest: NDArray[np.float64],
        rain: float,
        seed: int,
        size: float = 1.0,
    ) -> Beads | None:
        """Return the beads that rain leaves on the performers of a take, None without any.

        Args:
            take: of the film.
            materials: by name, as rain changes them.
            finest: (P,) least size of a pixel on each visible part [m].
            rain: amount, 0 to 1.
            seed: of the scene.
            size: factor on their size, where the world is seen as an insect sees it.
        """
        parts, counts = visible_parts(take), {}
        larger = float(np.clip(size, 1.0, MOST_LARGER))
        mean = larger * (RADII[0] + (RADII[1] - RADII[0]) / (SMALL + 1.0))
        share = SHARE * min(rain / 0.5, 1.0)
        for i, part in enumerate(parts):
            mesh = take.meshes[part.seen]
            is_seen = mean > LEAST_PIXELS * finest[i]
            if is_seen and holds_beads(mesh, materials[part.material], rain):
                counts[i] = share * _areas(mesh).sum() / (np.pi * 1.35 * mean * mean)
        if not counts:
            return None
        fewer = min(MOST / max(sum(counts.values()), 1.0), 1.0)
        films = {
            i: _film(take, parts[i], materials, max(int(count * fewer), 1), larger, (seed, i))
            for i, count in counts.items()
        }
        return Beads(take, films)

    def at(self, row: float, skins: Sequence[NDArray[np.float32]]) -> list[Mesh]:
        """Return the beads at a row of the take on the skins of its visible parts [m]."""
        parts, found = visible_parts(self.take), []
        for i, film in self.films.items():
            alive = parts[i].life[0] <= int(row) < parts[i].life[1]
            found.append(film.at(skins[i], self.take.meshes[parts[i].seen].faces, alive))
        return found


def holds_beads(mesh: TakeMesh, material: Material, rain: float) -> bool:
    """Whether rain stands in beads on a part, whose material is as rain changes it."""
    is_smooth = material.roughness <= ROUGHEST and material.clearcoat >= LEAST_COAT
    is_skin = material.subsurface > 0.0 or material.texture == "none"
    is_clear = material.transmission > 0.0 or material.translucency > 0.0
    return rain >= LEAST_RAIN and is_smooth and not (is_skin or is_clear or len(mesh.hair))


def _film(
    take: Take,
    part: Part,
    materials: Mapping[str, Material],
    count: int,
    larger: float,
    seed: tuple[int, ...],
) -> Film:
    """Return so many beads on a part, larger than usual by a factor."""
    mesh = take.meshes[part.seen]
    draw = np.random.default_rng((4400, *seed))
    area = _areas(mesh)
    up = _face_normals(mesh)[:, 1]
    # Drops hang below, too, but fewer.
    weight = area * np.clip(0.75 + up, 0.12, 1.0)
    face = np.sort(draw.choice(len(area), count, p=weight / weight.sum()))
    u, v = np.sqrt(draw.random(count)), draw.random(count)
    shares = np.stack([1.0 - u, u * (1.0 - v), u * v], axis=-1)
    corners = mesh.faces[face].astype(np.int64)
    radius = larger * (RADII[0] + (RADII[1] - RADII[0]) * draw.random(count) ** SMALL)
    base = skin_colors(mesh, materials[part.material], corners, shares)
    low = -_outward(_face_normals(mesh)[face])[..., 1]
    side = np.concatenate([np.zeros((count, 1)), 0.6 * low, low], axis=1)
    tone = 1.0 + np.where(side > 0.0, (BRIGHTER - 1.0) * side, (1.0 - DARKER) * side)
    colors = base[:, None] * tone[..., None] + PALE * np.maximum(side, 0.0)[..., None]
    pattern = _dome()
    faces = pattern + (2 * AROUND + 1) * np.arange(count)[:, None, None]
    return Film(
        *(f"{part.name} beads", part.performer, corners, shares, radius),
        np.minimum(colors, 1.0).astype(np.float32),
        faces.reshape(-1, 3).astype(np.uint32),
    )


def _dome() -> NDArray[np.int64]:
    """Return the faces (F, 3) of a dome: its top, the upper ring and the rim."""
    k = np.arange(AROUND)
    after = (k + 1) % AROUND
    a, b, c, d = 1 + k, 1 + after, 1 + AROUND + k, 1 + AROUND + after
    top = np.stack([np.zeros(AROUND, int), a, b], -1)
    return np.concatenate([top, np.stack([a, c, b], -1), np.stack([b, c, d], -1)])


def _outward(up: Array) -> Array:
    """Return directions (N, AROUND, 3) in the plane across normals (N, 3)."""
    other = np.where(np.abs(up[:, :1]) < 0.7, [[1.0, 0.0, 0.0]], [[0.0, 0.0, 1.0]])
    first = normalized(cross(up, other))
    second = cross(up, first)
    angle = 2.0 * np.pi * np.arange(AROUND) / AROUND
    return np.asarray(
        np.cos(angle)[:, None] * first[:, None] + np.sin(angle)[:, None] * second[:, None]
    )


def _face_normals(mesh: TakeMesh) -> Array:
    return normalized(_doubled_areas(mesh))


def _areas(mesh: TakeMesh) -> Array:
    return np.asarray(0.5 * np.linalg.norm(_doubled_areas(mesh), axis=-1))


def _doubled_areas(mesh: TakeMesh) -> Array:
    p = mesh.vertices[mesh.faces.astype(int)].astype(float)
    return cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
