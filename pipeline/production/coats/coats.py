"""Coats: the pelts of all animals of a film, and their strands at a moment."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.production.coats.grain import pixel_sizes
from pipeline.production.coats.pelt import Pelt, grown_pelt, strand_count, undercoat
from pipeline.production.shots.skinning import Skin, visible_parts
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Part, Take
from render.config import Material
from render.shot import CameraPose, Mesh

HAIR, FEATHERS = "coat hair", "coat feathers"

MATERIALS: Mapping[str, Material] = {
    HAIR: Material(color=(1.0, 1.0, 1.0), roughness=1.0, translucency=0.35, sheen=1.0),
    FEATHERS: Material(color=(1.0, 1.0, 1.0), roughness=1.0, translucency=0.2, sheen=0.5),
}
"""Of strands, whose colours are those of their vertices. They let light through at their rims,
which are bright before a light."""

GROWING = ("fur", "plumage")
"""Textures of the materials on which a coat grows."""

MOST_STRANDS, MOST_OF_ALL = 80_000, 160_000
"""Strands of one animal and of a film. Beyond them all are fewer."""

LEAST_SHARE = 0.5
"""Share of the wanted strands below which they are wider, too: the cover stays."""


@dataclass(frozen=True, eq=False)
class Coats:
    """The pelts of a film.

    Attributes:
        take: of the film.
        parts: the visible ones.
        pelts: by number of the visible part.
        tips: of the hair at each vertex, part after part of those with a pelt.
        covers: colours (V, 4) of the skin below each pelt, see `Mesh`.
    """

    take: Take
    parts: Sequence[Part]
    pelts: Mapping[int, Pelt]
    tips: Skin
    covers: Mapping[int, NDArray[np.float32]]

    @staticmethod
    def of(
        take: Take, materials: Mapping[str, Material], finest: NDArray[np.float64], seed: int
    ) -> Coats | None:
        """Return the coats of a take, None without any that is to be seen.

        Args:
            take: of the film.
            materials: by name.
            finest: (P,) least size of a pixel on each visible part [m].
            seed: of the scene.
        """
        parts = visible_parts(take)
        wanted = _wanted(take, parts, materials, finest)
        if not wanted:
            return None
        pelts = {}
        for i, (count, width) in wanted.items():
            part = parts[i]
            material = materials[part.material]
            strands = FEATHERS if material.texture == "plumage" else HAIR
            names = (f"{part.name} coat", part.performer, strands)
            pixel = float(finest[i])
            pelts[i] = grown_pelt(
                take.meshes[part.seen], material, count, width, pixel, (seed, i), names
            )
        meshes = [take.meshes[parts[i].seen] for i in pelts]
        tips = Skin.of_meshes(take, meshes, [mesh.vertices + mesh.hair for mesh in meshes])
        covers = {
            i: undercoat(take.meshes[parts[i].seen], materials[parts[i].material]) for i in pelts
        }
        return Coats(take, parts, pelts, tips, covers)

    def at(
        self, row: float, skins: Sequence[NDArray[np.float32]], camera: CameraPose, height: int
    ) -> list[Mesh]:
        """Return the strands at a row of the take, or between two.

        Args:
            row: of the take.
            skins: (V, 3) vertices of each visible part, posed at that row [m].
            camera: whom hair faces.
            height: of the frame in pixels.
        """
        tips = self.tips.posed(self.take, row)
        eye = np.array(camera.p_WC)
        pixel = float(pixel_sizes(camera, eye[None] + camera.axes[2:], height)[0])
        found = []
        for k, (i, pelt) in enumerate(self.pelts.items()):
            own = slice(self.tips.starts[k], self.tips.starts[k + 1])
            part = self.parts[i]
            alive = part.life[0] <= int(row) < part.life[1]
            faces = self.take.meshes[part.seen].faces
            found.append(pelt.at(skins[i], tips[own], faces, eye, pixel, alive))
        return found


def _wanted(
    take: Take,
    parts: Sequence[Part],
    materials: Mapping[str, Material],
    finest: Array,
) -> dict[int, tuple[int, float]]:
    """Return the number of strands and their least width [m] by number of the part."""
    counts: dict[int, tuple[int, float]] = {}
    for i, part in enumerate(parts):
        mesh, texture = take.meshes[part.seen], materials[part.material].texture
        if len(mesh.hair) and texture in GROWING and np.isfinite(finest[i]):
            count, width = strand_count(mesh, float(finest[i]), vanes=texture == "plumage")
            if count:
                counts[i] = (count, width)
    for key in sorted({parts[i].performer for i in counts}):
        own = [i for i in counts if parts[i].performer == key]
        _thin(counts, own, MOST_STRANDS)
    _thin(counts, list(counts), MOST_OF_ALL)
    return counts


def _thin(counts: dict[int, tuple[int, float]], some: Sequence[int], most: int) -> None:
    """Make the strands of some parts fewer, so that they are at most so many."""
    share = most / max(sum(counts[i][0] for i in some), 1)
    for i in some if share < 1.0 else ():
        count, width = counts[i]
        counts[i] = max(int(count * share), 1), width * max(LEAST_SHARE / share, 1.0)
