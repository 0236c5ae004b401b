"""A shot as a Mitsuba scene: built once, then updated in place from frame to frame.

Building anew for each frame would leak (mitsuba3, issue 1890) and take far longer than the frame.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from render.airborne.airborne_pass import (
    PLUME_RAYS,
    PUFF_RAYS,
    AirborneExposure,
    AirbornePass,
    airborne_area,
    airborne_contents,
)
from render.camera_sweep import CameraSweep
from render.color import linear
from render.config import FullFilm, Material
from render.errors import ShotError
from render.frame import LensBlur, LightLayers
from render.freed_memory import return_freed_memory
from render.lens_blur import lens_blur
from render.lights.cloud_shadows import cloud_shadows
from render.lights.environment_emitters import surroundings
from render.lights.environment_map import sky_width
from render.lights.lamps import fixed_places, lamp_emitters, move_lamps
from render.meshes import (
    MeshGroup,
    build_mesh,
    group_meshes,
    has_moved,
    update_footprints,
    update_vertices,
)
from render.passes.pass_tracer import PassExposure, PassTracer
from render.shot import CameraPose, LampPlace, Mesh, Moment, Shot
from render.surfaces.material_bsdf import extra_bounces
from render.surfaces.texture_mapping import set_pixel_width
from render.tracing.camera_rays import CameraView
from render.tracing.cloud_shade import CloudShade
from render.tracing.emitter_choice import CANDIDATES
from render.tracing.haze import Air
from render.tracing.path_tracer import PathTracer
from render.tracing.scene_pair import ScenePair
from render.tracing.sky_relief import SkyRelief
from render.tracing.tracer import Accumulator, Tracer
from render.tracing.water import Water
from render.tracing.wavefront import Wavefront

MEASURED_WIDTH, MEASURED_DEPTH, MEASURED_PASSES = 160, 3, 4
"""Of the picture that the exposure is metered by: its width [pixels], longest path, and passes."""

_NEUTRAL_GROUND = (0.30, 0.26, 0.21)
"""Linear colour of the ground beyond a scene without ground."""


class MitsubaScene:
    """The Mitsuba scene of all shots with the same `Shot.build`.

    Attributes:
        build: digest of what it was built for.
        scene: of Mitsuba, with all that may move and all lights.
        sensor: the camera in it.
        air: the haze, None without any.
        depth: longest light path, in segments; glass takes more than the film asks for.
        path_tracer_reason: why Mitsuba's own path tracer is in use, or empty.
        has_soft_lights: whether sampled lights are so wide or many that their shadows are noisy.
    """

    def __init__(self, shot: Shot) -> None:
        self.build = shot.build
        self._film = shot.film.resolved()
        return_freed_memory()
        self._groups: tuple[MeshGroup, ...] = group_meshes(shot.meshes, shot.materials)
        meshes: dict[str, Any] = {
            f"mesh{i}": build_mesh(group, shot.meshes, shot.materials[group.material])
            for i, group in enumerate(self._groups)
        }
        self._light, self._lamps = shot.light, shot.light.lamps
        # The update below moves them, so that a new scene equals one that was updated.
        self._lamp_places: tuple[LampPlace, ...] = ()
        around = surroundings(shot.light, _ground_color(shot), sky_width(self._film.size[0]))
        self.air = Air.of(around.haze) if around.haze is not None else None
        self._relief = SkyRelief.of(around.slopes) if dr.is_jit_v(mi.Float) else None
        self._sky_time: float | None = None
        self.scene = mi.load_dict(
            {
                "type": "scene",
                **meshes,
                **around.emitters,
                **lamp_emitters(self._lamps, shot.lamps or fixed_places(self._lamps)),
                "camera": _camera(self._film, shot.camera),
            }
        )
        # Mitsuba has a copy of the maps.
        self._around = replace(around, emitters={})
        return_freed_memory()
        still_groups = _still_groups(shot)
        self._n_still = len(still_groups)
        still = {
            f"still{i}": build_mesh(group, shot.scenery, shot.materials[group.material])
            for i, group in enumerate(still_groups)
        }
        self._traced: Any = self.scene
        if still:
            self._traced = ScenePair(self.scene, mi.load_dict({"type": "scene", **still}))
            # Mitsuba's own path tracer takes one scene, and so does a GPU.
            if wavefront_limitation(self._traced) or _holds_one_scene(str(mi.variant())):
                self.scene = self._traced = self._traced.joined()
        self._water_surface = shot.water
        self._water = None if shot.water is None else Water.of(shot.water, around.downwelling)
        if self._water is not None and shot.water is not None and around.key is not None:
            if shot.camera.p_WC[1] < shot.water.level:
                self._water.show_shafts(around.key.direction)
        self.sensor = self.scene.sensors()[0]
        self.has_soft_lights = self.scene.environment().sampling_weight() > 0.0
        # What is left of the noise of many lamps is denoised as that of wide ones is.
        self.has_soft_lights |= len(self._lamps) > CANDIDATES
        self.depth = self._film.depth + extra_bounces(shot.materials.values())
        self._tracer, self.path_tracer_reason = choose_tracer(
            *(self._traced, self._film, self.depth, self.air, self._water, self._relief)
        )
        self._passes = self._pass_tracer(shot, still_groups) if self._film.passes else None
        self._values = mi.traverse(self.scene)
        is_pair = isinstance(self._traced, ScenePair)
        self._still_values = mi.traverse(self._traced.still) if is_pair else self._values
        self._meshes: tuple[Mesh, ...] = shot.meshes
        keys = [shape for shape in self.scene.shapes() if shape.id() == "key"]
        self._key = keys[0].emitter() if keys else None
        self.update(shot.moments[0])
        return_freed_memory()

    def update(self, moment: Moment) -> None:
        """Move meshes, lamps and camera to a moment of a shot with the same build."""
        for i, group in enumerate(self._groups):
            if has_moved(group, self._meshes, moment.meshes):
                update_vertices(self._values, f"mesh{i}.", group, moment.meshes)
            update_footprints(self._values, f"mesh{i}.", moment.footprint_count)
        self._meshes = moment.meshes
        places = moment.lamps or fixed_places(self._lamps)
        if places != self._lamp_places:
            move_lamps(self._values, self._lamps, places)
            self._lamp_places = places
        _update_camera(self._values, moment.camera, self._film)
        if self._around.drifting is not None and self._sky_time != moment.time:
            self.scene.environment().set_time(moment.time)
            self._sky_time = moment.time
        set_pixel_width(self._values, moment.camera.fov_deg, self._film.size[1])
        for i in range(self._n_still):
            update_footprints(self._still_values, f"still{i}.", moment.footprint_count)
        self._values.update()
        if self._still_values is not self._values:
            # No vertices: the acceleration structure stays.
            set_pixel_width(self._still_values, moment.camera.fov_deg, self._film.size[1])
            self._still_values.update()
        self._shade(self._tracer, moment.time)
        self._flow(moment, self._film.size[1])
        self._tracer.scene_changed()

    def _shade(self, tracer: Tracer, time: float) -> None:
        """Lay the shadows of clouds at a time, which only our own tracer knows."""
        if not isinstance(tracer, Wavefront) or self._key is None or self._around.key is None:
            return
        shadows = cloud_shadows(self._light, self._around.key.direction, time)
        tracer.shade = None if shadows is None else CloudShade.of(shadows, self._key)

    def _flow(self, moment: Moment, height: int) -> None:
        """Move the waves, as they are seen in a frame so many pixels high."""
        if self._water is not None and self._water_surface is not None:
            self._water.set_time(self._water_surface, moment.time)
            self._water.set_pixel_width(moment.camera.fov_deg, height)

    def trace(self, seed: int, passes: range, total: int) -> LightLayers:
        """Return what the camera sees while nothing moves; see `Accumulator.add_passes`."""
        return self._tracer.trace(self.sensor, seed, passes, total)

    def measure(self, moment: Moment, seed: int) -> LightLayers:
        """Return what the camera sees in a small picture, whatever the size of the film.

        Args:
            moment: of a shot with the same build.
            seed: of the samples.
        """
        width, height = self._film.size
        size = MEASURED_WIDTH, 2 * max(round(MEASURED_WIDTH * height / width / 2), 1)
        self.update(moment)
        set_pixel_width(self._values, moment.camera.fov_deg, size[1])
        self._values.update()
        self._flow(moment, size[1])
        self._tracer.scene_changed()
        tracer: Tracer = self._tracer
        if isinstance(tracer, Wavefront):
            tracer = Wavefront(
                *(self._traced, size, MEASURED_DEPTH),
                half=True,
                air=self.air,
                water=self._water,
                relief=self._relief,
            )
            self._shade(tracer, moment.time)
        layers = tracer.trace(self.sensor, seed, range(MEASURED_PASSES), MEASURED_PASSES)
        # The next frame sets its own.
        self.update(moment)
        return layers

    def view(self, sweep: CameraSweep | None = None) -> CameraView:
        """Return the camera as it is now, and as it moves on."""
        return CameraView(self.sensor, sweep)

    def accumulator(self, *, has_airborne: bool = False) -> Accumulator:
        """Return an empty accumulator for the sensor of this scene.

        Args:
            has_airborne: whether `add_airborne` will be called with its distances.
        """
        return self._tracer.accumulator(PUFF_RAYS if has_airborne else 0)

    def pass_exposure(self, shot: Shot) -> PassExposure | None:
        """Return the passes of a shot before its first moment, None if the film asks for none."""
        return self._passes.begin(shot) if self._passes else None

    def lens_blur(self, pose: CameraPose) -> LensBlur | None:
        """Return where a picture is out of focus, None where all is in focus."""
        if pose.lens is None or not dr.is_jit_v(mi.Float):
            return None
        return lens_blur(self._traced, self.sensor, pose, self._film.size)

    def airborne_exposure(self, shot: Shot) -> AirborneExposure | None:
        """Return what is in the air before the first moment of a shot, None where it is empty."""
        area = airborne_area(shot.moments, self._film.size, self._light.weather)
        if not area.any() or not dr.is_jit_v(mi.Float):
            return None
        return AirbornePass(self._traced, area, self.air).begin()

    def add_airborne(
        self,
        exposure: AirborneExposure,
        moment: Moment,
        k: int,
        count: int,
        distances: Sequence[Any] = (),
    ) -> None:
        """Add what is in the air at the k-th of `count` moments of an exposure.

        Args:
            exposure: of this scene.
            moment: of a shot.
            k: number of the moment.
            count: of moments.
            distances: `Accumulator.distances`.
        """
        around = self._around
        contents = airborne_contents(
            moment, self._light.weather, around.key, around.ambient, self._film.size
        )
        # Rain is sharp by itself; the edges of what is before flames are not.
        rays = PLUME_RAYS if contents.plumes else PUFF_RAYS if contents.puffs else 1
        rays = -(-rays // count)
        seen = self.sensor, moment.camera.fov_deg, contents
        if contents.lone_puffs is not None and len(distances) == count * rays:
            exposure.add(*seen, 0, 1, distances)
            return
        for ray in range(k * rays, (k + 1) * rays):
            exposure.add(*seen, ray, count * rays)

    def _pass_tracer(self, shot: Shot, still: tuple[MeshGroup, ...]) -> PassTracer:
        variant = str(mi.variant())
        if not variant.startswith(("llvm", "cuda")):
            raise ShotError(f"{variant} has no passes; render with a variant of llvm or cuda")
        pair = self._traced
        scenes = [pair.moving, pair.still] if isinstance(pair, ScenePair) else [pair]
        shapes = {shape.id(): shape for scene in scenes for shape in scene.shapes()}
        return PassTracer(pair, shapes, shot, self._groups, still)

    def whole(self) -> Any:
        """Return one scene of Mitsuba, `mi.Scene`, with all that is seen now, for a reference."""
        return self._traced.joined() if isinstance(self._traced, ScenePair) else self.scene


def _holds_one_scene(variant: str) -> bool:
    """Return whether a kernel of a variant traces rays through one scene alone.

    OptiX takes one acceleration structure a kernel; Dr.Jit leaves out the rays through a second
    one, with a line on standard error alone. GPUs rebuild quickly, so they need no second one.
    """
    return variant.startswith("cuda")


def _still_groups(shot: Shot) -> tuple[MeshGroup, ...]:
    """Return the scenery of a shot, merged.

    Raises:
        ShotError: one glows, or its arrays do not fit.
    """
    groups = group_meshes(shot.scenery, shot.materials)
    for group in groups:
        if shot.materials[group.material].glow > 0.0:
            raise ShotError(f"scenery of material {group.material!r} glows, which it cannot")
    return groups


def choose_tracer(
    scene: Any,
    film: FullFilm,
    depth: int,
    air: Air | None = None,
    water: Water | None = None,
    relief: SkyRelief | None = None,
) -> tuple[Tracer, str]:
    """Return the tracer for a scene, and why it is not the wavefront tracer, or empty.

    Args:
        scene: of Mitsuba, or a `ScenePair`.
        film: size of the frame, and of its indirect light.
        depth: longest path, in segments.
        air: haze before the camera, None without any.
        water: of the scene, None without any.
        relief: of surfaces in the light of the sky, None to do without.

    Raises:
        ShotError: there is water, which Mitsuba's own path tracer knows nothing of.
    """
    reason = wavefront_limitation(scene)
    if reason and water is not None:
        raise ShotError(f"there is water, but {reason}; render with a variant of llvm or cuda")
    if reason:
        return PathTracer(scene, depth, film.rays, air), reason
    half = film.soft_light == "half"
    wavefront = Wavefront(scene, film.size, depth, half=half, air=air, water=water, relief=relief)
    return wavefront, ""


def wavefront_limitation(scene: Any) -> str:
    """Return why the wavefront tracer does not support a scene or pair, or empty."""
    variant = str(mi.variant())
    if not variant.startswith(("llvm", "cuda")):
        return f"{variant} has no wavefronts"
    if "spectral" in variant or "polarized" in variant:
        return f"{variant} carries more than three colours"
    scenes = [scene.moving, scene.still] if isinstance(scene, ScenePair) else [scene]
    if any(shape.is_medium_transition() for part in scenes for shape in part.shapes()):
        return "a surface encloses a medium"
    if any(_lets_rays_pass(shape.bsdf()) for part in scenes for shape in part.shapes()):
        # Its shadow rays would take a leaf cut out of a square for the square.
        return "a surface has an opacity mask"
    return ""


def _lets_rays_pass(bsdf: Any) -> bool:
    """Return whether rays go straight through parts of a surface, as with an opacity mask."""
    return bsdf is not None and mi.has_flag(bsdf.flags(), mi.BSDFFlags.Null)


def _camera(film: FullFilm, pose: CameraPose) -> dict[str, Any]:
    width, height = film.size
    lens: dict[str, Any] = {"type": "perspective"}
    if pose.lens is not None:
        lens = {
            "type": "thinlens",
            "aperture_radius": pose.lens.radius,
            "focus_distance": pose.lens.focus,
        }
    return {
        **lens,
        "fov": 35.0,
        "fov_axis": "x",
        "near_clip": 0.01,
        "far_clip": 1e4,
        "film": {
            "type": "hdrfilm",
            "width": width,
            "height": height,
            "pixel_format": "rgb",
            "component_format": "float32",
            # Of the filters only the box adds up in one order, whatever the threads do.
            "rfilter": {"type": "box"},
        },
        "sampler": {"type": "multijitter", "sample_count": film.samples},
    }


def _update_camera(values: Any, pose: CameraPose, film: FullFilm) -> None:
    sight = np.subtract(pose.p_WT, pose.p_WC)
    if not np.isfinite([*sight, *pose.up]).all() or np.linalg.norm(sight) == 0:
        raise ShotError(f"the camera at {pose.p_WC} cannot look at {pose.p_WT}")
    T = mi.ScalarTransform4f().look_at(list(pose.p_WC), list(pose.p_WT), pose.top.tolist())
    width, height = film.size
    half = math.tan(math.radians(pose.fov_deg) / 2) * width / height
    values["camera.to_world"] = type(values["camera.to_world"])(T)
    if pose.lens is not None:
        for name, value in (
            ("aperture_radius", pose.lens.radius),
            ("focus_distance", pose.lens.focus),
        ):
            values[f"camera.{name}"] = type(values[f"camera.{name}"])(value)
    values["camera.x_fov"] = type(values["camera.x_fov"])(math.degrees(2 * math.atan(half)))


def _ground_color(shot: Shot) -> tuple[float, float, float]:
    """Return the linear colour of the ground: that of the first patterned ground material."""
    for mesh in (*shot.meshes, *shot.scenery):
        material: Material = shot.materials[mesh.material]
        if mesh.uv is None or material.texture == "none" or material.color2 is None:
            continue
        r, g, b = (linear(material.color) + linear(material.color2)) / 2
        return float(r), float(g), float(b)
    return _NEUTRAL_GROUND
