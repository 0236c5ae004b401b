"""Shot builder: take and scene -> the shot of a frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from pipeline.production.camera.camera_faults import CameraFault, camera_faults
from pipeline.production.camera.clearance import VisibleGround
from pipeline.production.camera.cuts import FilmedCut, filmed_cuts, first_frames
from pipeline.production.camera.parent_nodes import camera_parents, focus_nodes
from pipeline.production.camera.pose_interpolator import PoseInterpolator
from pipeline.production.camera.visibility import Visibility
from pipeline.production.shots.carried_lamps import CarriedLamps
from pipeline.production.shots.film_tracks import FilmTracks
from pipeline.production.shots.footprint_timeline import footprint_timeline
from pipeline.production.shots.ground_mesh import ground_meshes
from pipeline.production.shots.pattern_coordinates import pattern_coordinates
from pipeline.production.shots.skinning import Skin, visible_parts
from pipeline.simulation.clock import Clock
from pipeline.simulation.node_names import NodeNames
from pipeline.simulation.take import Take
from pipeline.spec.scene import Scene
from render.config import MATERIALS, Material
from render.shot import CameraPose, Mesh, Moment, Shot


class ShotBuilder:
    """Builds the shots of one take by the materials, lights and cameras of one scene.

    Args:
        scene: of the film.
        take: of the scene; with `tracks`, only the rows of the frames that are shot are read.
        tracks: of the film, computed from the whole take by default.

    Attributes:
        tracks: of the film.

    Raises:
        SceneError: the parent of a camera or lamp, or a camera's focus, does not exist.
    """

    def __init__(self, scene: Scene, take: Take, tracks: FilmTracks | None = None) -> None:
        self.take = take
        self.film = scene.film.resolved()
        self.light = scene.light
        header = take.header
        self.clock = Clock(header.rate, header.frames, header.steps, header.samples)
        self.materials = _materials(scene, take)
        clear = frozenset(
            name for name, material in self.materials.items() if material.transmission > 0.5
        )
        self._scene, self._clear = scene, clear
        self._filmed: list[FilmedCut] | None = None
        self.tracks = tracks or self._computed_tracks()
        self._interpolator = PoseInterpolator(
            self.tracks.poses, first_frames(scene.camera, header.rate)
        )
        terrain = scene.terrain
        self._footprints = self.tracks.footprints
        raster = self._footprints.raster if self._footprints else None
        self._ground = ground_meshes(take.terrain, terrain.show_forbidden, raster)
        self._skin = Skin.of(take)
        self._parts = visible_parts(take)
        self._rests = pattern_coordinates(take, self.materials)
        self._lamps = CarriedLamps.of(scene, take)

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
        )

    def camera_faults(self) -> list[CameraFault]:
        """Return what is wrong with the cameras, by their paths and the take."""
        visibility = Visibility(self.take, VisibleGround(self.take.terrain), self._clear)
        filmed = self._filmed if self._filmed is not None else self._filmed_cuts()
        return camera_faults(visibility, self._scene.camera, filmed, self._aspect)

    @property
    def _aspect(self) -> float:
        return self.film.size[0] / self.film.size[1]

    def _computed_tracks(self) -> FilmTracks:
        """Return the tracks of the film, from all rows of its take."""
        self._filmed = self._filmed_cuts()
        texture = self.materials[self.take.terrain.material].texture
        has_footprints = self._scene.terrain.footprints
        return FilmTracks(
            tuple(pose for cut in self._filmed for pose in cut.poses),
            footprint_timeline(self.take, texture) if has_footprints else None,
        )

    def _filmed_cuts(self) -> list[FilmedCut]:
        scene, names = self._scene, NodeNames.of(self.take)
        mounts, focus = camera_parents(scene, names), focus_nodes(scene, names)
        return filmed_cuts(self.take, scene.camera, self._aspect, mounts, focus, self._clear)

    def _moment(self, frame: int, part: float) -> Moment:
        """Return the moment a fraction of a frame after its start."""
        row = self.clock.row_of_frame(frame)
        at = row + part * self.clock.samples
        vertices = self._skin.posed(self.take, at)
        meshes = list(self._ground_at(at))
        for i, piece in enumerate(self._parts):
            mesh = self.take.meshes[piece.seen]
            placed = vertices[self._skin.starts[i] : self._skin.starts[i + 1]]
            if not piece.life[0] <= row < piece.life[1]:
                # Hidden by collapsing, because the topology of a build is constant.
                placed = np.zeros_like(placed)
            rest = self._rests[i]
            meshes.append(Mesh(piece.name, placed, mesh.faces, piece.material, rest=rest))
        return Moment(
            tuple(meshes), self._interpolator.at(frame, part), self._lamps.placed(self.take, at)
        )

    def _ground_at(self, row: float) -> tuple[Mesh, ...]:
        """Return the ground with the footprints made until a row of the take."""
        near, *others = self._ground
        made = self._footprints.count(row) if self._footprints else 0
        if near.footprint_count != made:
            self._ground = replace(near, footprint_count=made), *others
        return self._ground


def _materials(scene: Scene, take: Take) -> Mapping[str, Material]:
    """Return the materials that the take names; the author's own override the presets."""
    names = {part.material for part in take.parts} | {take.terrain.material}
    own = scene.materials
    return {name: own[name] if name in own else MATERIALS[name] for name in sorted(names)}
