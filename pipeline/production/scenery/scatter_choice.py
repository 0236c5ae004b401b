"""Scatter choice: which species a scene's author wants, or what suits the ground."""

from __future__ import annotations

from dataclasses import dataclass, replace

from pipeline.production.scenery.placement import Wanted
from pipeline.production.scenery.species import KINDS
from pipeline.production.surroundings.choice import NATURAL, Choice
from pipeline.spec.scene import Scene
from pipeline.spec.terrain.scatter import SCATTER_PRESETS, ScatteredSpecies

BY_MATERIAL = {"dry soil": "steppe", "dark soil": "pasture"}
"""Presets of ground materials by name."""

BY_TEXTURE = {
    "grass": "meadow",
    "moss": "moss",
    "soil": "steppe",
    "sand": "dunes",
    "snow": "tundra",
    "rock": "scree",
    "gravel": "scree",
    "mud": "wetland",
    "ice": "none",
}
"""Presets of natural ground by its texture."""

WATERSIDE = (
    Wanted("stone", 2.6, 2.4, where="shore"),
    Wanted("stone", 7.0, 0.9, where="shore"),
    Wanted("reeds", 0.9, 0.42, where="shore"),
    Wanted("sedge", 0.8, 1.2, where="shore"),
    Wanted("stone", 1.2, 1.6, where="wet"),
    Wanted("pebbles", 1.2, where="wet"),
    Wanted("boulder", 1.5, where="wet"),
    Wanted("water weed", 1.0, where="wet"),
)
"""What grows and lies at the edges of water and below it."""

OF_FLOORS = frozenset({"pavement", "room"})
"""Presets that lie on floors; all others lie on the land around a floor."""


@dataclass(frozen=True)
class ScatterChoice:
    """What is scattered over a scene's ground.

    Attributes:
        fitted: species whose cover is thinned out to fit the budget.
        asked: species with densities of the author's own, which is kept.
        factor: on the budget, as the author's factor on densities.
    """

    fitted: tuple[Wanted, ...]
    asked: tuple[Wanted, ...]
    factor: float = 1.0

    @staticmethod
    def of(scene: Scene, around: Choice) -> ScatterChoice:
        """Return the choice of a scene's author, or what suits the scene."""
        scatter = scene.terrain.scatter
        ground = scene.terrain.material
        own = _suiting(scene, ground)
        land = _suiting(scene, around.material)
        if around.kind == "none" and scene.light.studio is not None:
            own, land = "none", "none"
        elif around.joins == "platform" and scene.terrain.edging != "room":
            # Out of doors leaves and grit blow over a floor.
            own = "pavement"
        if around.kind == "sea":
            own, land = (("beach" if name == "dunes" else name) for name in (own, land))
        if scatter.preset != "auto":
            is_of_floor = scatter.preset in OF_FLOORS
            if scatter.preset == "none":
                own, land = "none", "none"
            elif around.joins == "platform":
                own, land = (scatter.preset, land) if is_of_floor else (own, scatter.preset)
            else:
                own, land = scatter.preset, scatter.preset
        fitted = _of_presets(own, land, scatter.density, scatter.size)
        if fitted and (scene.terrain.water is not None or around.kind == "sea"):
            waterside = (_resized(one, scatter.size) for one in WATERSIDE)
            fitted = (*fitted, *waterside)
        asked = tuple(_asked(one) for one in scatter.species)
        if is_drowned(scene):
            asked = tuple(replace(one, where="wet") for one in asked)
        return ScatterChoice(fitted, asked, max(scatter.density, 1.0))

    @property
    def wanted(self) -> tuple[Wanted, ...]:
        """All species."""
        return (*self.fitted, *self.asked)


def is_drowned(scene: Scene) -> bool:
    """Return whether water stands over all of the terrain, as about the height of it tells."""
    terrain = scene.terrain
    if terrain.water is None or not hasattr(terrain, "height"):
        return False
    return float(terrain.water.level) > float(terrain.height)


def _suiting(scene: Scene, name: str) -> str:
    """Return the preset that suits a ground material; none suits a floor."""
    texture = scene.material(name).texture
    if texture not in NATURAL:
        return "none"
    return BY_MATERIAL.get(name, BY_TEXTURE.get(texture, "none"))


def _of_presets(own: str, land: str, density: float, size: float) -> tuple[Wanted, ...]:
    """Return the species of the presets of terrain and land."""
    presets = (own,) if own == land else (own, land)
    return tuple(
        _resized(Wanted(name, f * density, on_terrain=preset == own, on_land=preset == land), size)
        for preset in presets
        for name, f in SCATTER_PRESETS[preset].items()
        if f * density > 0
    )


def _resized(one: Wanted, size: float) -> Wanted:
    """Return a species at another size, as many as cover the same share of the ground."""
    return replace(one, density=one.density / size**2, size=one.size * size)


def _asked(one: ScatteredSpecies) -> Wanted:
    usual = KINDS[one.species].density
    if one.density is None:
        return Wanted(one.species, 1.0, one.size, cover=one.cover)
    return Wanted(one.species, one.density / usual, one.size, even=True, cover=one.cover)
