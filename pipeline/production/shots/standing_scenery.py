"""Standing scenery: terrain, land, edging, plants and stones of a film, which never move.

Made once, when the first shot needs them, and the same objects in all shots.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from pipeline.errors import Problem, SceneError
from pipeline.production.edging.apron import Apron
from pipeline.production.edging.edging import Edging, Setting
from pipeline.production.edging.edging_choice import EdgingChoice
from pipeline.production.edging.floor_mesh import soiled_wall
from pipeline.production.scenery.clearings import Clearings
from pipeline.production.scenery.film_view import FilmView
from pipeline.production.scenery.ground_surface import GroundSurface
from pipeline.production.scenery.growth import Growth
from pipeline.production.scenery.hearth_stones import hearth_stones
from pipeline.production.scenery.hearths import Hearths
from pipeline.production.scenery.placement import Placed
from pipeline.production.scenery.puddles import Puddles, PuddleSurface
from pipeline.production.scenery.scatter_choice import ScatterChoice
from pipeline.production.scenery.scenery import (
    TooManyTriangles,
    placed_scenery,
    scenery_detail,
    scenery_meshes,
)
from pipeline.production.scenery.scenery_tally import SceneryTally
from pipeline.production.scenery.track import Track
from pipeline.production.scenery.treads import Treads
from pipeline.production.scenery.trodden_cover import TroddenCover
from pipeline.production.shots.ground_mesh import land_detail, mean_color, surrounding_meshes
from pipeline.production.shots.ground_weather import frosted, snowed_cover
from pipeline.production.shots.near_relief import with_relief
from pipeline.production.surroundings.choice import Choice
from pipeline.production.surroundings.land import Land
from pipeline.production.surroundings.land_mesh import vertices_around
from pipeline.simulation.take import Take, TerrainRecord
from pipeline.spec.scene import Scene
from render.config import Lamp, Material
from render.lights.sun_position import sun_direction
from render.shot import Mesh
from render.water import WaterSurface

DRY_SOIL = 0.05
"""Least part of the mean linear colour from which soil is that of dry land."""

NO_SHADOWS = 0.55
"""Share of overcast sky from which nothing throws a shadow that is noticed."""


@dataclass(frozen=True, eq=False)
class StandingScenery:
    """What stands still in a film, and what is made of it.

    Attributes:
        scene: of the film.
        take: of the scene.
        drawn: its terrain as it is shown.
        land: around that.
        around: what the author chose for the land.
        scatter: what is scattered.
        edging: how a laid floor ends, None for natural ground.
        materials: by name.
        terrain: its mesh.
        floor: name of the material of a laid floor, None without one.
        puddles: of the rain, None without any.
        water: over the ground, None without any.
        view: of the cameras of the film.
        clearings: where performers are, None where nothing is scattered.
        hearths: of its fires.
        width: of the frame in pixels.
    """

    scene: Scene
    take: Take
    drawn: TerrainRecord
    land: Land
    around: Choice
    scatter: ScatterChoice
    edging: EdgingChoice | None
    materials: Mapping[str, Material]
    terrain: Mesh
    floor: str | None
    puddles: Puddles | None
    water: WaterSurface | None
    view: FilmView
    clearings: Clearings | None
    hearths: Hearths
    width: int

    @property
    def tally(self) -> SceneryTally | None:
        """How many plants and stones are scattered, None where there are none."""
        return self._all[2]

    @cached_property
    def made(self) -> tuple[tuple[Mesh, ...], TroddenCover | None]:
        """Terrain, land, plants and stones, made when the first shot needs them.

        What stands still and gives no light, as one object for all shots, and what performers
        tread on.
        """
        meshes, trodden, _ = self._all
        return tuple(mesh for mesh in meshes if not self._glows(mesh)), trodden

    @cached_property
    def glowing(self) -> tuple[Mesh, ...]:
        """What stands still and gives light, such as windows at night."""
        return tuple(mesh for mesh in self._all[0] if self._glows(mesh))

    @cached_property
    def lamps(self) -> tuple[Lamp, ...]:
        """Street lamps that give light."""
        return () if self._edge is None else self._edge.street_lamps(self.scene.light)

    def _glows(self, mesh: Mesh) -> bool:
        return mesh.material in self.materials and self.materials[mesh.material].glow > 0.0

    @cached_property
    def _all(self) -> tuple[tuple[Mesh, ...], TroddenCover | None, SceneryTally | None]:
        width, weather = self.width, self.scene.light.weather
        meshes = surrounding_meshes(self.drawn, self.around, self.materials, width)
        land = tuple(snowed_cover(mesh, weather) for mesh in meshes)
        if self.floor is not None:
            # The floor's walls, and where a floor goes on to a backdrop.
            land = tuple(
                replace(mesh, material=self.floor)
                if mesh.material == self.take.terrain.material
                else mesh
                for mesh in land
            )
        treads = Treads.of(self.take)
        edging = self._edge
        base = self.terrain
        if edging is not None:
            land = (land[0], *edging.meshes()) if edging.apron else (*land, *edging.meshes())
        if edging is not None and edging.cover is not None:
            base = replace(base, cover=edging.cover)
            land = tuple(soiled_wall(mesh) if mesh.name == "edge" else mesh for mesh in land)
        if edging is not None and edging.floor is not None and edging.apron is not None:
            base = replace(edging.floor, footprints=base.footprints)
            land = (*land, snowed_cover(edging.apron.mesh(self.around.material), weather))
        material = self.materials[self.take.terrain.material]
        near = with_relief(
            *(base, material, self.view, treads, scenery_detail(width)), self.puddles
        )
        ground = (near, *land)
        if not self.scatter.wanted and (edging is None or not edging.placed):
            return ground, None, None
        ground = tuple(self._worn(mesh) for mesh in ground)
        every = self._plants(land[0], edging)
        detail = scenery_detail(width)
        still, trodden = scenery_meshes(every, treads, weather.ground_wind, detail)
        if trodden:
            trodden = trodden.dressed(lambda mesh: frosted(mesh, weather))
        seen = (*ground, *(frosted(mesh, weather) for mesh in still))
        return seen, trodden, SceneryTally.of(every, detail)

    @cached_property
    def _edge(self) -> Edging | None:
        """Return the edging of the floor."""
        if self.edging is None:
            return None
        detail = scenery_detail(self.width)
        sun = self.scene.light.sun
        is_bright = sun is not None and sun.clouds.overcast < NO_SHADOWS
        setting = Setting(
            *(self.take.terrain, self.land, self.clearings, self.view),
            *(self.scene.seed, detail, sun_direction(sun) if sun and is_bright else None),
        )
        return Edging.of(self.edging, setting, self.terrain.material)

    @cached_property
    def _growth(self) -> Growth:
        """Where plants grow, and where the ground is bare."""
        clearings, seed = self.clearings, self.scene.seed
        own = self.materials[self.take.terrain.material]
        is_meadow = own.texture == "grass" and not self.land.is_platform
        ahead = self.view.ahead[0, [0, 2]]
        ahead = ahead / max(float(np.hypot(*ahead)), 1e-9)
        track = Track.of(clearings, ahead, seed) if is_meadow else None
        is_dry = own.texture == "soil" and min(mean_color(own)) > DRY_SOIL
        return Growth(seed, clearings, self.puddles, track, is_dry, self.hearths)

    def _worn(self, mesh: Mesh) -> Mesh:
        """Return ground with the bare soil on it."""
        if mesh.uv is None or mesh.material not in self.materials:
            return mesh
        middle = self.view.targets[:, [0, 2]].mean(axis=0)
        material = self.materials[mesh.material]
        return replace(mesh, wear=self._growth.wear(material, self.scene.light.weather, middle))

    def ground_surface(self, horizon: Mesh, apron: Apron | None = None) -> GroundSurface:
        """Return what plants and stones stand on, with the mesh of the land to the horizon."""
        terrain, around = (
            mean_color(self.materials[name])
            for name in (self.take.terrain.material, self.around.material)
        )
        columns = vertices_around(land_detail(self.width))
        level = None if self.water is None else self.water.level
        return GroundSurface(self.land, horizon, terrain, around, columns, level, apron)

    def _plants(self, horizon: Mesh, edging: Edging | None) -> list[Placed]:
        """Return the plants and stones over terrain and land."""
        ground = self.ground_surface(horizon, edging.apron if edging else None)
        rings = hearth_stones(self.hearths, ground, self.view)
        also = (*(edging.placed if edging else ()), *([] if rings is None else [rings]))
        try:
            return placed_scenery(
                *(ground, self.view, self.clearings, self.scatter),
                *(self._growth, scenery_detail(self.width)),
                also=also,
                plots=edging.plots if edging else (),
            )
        except TooManyTriangles as error:
            problem = Problem("terrain.scatter", str(error))
            raise SceneError([self.scene.source_map.with_location(problem)]) from error

    @cached_property
    def puddle_surface(self) -> PuddleSurface | None:
        """What the cameras see of the puddles, None without any."""
        if self.puddles is None:
            return None
        return self.puddles.surface(self.view)
