"""Choice: which land suits a terrain, by its material, its kind and the light of its scene."""

from __future__ import annotations

from dataclasses import dataclass

from pipeline.spec.scene import Scene

NATURAL = {
    "grass": "hills",
    "moss": "hills",
    "soil": "hills",
    "sand": "dunes",
    "snow": "mountains",
    "rock": "mountains",
    "gravel": "mountains",
    "mud": "plain",
    "ice": "mountains",
}
"""Surroundings by the texture of natural ground; other ground is a floor."""

LAND_MATERIALS = {"dunes": "sand", "sea": "pale sand"}
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
        water_level: height of the author's water [m], None without any.
    """

    kind: str
    joins: str
    material: str
    seed: int
    water_level: float | None = None

    @staticmethod
    def of(scene: Scene) -> Choice:
        """Return the choice of a scene's author, or what suits the scene."""
        terrain = scene.terrain
        is_natural = scene.material(scene.terrain.material).texture in NATURAL
        kind: str = terrain.surroundings
        if kind == "auto":
            kind = NATURAL.get(scene.material(scene.terrain.material).texture, "hills")
            # Indoors a floor goes on to the backdrop.
            if not is_natural and scene.light.studio is not None:
                kind = "none"
        level = None if terrain.water is None else terrain.water.level
        if kind == "none":
            return Choice(kind, "drawn out", terrain.material, scene.seed, level)
        if not is_natural:
            land = LAND_MATERIALS.get(kind, "grass")
            return Choice(kind, "platform", land, scene.seed, level)
        joins = "drawn out" if getattr(terrain, "kind", "") in DRAWN_OUT else "rough"
        return Choice(kind, joins, terrain.material, scene.seed, level)

    @property
    def materials(self) -> tuple[str, ...]:
        """Names of the materials that the land needs."""
        return (self.material,)
