"""Edging: floor, apron and border of a scene, put together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pipeline.production.edging import cords, furniture, room, stonework
from pipeline.production.edging.apron import Apron
from pipeline.production.edging.border import Border, Height
from pipeline.production.edging.edging_choice import HOUSES, EdgingChoice
from pipeline.production.edging.fence import stand_fence
from pipeline.production.edging.floor_mesh import deck_mesh, dirt, paving_mesh
from pipeline.production.edging.floor_plan import FloorPlan
from pipeline.production.edging.house import PLASTERS
from pipeline.production.edging.house_materials import AFTER_DARK, MATERIALS_OF_HOUSES
from pipeline.production.edging.joint_growth import grow_in_joints
from pipeline.production.edging.plot import Plot
from pipeline.production.edging.rooms_behind_panes import add_rooms
from pipeline.production.edging.square import furnish
from pipeline.production.edging.street import PAVEMENT, rows_of_houses, single_house
from pipeline.production.edging.weathering import add_weathering
from pipeline.production.scenery.clearings import Clearings
from pipeline.production.scenery.expansion import gathered_meshes
from pipeline.production.scenery.film_view import FilmView
from pipeline.production.scenery.placement import Placed
from pipeline.production.surroundings.land import Land
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import TerrainRecord
from render.config import MATERIALS, Lamp, Light, Material
from render.lights.sun_position import light_elevation_deg
from render.shot import Mesh

BUILT = ("iron", "dark soil", *room.BUILT)
"""Materials of what is built along floors."""


def _painted(color: str) -> Material:
    """Return the material of walls, smooth and dull."""
    values = {"color": color, "roughness": 0.95, "texture": "plaster", "texture_scale": 0.7}
    return Material.model_validate({**values, "bump": 0.12})


def _wool(color: str, second: str) -> Material:
    """Return the material of a rug, with its pile."""
    values = {"color": color, "color2": second, "roughness": 0.95, "texture": "fur"}
    return Material.model_validate({**values, "texture_scale": 0.3, "bump": 0.9})


MATERIALS_OF_ROOMS: Mapping[str, Material] = {
    "wall": _painted("#e3d7bb"),
    "wall sage": _painted("#c3cbb4"),
    "wall blue": _painted("#b9c6cf"),
    "panelling": Material.model_validate({"color": "#e2ddd0", "roughness": 0.7}),
    "rug red": _wool("#7f2f27", "#6b2722"),
    "rug cream": _wool("#cfc2a4", "#bfb092"),
    "rug blue": _wool("#2c4266", "#243755"),
    "rug green": _wool("#3c5a45", "#33503d"),
    "rug gold": _wool("#b88f45", "#a67e3a"),
}

WEATHERED = Material.model_validate(
    {
        "color": "#8d8272",
        "color2": "#6f6456",
        "roughness": 0.85,
        "texture": "wood",
        "texture_scale": 0.5,
        "bump": 0.8,
    }
)
"""Of boards that have stood in the rain for years."""

LIGHTS_ON = 2.0
"""Height of the sun below which lamps are lit under a clear sky [degrees]."""

GLOOM, LIGHTS_ON_IN_GLOOM = 0.3, 20.0
"""Rain, snow or share of overcast sky that make it gloomy, and the height of the sun below which
lamps are then lit [degrees]."""


def edging_materials(light: Light) -> Mapping[str, Material]:
    """Return the materials of what stands along floors, by name, in a light."""
    made = {
        **{name: MATERIALS[name] for name in BUILT},
        "weathered": WEATHERED,
        **MATERIALS_OF_ROOMS,
        **MATERIALS_OF_HOUSES,
        **(AFTER_DARK if _is_dark(light) else {}),
    }
    return {f"edging {name}": material for name, material in made.items()}


def _is_dark(light: Light) -> bool:
    """Return whether windows and street lamps are lit."""
    height = light_elevation_deg(light)
    if height is None or light.sun is None:
        return height is not None
    grey = max(light.weather.rain, light.weather.snow, light.sun.clouds.overcast)
    return bool(height < np.interp(grey, (0.0, GLOOM), (LIGHTS_ON, LIGHTS_ON_IN_GLOOM)))


STREET_LAMP = Lamp(brightness=11.0, temperature_k=2300.0, radius=0.1)
"""The light in a lantern, which it fills."""

LIT_LAMPS = 10
"""Number of street lamps that give light, at most."""

TREES: Mapping[str, tuple[str, ...]] = {
    "forest": ("birch", "oak", "spruce"),
    "hills": ("oak", "birch"),
    "plain": ("birch", "oak"),
    "mountains": ("spruce", "birch"),
}
"""Trees in a row, by surroundings."""

FOOT_OF_WALL = (("tall grass", 0.5, 0.8), ("fern", 1.6, 0.8), ("buttercup", 0.9, 1.0))

SHORE = (("beach grass", 0.9, 0.8), ("beach grass", 2.1, 1.1), ("stone", 2.4, 1.2))

FOOT_OF_FLOOR = (
    ("meadow grass", 0.16, 1.0),
    ("meadow grass", 0.21, 0.7),
    ("dry grass", 0.5, 0.7),
    ("daisy", 0.7, 1.0),
)

CLOSE = 0.06
"""Distance of a house from stairs that lead to its door [m]."""

AWAY = 19.0
"""Distance of houses from a yard of natural ground [m]."""

BEFORE_HOUSES = PAVEMENT + 0.25
"""Distance of the fronts of houses from the paving of a square [m]."""

SQUARE = 2.8
"""By which a square before houses is wider than the floors of gardens [m]."""

FENCED = 1.5
"""Distance of a fence or wall from a floor or from a yard of natural ground [m]."""

FOOT_OF_FENCE = (("tall grass", 0.3, 0.9), ("meadow grass", 0.35, 1.0), ("buttercup", 2.2, 1.0))

YARD = 5.0
"""Ground around the cast before houses on natural ground [m]."""

STEPPED = 0.3
"""Difference of height from which a house on natural ground stands at its highest part [m]."""

BEHIND = (("bush", 3.1, 0.85), ("tall grass", 0.8, 1.0), ("poppy", 1.5, 1.0))
"""What grows at the foot of a wall and behind one; see `Border.undergrowth`."""


@dataclass(frozen=True, eq=False)
class Setting:
    """Where a floor is, and what is known of its film.

    Attributes:
        terrain: of the take.
        land: around it.
        clearings: of the cast.
        view: of the film.
        seed: of the scene.
        detail: 1 for frames 1280 pixels wide.
        sun: unit vector towards it, None without one.
    """

    terrain: TerrainRecord
    land: Land
    clearings: Clearings | None
    view: FilmView
    seed: int
    detail: float
    sun: tuple[float, float, float] | None = None

    def border(self, low: Array, high: Array, height: Height) -> Border:
        """Return the border of a rectangle on ground of a height."""
        seen = (self.view, self.clearings, self.seed, self.detail, self.sun)
        return Border(low, high, height, *seen)


@dataclass(frozen=True, eq=False)
class Edging:
    """How a floor ends.

    Attributes:
        floor: mesh that takes the place of the terrain, None where all of that is seen.
        apron: around it, None where all of the terrain is seen.
        border: what stands along it.
        cover: (V, 4) of the terrain's vertices, what soils it, where all of that is seen.
    """

    floor: Mesh | None
    apron: Apron | None
    border: Border
    cover: NDArray[np.float32] | None = None

    @staticmethod
    def of(choice: EdgingChoice, setting: Setting, material: str) -> Edging:
        """Return the edging of a floor of a material, by its name."""
        terrain, land, clearings, seed = (
            *(setting.terrain, setting.land, setting.clearings, setting.seed),
        )
        is_paved = choice.floor == "paving"
        is_room = choice.along == "room"
        eyes = setting.view.eyes[:, [0, 2]] if is_room else None
        plan = FloorPlan.of(
            *(terrain, clearings, choice.piece, seed),
            is_broken=choice.along == "overgrown",
            around=eyes,
            wider=SQUARE if choice.along == "houses" else 0.0,
        )
        if choice.floor == "ground":
            return Edging(None, None, _on_ground(choice, setting))
        if plan is None:
            corners = terrain.vertices[:, [0, 2]]
            low, high = corners.min(axis=0), corners.max(axis=0)
            border = setting.border(low, high, lambda p: land.height(*p.T))
            cover = None
            if is_paved and clearings is not None:
                all_of_it = FloorPlan.of_all(terrain, clearings, choice.piece)
                grow_in_joints(border, all_of_it, land.field)
                cover = dirt(all_of_it, terrain.vertices.astype(np.float32), seed)
            border.undergrowth(0.06, FOOT_OF_FLOOR)
            _stand(border, choice, land, 1.1, None, terrain.vertices)
            return Edging(None, None, border, cover)
        apron = Apron(plan, is_paved and not is_room, seed)

        def height(places: Array) -> Array:
            inside = (places > plan.ground[0]).all(axis=1) & (places < plan.ground[1]).all(axis=1)
            return np.where(inside, apron.height(places), land.height(*places.T))

        border = setting.border(plan.low, plan.high, height)
        if is_room:
            room.Room(plan, border).build()
            return Edging(deck_mesh(plan, material), apron, border)
        if is_paved:
            grow_in_joints(border, plan)
            if choice.along != "overgrown":
                stonework.kerb(border, 0.09, plan.height)
        _stand(border, choice, land, 0.55, None if is_paved else plan.height)
        floor = paving_mesh(plan, material, seed) if is_paved else deck_mesh(plan, material)
        return Edging(floor, apron, border)

    @property
    def placed(self) -> tuple[Placed, ...]:
        """Plants of the edging."""
        return tuple(self.border.placed)

    def street_lamps(self, light: Light) -> tuple[Lamp, ...]:
        """Return the street lamps that are lit, those nearest to what the cameras look at."""
        if not self.border.lanterns or not _is_dark(light):
            return ()
        places = np.concatenate(self.border.lanterns)
        to_target = places[:, None] - self.border.view.targets
        order = np.argsort(np.linalg.norm(to_target, axis=-1).min(axis=1), kind="stable")
        lit = np.sort(order[:LIT_LAMPS])
        return tuple(
            STREET_LAMP.model_copy(update={"at": tuple(at)}) for at in places[lit].tolist()
        )

    @property
    def plots(self) -> tuple[Plot, ...]:
        """Built ground of the edging."""
        return tuple(self.border.plots)

    def meshes(self) -> tuple[Mesh, ...]:
        """Return what is built, and hedges."""
        border = self.border
        copies = [(one, "scenery stone") for one in border.stones]
        copies += [(one, "scenery solid") for one in border.leaves]
        grown = tuple(
            replace(mesh, name=mesh.name.replace("scenery", "edging"))
            for mesh in (gathered_meshes(copies)[0] if copies else ())
        )
        return (*grown, *(self._aged(mesh) for mesh in border.carpentry.meshes()))

    def _aged(self, mesh: Mesh) -> Mesh:
        """Return the walls of houses with traces of the weather, and panes with rooms behind."""
        fronts, seed = self.border.fronts, self.border.seed
        material = mesh.material.removeprefix("edging ")
        if not fronts:
            return mesh
        if material in PLASTERS:
            return add_weathering(mesh, fronts, seed)
        return add_rooms(mesh, fronts, seed) if material == "pane" else mesh


def _stand(
    border: Border,
    choice: EdgingChoice,
    land: Land,
    out: float,
    deck: float | None,
    steps: Array | None = None,
) -> None:
    """Let things stand along a floor.

    Args:
        border: to which they are added.
        choice: of the scene.
        land: around.
        out: distance from the floor [m].
        deck: height of a floor of boards, None for another.
        steps: (N, 3) of a floor that is not level.
    """
    if deck is not None:
        furniture.rim(border, "edging weathered", deck)
    if choice.along == "overgrown":
        return
    level = deck if deck is not None else land.level
    if choice.along in HOUSES:
        _town(border, choice.along, out, level, steps)
    if choice.along == "fence":
        _build(border, choice.along, out + 4.6, steps)
    elif choice.along in ("hedge", "house", "school"):
        _hedge(border, out, has_benches=choice.along == "hedge", deck=deck)
    elif choice.along == "wall":
        stonework.wall(border, out + 0.5, 0.75)
        border.undergrowth(out + 0.1, FOOT_OF_WALL)
        border.undergrowth(out + 1.5, BEHIND)
    elif choice.along == "railing":
        _railing(border, out, level, by_the_sea=land.kind == "sea")
    elif choice.along == "planters":
        _planters(border, out, level, on_deck=deck is not None)
    if land.kind in TREES and choice.along != "railing":
        border.trees(TREES[land.kind], out + 3.4, 4.6, 0.75)
        border.trees(TREES[land.kind], out + 11.0, 8.5, 1.0)


def _railing(border: Border, out: float, level: float, *, by_the_sea: bool) -> None:
    """Add a railing, by the sea with lanterns, palms and beach grass."""
    furniture.railing(border, level, "edging white painted metal")
    if not by_the_sea:
        return
    cords.festoon(border, level, 3.4)
    border.palms(out + 2.6, 4.6)
    border.palms(out + 7.0, 3.6, 0.55)
    border.palms(out + 14.0, 4.4, 0.8)
    border.undergrowth(out + 0.6, SHORE)


def _planters(border: Border, out: float, level: float, *, on_deck: bool) -> None:
    """Add boxes of flowers, on a deck or beside a floor, before a low hedge."""
    place = -0.45 if on_deck else out
    furniture.planters(border, place, 2.9, "edging weathered", level)
    border.hedge(out + 1.5, 0.9)
    border.undergrowth(out + 2.6, BEHIND)


def _town(border: Border, word: str, out: float, level: float, steps: Array | None) -> None:
    """Add houses around a floor, and what stands before those of a square."""
    if word != "houses":
        _build(border, word, out + 4.6, steps)
        return
    _build(border, word, BEFORE_HOUSES, steps)
    if steps is None:
        furnish(border, level)
    furniture.benches(border, -0.6, 6.5)
    stonework.wall(border, BEFORE_HOUSES, 1.3)
    border.undergrowth(BEFORE_HOUSES + 1.2, BEHIND)


def _hedge(border: Border, out: float, *, has_benches: bool, deck: float | None) -> None:
    """Add a clipped hedge with plants at its foot and behind it, and benches before it."""
    if has_benches:
        furniture.benches(border, -0.55 if deck is None else -0.7, 6.5)
    border.hedge(out + 0.6, 1.05)
    border.undergrowth(out + 0.15, FOOT_OF_WALL)
    border.undergrowth(out + 2.0, BEHIND)


def _on_ground(choice: EdgingChoice, setting: Setting) -> Border:
    """Return what is built on natural ground, around where the cast is."""
    terrain, land, clearings = setting.terrain, setting.land, setting.clearings
    flat = terrain.vertices[:, [0, 2]]
    low, high = flat.min(axis=0), flat.max(axis=0)
    if clearings is not None:
        low, high = clearings.extent + np.array([[-YARD], [YARD]])

    def height(places: Array) -> Array:
        inside = land.field.inside(*places.T)
        return np.where(inside, land.field.surface(*places.T)[0], land.height(*places.T))

    border = setting.border(low, high, height)
    steps = terrain.vertices if np.ptp(terrain.vertices[:, 1]) > STEPPED else None
    if choice.along == "wall":
        stonework.wall(border, FENCED, 0.85)
        border.undergrowth(FENCED + 0.4, FOOT_OF_FENCE)
        border.undergrowth(FENCED - 0.45, FOOT_OF_FENCE)
        # Its level top is broken by what stands behind it.
        border.undergrowth(FENCED + 1.4, BEHIND)
    else:
        _build(border, choice.along, AWAY, steps)
    return border


def _build(border: Border, word: str, out: float, steps: Array | None) -> None:
    """Add houses, or one at some distance from a floor [m], or close to one that is not level.

    A fence stands nearer.
    """
    if word == "fence":
        stand_fence(border, FENCED, "edging weathered")
        border.undergrowth(FENCED + 0.1, FOOT_OF_FENCE)
    elif word == "houses":
        rows_of_houses(border, out)
        furniture.lamps(border, out - PAVEMENT - 0.35, 8.0)
    else:
        near = CLOSE if steps is not None else out
        single_house(border, near, steps, is_school=word == "school")
