"""Edging: floor, apron and border of a scene, put together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pipeline.production.edging import room
from pipeline.production.edging.apron import Apron
from pipeline.production.edging.border import Border
from pipeline.production.edging.edging_choice import HOUSES, EdgingChoice
from pipeline.production.edging.fence import stand_fence
from pipeline.production.edging.floor_mesh import deck_mesh, dirt, paving_mesh
from pipeline.production.edging.floor_plan import FloorPlan
from pipeline.production.edging.house import MATERIALS_OF_HOUSES
from pipeline.production.edging.joint_growth import grow_in_joints
from pipeline.production.edging.plot import Plot
from pipeline.production.edging.street import row_of_houses, single_house
from pipeline.production.scenery.clearings import Clearings
from pipeline.production.scenery.expansion import gathered_meshes
from pipeline.production.scenery.film_view import FilmView
from pipeline.production.scenery.placement import Placed
from pipeline.production.surroundings.land import Land
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import TerrainRecord
from render.config import MATERIALS, Material
from render.shot import Mesh

BUILT = ("iron", "dark soil", *room.BUILT)
"""Materials of what is built along floors."""

WALL = Material.model_validate(
    {
        "color": "#c9c3a4",
        "color2": "#c3bc9b",
        "roughness": 0.95,
        "texture": "plaster",
        "texture_scale": 1.0,
        "bump": 0.6,
    }
)
"""Of the walls of rooms."""

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

MATERIALS_OF_EDGING: Mapping[str, Material] = {
    **{f"edging {name}": MATERIALS[name] for name in BUILT},
    "edging weathered": WEATHERED,
    "edging wall": WALL,
    **{f"edging {name}": made for name, made in MATERIALS_OF_HOUSES.items()},
}

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

AWAY = 15.0
"""Distance of houses from a yard of natural ground [m]."""

FENCED = 1.5
"""Distance of a fence or wall from a floor or from a yard of natural ground [m]."""

FOOT_OF_FENCE = (("tall grass", 0.3, 0.9), ("meadow grass", 0.35, 1.0), ("buttercup", 2.2, 1.0))

YARD = 5.0
"""Ground around the cast before houses on natural ground [m]."""

STEPPED = 0.3
"""Difference of height from which a house on natural ground stands at its highest part [m]."""

BEHIND = (("bush", 4.1, 0.8), ("tall grass", 0.8, 1.0), ("poppy", 1.5, 1.0))
"""What grows at the foot of a wall and behind one; see `Border.undergrowth`."""


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
    def of(
        choice: EdgingChoice,
        terrain: TerrainRecord,
        land: Land,
        clearings: Clearings | None,
        view: FilmView,
        seed: int,
        detail: float,
        material: str,
        sun: tuple[float, float, float] | None = None,
    ) -> Edging:
        """Return the edging of a floor.

        Args:
            choice: of the scene.
            terrain: of the take.
            land: around it.
            clearings: of the cast.
            view: of the film.
            seed: of the scene.
            detail: 1 for frames 1280 pixels wide.
            material: of the floor, by name.
            sun: unit vector towards it, None without one.
        """
        is_paved = choice.floor == "paving"
        is_room = choice.along == "room"
        eyes = view.eyes[:, [0, 2]] if is_room else None
        plan = FloorPlan.of(
            *(terrain, clearings, choice.piece, seed),
            is_broken=is_paved and not is_room,
            around=eyes,
        )
        if choice.floor == "ground":
            return Edging(
                None, None, _on_ground(choice, terrain, land, clearings, view, seed, detail, sun)
            )
        if plan is None:
            corners = terrain.vertices[:, [0, 2]]
            low, high = corners.min(axis=0), corners.max(axis=0)
            border = Border(
                low, high, lambda p: land.height(*p.T), view, clearings, seed, detail, sun
            )
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

        border = Border(plan.low, plan.high, height, view, clearings, seed, detail, sun)
        if is_room:
            room.Room(plan, border).build()
            return Edging(deck_mesh(plan, material), apron, border)
        if is_paved:
            grow_in_joints(border, plan)
        _stand(border, choice, land, 0.55, None if is_paved else plan.height)
        floor = paving_mesh(plan, material, seed) if is_paved else deck_mesh(plan, material)
        return Edging(floor, apron, border)

    @property
    def placed(self) -> tuple[Placed, ...]:
        """Plants of the edging."""
        return tuple(self.border.placed)

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
        return (*grown, *border.carpentry.meshes())


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
        border.rim("edging weathered", deck)
    if choice.along == "overgrown":
        return
    level = deck if deck is not None else land.level
    if choice.along in ("fence", *HOUSES):
        _build(border, choice.along, out + 4.6, steps)
    if choice.along in ("hedge", *HOUSES):
        _hedge(border, out, has_benches=choice.along not in ("house", "school"), deck=deck)
    elif choice.along == "wall":
        border.wall(out + 0.5, 0.75)
        border.undergrowth(out + 0.1, FOOT_OF_WALL)
        border.undergrowth(out + 1.5, BEHIND)
    elif choice.along == "railing":
        border.railing(level, "edging white painted metal")
        if land.kind == "sea":
            border.festoon(level, 3.4)
            border.palms(out + 2.6, 4.6)
            border.palms(out + 7.0, 3.6, 0.55)
            border.palms(out + 14.0, 4.4, 0.8)
            border.undergrowth(out + 0.6, SHORE)
    elif choice.along == "planters":
        border.planters(-0.45 if deck is not None else out, 2.9, "edging weathered", level)
        border.hedge(out + 1.5, 0.9)
        border.undergrowth(out + 2.6, BEHIND)
    if land.kind in TREES and choice.along != "railing":
        border.trees(TREES[land.kind], out + 3.4, 4.6, 0.75)
        border.trees(TREES[land.kind], out + 11.0, 8.5, 1.0)


def _hedge(border: Border, out: float, *, has_benches: bool, deck: float | None) -> None:
    """Add a clipped hedge with plants at its foot and behind it, and benches before it."""
    if has_benches:
        border.benches(-0.55 if deck is None else -0.7, 6.5)
    border.hedge(out + 0.6, 1.05)
    border.undergrowth(out + 0.15, FOOT_OF_WALL)
    border.undergrowth(out + 2.0, BEHIND)


def _on_ground(
    choice: EdgingChoice,
    terrain: TerrainRecord,
    land: Land,
    clearings: Clearings | None,
    view: FilmView,
    seed: int,
    detail: float,
    sun: tuple[float, float, float] | None,
) -> Border:
    """Return what is built on natural ground, around where the cast is."""
    flat = terrain.vertices[:, [0, 2]]
    low, high = flat.min(axis=0), flat.max(axis=0)
    if clearings is not None:
        low, high = clearings.extent + np.array([[-YARD], [YARD]])

    def height(places: Array) -> Array:
        inside = land.field.inside(*places.T)
        return np.where(inside, land.field.surface(*places.T)[0], land.height(*places.T))

    border = Border(low, high, height, view, clearings, seed, detail, sun)
    steps = terrain.vertices if np.ptp(terrain.vertices[:, 1]) > STEPPED else None
    if choice.along == "wall":
        border.wall(FENCED, 0.85)
        border.undergrowth(FENCED + 0.4, FOOT_OF_FENCE)
        border.undergrowth(FENCED - 0.45, FOOT_OF_FENCE)
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
        row_of_houses(border, out)
        border.lamps(out - 3.2, 9.0)
        border.trees(("oak", "birch"), out - 3.3, 8.0, 0.5)
    else:
        near = CLOSE if steps is not None else out
        single_house(border, near, steps, is_school=word == "school")
