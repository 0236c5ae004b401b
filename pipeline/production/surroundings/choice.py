"""Choice: which land suits a terrain, by its material, its kind and the light of its scene."""

from __future__ import annotations

from dataclasses import dataclass

from pipeline.spec.scene import Scene
from render.config import MATERIALS, Material

NATURAL = {
    "grass": "hills",
    "soil": "hills",
    "sand": "dunes",
    "snow": "mountains",
    "rock": "mountains",
    "gravel": "mountains",
    "mud": "plain",
    "ice": "mountains",
}
"""Surroundings by the texture of natural ground; other ground is a floor."""

LAND_MATERIALS = {"dunes": "sand"}
"""Material of the land around a floor; grass where none is given."""

DRAWN_OUT = frozenset({"stairs", "ramp", "ditches", "stones"})
"""Kinds of terrain whose edge is drawn out, because patches of them would be nonsense."""


@dataclass(frozen=True)
class Choice:
    """What surrounds a terrain.

    Attributes:
        kind: of surroundings; see `landforms`.
        joins: how the terrain meets the land; see `land.Land`.
        material: of the land near the terrain, by name.
        seed: of the land's shapes.
    """

    kind: str
    joins: str
    material: str
    seed: int

    @staticmethod
    def of(scene: Scene) -> Choice:
        """Return the choice of a scene's author, or what suits the scene."""
        terrain = scene.terrain
        is_natural = _ground(scene).texture in NATURAL
        kind: str = terrain.surroundings
        if kind == "auto":
            kind = NATURAL.get(_ground(scene).texture, "hills")
            # Indoors a floor goes on to the backdrop.
            if not is_natural and scene.light.studio is not None:
                kind = "none"
        if kind == "none":
            return Choice(kind, "drawn out", terrain.material, scene.seed)
        if not is_natural:
            return Choice(kind, "platform", LAND_MATERIALS.get(kind, "grass"), scene.seed)
        joins = "drawn out" if getattr(terrain, "kind", "") in DRAWN_OUT else "rough"
        return Choice(kind, joins, terrain.material, scene.seed)

    @property
    def materials(self) -> tuple[str, ...]:
        """Names of the materials that the land needs."""
        return (self.material, "sea") if self.kind == "sea" else (self.material,)


def _ground(scene: Scene) -> Material:
    name = scene.terrain.material
    return scene.materials[name] if name in scene.materials else MATERIALS[name]
