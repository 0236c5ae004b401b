"""Shot builder: take and scene -> the shot of a frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from functools import cached_property

import numpy as np

from pipeline.production.camera.camera_faults import CameraFault, camera_faults
from pipeline.production.camera.clearance import VisibleGround
from pipeline.production.camera.cuts import FilmedCut, cut_frames, filmed_cuts, first_frames
from pipeline.production.camera.director.director import edit_decisions
from pipeline.production.camera.director.edit_decision import EditDecision
from pipeline.production.camera.parent_nodes import camera_parents, focus_nodes
from pipeline.production.camera.pose_interpolator import PoseInterpolator
from pipeline.production.camera.visibility import Visibility
from pipeline.production.coats.beads import MATERIALS as BEAD_MATERIALS
from pipeline.production.coats.beads import Beads, holds_beads
from pipeline.production.coats.coats import MATERIALS as COAT_MATERIALS
from pipeline.production.coats.coats import Coats
from pipeline.production.coats.grain import finest_pixels
from pipeline.production.edging.edging import edging_materials
from pipeline.production.edging.edging_choice import EdgingChoice
from pipeline.production.scenery.clearings import Clearings
from pipeline.production.scenery.expansion import MATERIALS as SCENERY_MATERIALS
from pipeline.production.scenery.film_view import FilmView
from pipeline.production.scenery.hearths import Hearths
from pipeline.production.scenery.puddles import MATERIALS as PUDDLE_MATERIALS
from pipeline.production.scenery.puddles import Puddles
from pipeline.production.scenery.scatter_choice import ScatterChoice
from pipeline.production.scenery.scenery_tally import SceneryTally
from pipeline.production.shots.carried_lamps import CarriedLamps
from pipeline.production.shots.coarse_people import with_coarse_people
from pipeline.production.shots.film_tracks import FilmTracks
from pipeline.production.shots.footprint_timeline import footprint_timeline
from pipeline.production.shots.fractured_boulders import chipped, fractured
from pipeline.production.shots.ground_mesh import terrain_mesh
from pipeline.production.shots.ground_weather import ground_in_weather, wetted
from pipeline.production.shots.group_shapes import MATERIALS as GROUP_MATERIALS
from pipeline.production.shots.group_shapes import drawn
from pipeline.production.shots.laid_floor import floor_name, laid
from pipeline.production.shots.pattern_coordinates import pattern_coordinates
from pipeline.production.shots.plume_tracks import PlumeTracks, fire_lamps
from pipeline.production.shots.puff_tracks import PuffTracks
from pipeline.production.shots.skinning import Skin, visible_parts
from pipeline.production.shots.standing_scenery import StandingScenery
from pipeline.production.shots.sunken_stones import sunken
from pipeline.production.shots.title_timing import TitledFilm, require_titles, words_at
from pipeline.production.shots.wading import Wading, waders
from pipeline.production.shots.weathered_pit import weathered
from pipeline.production.surroundings.choice import NATURAL, Choice
from pipeline.production.surroundings.land import Land
from pipeline.simulation.clock import Clock
from pipeline.simulation.node_names import NodeNames
from pipeline.simulation.take import Take
from pipeline.spec.scene import Scene
from render.config import MATERIALS, Light, Material, Water
from render.development import Tone
from render.shot import CameraPose, LampPlace, Mesh, Moment, Shot
from render.water import WaterSurface


class ShotBuilder:
    """Builds the shots of one take by the materials, lights and cameras of one scene.

    Args:
        scene: of the film.
        take: of the scene; with `tracks`, only the rows of the frames that are shot are read.
        tracks: of the film, computed from the whole take by default.

    Attributes:
        scene: of the film, with the cuts of a director in place of `auto`.
        tracks: of the film.

    Raises:
        SceneError: the parent of a camera or lamp, or a camera's focus, does not exist; a title
            does not fit; or, when the first shot is made, more is scattered than memory holds.
    """

    def __init__(self, scene: Scene, take: Take, tracks: FilmTracks | None = None) -> None:
        self.take = take = drawn(take, scene)
        self.film = scene.film.resolved()
        header = take.header
        self.clock = Clock(header.rate, header.frames, header.steps, header.samples)
        require_titles(scene)
        self._titled = TitledFilm.of(scene)
        self._around = around = Choice.of(scene)
        worn = weathered(sunken(take.terrain, scene, take), scene)
        worn = chipped(worn, scene, take)
        self._drawn = fractured(worn, scene, take)
        self._land = Land.of(self._drawn, around)
        self._scatter = ScatterChoice.of(scene, around)
        self._edging = EdgingChoice.of(scene, around)
        self.materials = _materials(scene, take, around, self._scatter)
        self._puddles = self._standing_rain(scene)
        if self._puddles is not None:
            self.materials = {**self.materials, **PUDDLE_MATERIALS}
        if self._edging is not None:
            built = edging_materials(scene.light)
            self.materials = {**self.materials, **SCENERY_MATERIALS, **built}
        clear = frozenset(
            name for name, material in self.materials.items() if material.transmission > 0.5
        )
        self._clear = clear
        self._filmed: list[FilmedCut] | None = None
        decisions = tracks.cuts if tracks else self._decided_cuts(scene)
        cameras = tuple(decision.camera for decision in decisions)
        # With the cuts of a director in place of its `auto`.
        self.scene = self._scene = scene = scene.model_copy(update={"camera": cameras})
        self._plumes = PlumeTracks.of(scene, take)
        self.tracks = tracks or self._computed_tracks(decisions)
        self._interpolator = PoseInterpolator(
            self.tracks.poses, first_frames(scene.camera, header.rate)
        )
        terrain = scene.terrain
        self._footprints = self.tracks.footprints
        raster = self._footprints.raster if self._footprints else None
        self._terrain = terrain_mesh(
            self._drawn, terrain.show_forbidden, raster, smooth=not self._land.is_platform
        )
        floor = floor_name(take.terrain.material)
        self._floor = floor if floor in self.materials else None
        if self._floor is not None:
            self._terrain = replace(self._terrain, material=self._floor)
        # Once it is known how large people are in the picture.
        take = self.take = with_coarse_people(take, self.tracks.grain)
        self._skin = Skin.of(take)
        self._parts = visible_parts(take)
        self._rests = pattern_coordinates(take, self.materials)
        self._coats = self._grown_coats()
        self._covers = self._coats.covers if self._coats is not None else {}
        self._beads = self._standing_beads()
        self._lamps = CarriedLamps.of(scene, take)
        self._water = _water(scene, self._land)
        ground = self.materials[take.terrain.material]
        self._puffs = PuffTracks.of(take, ground, scene.light.weather, self._water)

    def set_tones(self, tones: tuple[Tone, ...]) -> None:
        """Expose each frame as metered."""
        self.tracks = replace(self.tracks, tones=tones)

    @cached_property
    def light(self) -> Light:
        """The light of the scene, with the lamps of fires and of the street."""
        own = self._scene.light
        lamps = (*own.lamps, *self._plumes.lamps, *self._standing.lamps)
        return own.model_copy(update={"lamps": lamps})

    @property
    def cuts(self) -> tuple[range, ...]:
        """Frames of each cut that is seen, 1-based."""
        header = self.take.header
        cuts = cut_frames(self._scene.camera, header.rate, header.frames)
        return tuple(frames for frames in cuts if frames)

    @property
    def poses(self) -> tuple[CameraPose, ...]:
        """Poses of the camera at every frame."""
        return self.tracks.poses

    def shot(self, frame: int) -> Shot:
        """Return the shot of the 1-based `frame`."""
        first, *later = (self._moment(frame, part) for part in self.film.exposures)
        return Shot(
            meshes=first.meshes,
            materials=self.materials,
            light=self.light,
            camera=first.camera,
            film=self.film,
            later=tuple(later),
            lamps=first.lamps,
            after=self._moment(frame, 1.0) if "motion" in self.film.passes else None,
            tone=self.tracks.tones[frame - 1] if self.tracks.tones else Tone(),
            time=first.time,
            water=self._water,
            plumes=first.plumes,
            puffs=first.puffs,
            scenery=self._standing.made[0],
            footprint_count=first.footprint_count,
            words=words_at(self._titled, float((frame - Fraction(1, 2)) / self.clock.rate)),
        )

    @property
    def decisions(self) -> tuple[EditDecision, ...]:
        """Cuts of the film, those of a director with their reasons."""
        return self.tracks.cuts

    def camera_faults(self) -> list[CameraFault]:
        """Return what is wrong with the cameras, by their paths and the take."""
        visibility = self._visibility
        filmed = self._filmed if self._filmed is not None else self._filmed_cuts()
        return camera_faults(visibility, self._scene.camera, filmed, self._aspect)

    def waders(self) -> list[Wading]:
        """Return who goes through the surface of the water."""
        if self._water is None:
            return []
        return waders(self.take, self._skin, self.clock, self._water.level)

    @property
    def scattered(self) -> SceneryTally | None:
        """How many plants and stones stand in the film, None where nothing is scattered."""
        return self._standing.tally if self._scatter.wanted else None

    @property
    def _aspect(self) -> float:
        return self.film.size[0] / self.film.size[1]

    @property
    def _visibility(self) -> Visibility:
        return Visibility(self.take, VisibleGround(self._land), self._clear)

    def _decided_cuts(self, scene: Scene) -> tuple[EditDecision, ...]:
        """Return the cuts of a scene, with those of a director in place of `auto`."""
        return edit_decisions(self._visibility, scene.camera, scene.light, self._aspect)

    def _computed_tracks(self, decisions: tuple[EditDecision, ...]) -> FilmTracks:
        """Return the tracks of the film, from all rows of its take."""
        self._filmed = self._filmed_cuts()
        texture = self.materials[self.take.terrain.material].texture
        has_footprints = self._scene.terrain.footprints
        poses = tuple(pose for cut in self._filmed for pose in cut.poses)
        spares = bool(self._scatter.wanted or self._edging)
        rain = self._scene.light.weather.wetness
        grows = any(
            len(mesh.hair) or holds_beads(mesh, self.materials[part.material], rain)
            for part in visible_parts(self.take)
            for mesh in [self.take.meshes[part.seen]]
        )
        height = self.film.size[1]
        return FilmTracks(
            poses,
            footprint_timeline(self.take, texture) if has_footprints else None,
            clearings=Clearings.of(self.take, self._hearths) if spares else None,
            cuts=decisions,
            grain=finest_pixels(self.take, poses, height) if grows else np.zeros(0),
        )

    def _filmed_cuts(self) -> list[FilmedCut]:
        scene, names = self._scene, NodeNames.of(self.take)
        mounts, focus = camera_parents(scene, names), focus_nodes(scene, names)
        return filmed_cuts(
            self.take, scene.camera, self._aspect, mounts, focus, self._clear, self._land
        )

    def _moment(self, frame: int, part: float) -> Moment:
        """Return the moment a fraction of a frame after its start."""
        row = self.clock.row_of_frame(frame)
        # The last frame of a take has no next one.
        at = min(row + part * self.clock.samples, len(self.take.positions) - 1)
        vertices = self._skin.posed(self.take, at)
        meshes = [*self._trodden_at(at), *self._standing.glowing]
        for i, piece in enumerate(self._parts):
            mesh = self.take.meshes[piece.seen]
            placed = vertices[self._skin.starts[i] : self._skin.starts[i + 1]]
            if piece.performer in self._plumes.performers:
                continue
            if not piece.life[0] <= row < piece.life[1]:
                # Hidden by collapsing, because the topology of a build is constant.
                placed = np.zeros_like(placed)
            rest = self._rests[i]
            meshes.append(
                Mesh(
                    *(piece.name, placed, mesh.faces, piece.material),
                    rest=rest,
                    owner=piece.performer,
                    cover=self._covers.get(i, mesh.paint if len(mesh.paint) else None),
                )
            )
        camera = self._interpolator.at(frame, part)
        if self._coats is not None:
            skins = np.split(vertices, self._skin.starts[1:-1])
            meshes += self._coats.at(at, skins, camera, self.film.size[1])
        if self._beads is not None:
            meshes += self._beads.at(at, np.split(vertices, self._skin.starts[1:-1]))
        puddles = self._standing.puddle_surface
        if puddles is not None:
            meshes.append(puddles.at(self._time(frame, part)))
        time, plumes = self._time(frame, part), self._plumes.placed(self.take, at)
        lamps = (
            *self._lamps.placed(self.take, at),
            *fire_lamps(plumes, time),
            *(LampPlace(lamp.at) for lamp in self._standing.lamps),
        )
        puffs = self._puffs.at(float((frame - 1 + part) / self.clock.rate))
        made = self._footprints.count(at) if self._footprints else 0
        return Moment(tuple(meshes), camera, lamps, time, plumes, puffs, made)

    def _grown_coats(self) -> Coats | None:
        """Return the hair and feathers of the animals, None without any."""
        if not len(self.tracks.grain):
            return None
        coats = Coats.of(self.take, self.materials, self.tracks.grain, self._scene.seed)
        if coats is not None:
            self.materials = {**self.materials, **COAT_MATERIALS}
        return coats

    def _standing_beads(self) -> Beads | None:
        """Return the drops on smooth skins that are out in the rain, None without any."""
        if not len(self.tracks.grain):
            return None
        rain, seed = self._scene.light.weather.wetness, self._scene.seed
        size = self._scene.terrain.scatter.size
        beads = Beads.of(self.take, self.materials, self.tracks.grain, rain, seed, size)
        if beads is not None:
            self.materials = {**self.materials, **BEAD_MATERIALS}
        return beads

    def _time(self, frame: int, part: float) -> float:
        """Return the time since the film began [s], 0 where light, water and air stand still."""
        waves = self._water is not None and self._water.waves
        changes = self._scene.light.changes or waves or self._plumes.sources
        return float((frame - 1 + part) / self.clock.rate) if changes else 0.0

    def _trodden_at(self, row: float) -> tuple[Mesh, ...]:
        """Return the plants that performers tread on, as they are bent at a row of the take."""
        _, trodden = self._standing.made
        return trodden.at(row) if trodden else ()

    @cached_property
    def _standing(self) -> StandingScenery:
        """What stands still, made when the first shot needs it."""
        return StandingScenery(
            *(self._scene, self.take, self._drawn, self._land, self._around, self._scatter),
            *(self._edging, self.materials, self._terrain, self._floor, self._puddles),
            *(self._water, FilmView.of(self.poses, self._aspect), self.tracks.clearings),
            *(self._hearths, self.film.size[0]),
        )

    @cached_property
    def _hearths(self) -> Hearths:
        return Hearths.of(self._scene, self._land.field)

    def _standing_rain(self, scene: Scene) -> Puddles | None:
        """Return the puddles on natural ground or paving, None without any."""
        own = self.materials[self.take.terrain.material]
        is_floor = own.texture not in NATURAL
        # Water runs off between boards, and indoors no rain falls on the floor.
        if is_floor != self._land.is_platform or own.texture == "wood":
            return None
        return Puddles.of(scene.seed, scene.light.weather, self._land.field, is_floor=is_floor)


def _water(scene: Scene, land: Land) -> WaterSurface | None:
    """Return the author's water, or that of a sea around the terrain."""
    water = scene.terrain.water
    if water is None and land.sea_level is not None:
        water = Water.model_validate({"preset": "sea", "level": land.sea_level})
    return None if water is None else WaterSurface.of(water)


def _materials(
    scene: Scene, take: Take, around: Choice, scatter: ScatterChoice
) -> Mapping[str, Material]:
    """Return the materials of take, land and scenery; the author's own override the presets."""
    names = {part.material for part in take.parts} | {take.terrain.material, *around.materials}
    own = {**GROUP_MATERIALS, **scene.materials}
    made = {name: own[name] if name in own else MATERIALS[name] for name in sorted(names)}
    dry, weather = made[take.terrain.material], scene.light.weather
    ground = {take.terrain.material, around.material}
    for name, material in made.items():
        change = ground_in_weather if name in ground else wetted
        made[name] = change(material, weather)
    floor = laid(dry, outdoors=around.joins == "platform")
    # Deep snow hides the joints.
    if floor is not None and made[take.terrain.material].texture == dry.texture:
        made[floor_name(take.terrain.material)] = ground_in_weather(floor, weather)
    return {**made, **SCENERY_MATERIALS} if scatter.wanted else made
