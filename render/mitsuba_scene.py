"""A shot as a Mitsuba scene: built once, then updated in place from frame to frame.

Building anew for each frame would leak (mitsuba3, issue 1890) and take far longer than the frame.
"""

from __future__ import annotations

import math
from typing import Any

import mitsuba as mi
import numpy as np

from render.color import linear
from render.config import FullFilm, Material
from render.errors import ShotError
from render.frame import LightLayers
from render.lights.environment_emitters import emitters
from render.lights.lamps import fixed_places, lamp_emitters, move_lamps
from render.meshes import (
    MeshGroup,
    build_mesh,
    group_meshes,
    has_moved,
    update_footprints,
    update_vertices,
)
from render.shot import CameraPose, LampPlace, Mesh, Moment, Shot
from render.surfaces.material_bsdf import extra_bounces
from render.surfaces.texture_mapping import set_pixel_width
from render.tracing.path_tracer import PathTracer
from render.tracing.tracer import Accumulator, Tracer
from render.tracing.wavefront import Wavefront

_NEUTRAL_GROUND = (0.30, 0.26, 0.21)
"""Linear colour of the ground beyond a scene without ground."""


class MitsubaScene:
    """The Mitsuba scene of all shots with the same `Shot.build`.

    Attributes:
        build: digest of what it was built for.
        scene: of Mitsuba.
        sensor: the camera in it.
        depth: longest light path, in segments; glass takes more than the film asks for.
        path_tracer_reason: why Mitsuba's own path tracer is in use, or empty.
        has_soft_lights: whether sampled lights are so wide that their shadows are soft.
    """

    def __init__(self, shot: Shot) -> None:
        self.build = shot.build
        self._film = shot.film.resolved()
        self._groups: tuple[MeshGroup, ...] = group_meshes(shot.meshes, shot.materials)
        meshes: dict[str, Any] = {
            f"mesh{i}": build_mesh(group, shot.meshes, shot.materials[group.material])
            for i, group in enumerate(self._groups)
        }
        self._lamps = shot.light.lamps
        # The update below moves them, so that a new scene equals one that was updated.
        self._lamp_places: tuple[LampPlace, ...] = ()
        self.scene = mi.load_dict(
            {
                "type": "scene",
                **meshes,
                **emitters(shot.light, _ground_color(shot)),
                **lamp_emitters(self._lamps, shot.lamps or fixed_places(self._lamps)),
                "camera": _camera(self._film, shot.camera),
            }
        )
        self.sensor = self.scene.sensors()[0]
        self.has_soft_lights = self.scene.environment().sampling_weight() > 0.0
        self.depth = self._film.depth + extra_bounces(shot.materials.values())
        self._tracer, self.path_tracer_reason = choose_tracer(self.scene, self._film, self.depth)
        self._values = mi.traverse(self.scene)
        self._meshes: tuple[Mesh, ...] = shot.meshes
        self.update(shot.moments[0])

    def update(self, moment: Moment) -> None:
        """Move meshes, lamps and camera to a moment of a shot with the same build."""
        for i, group in enumerate(self._groups):
            if has_moved(group, self._meshes, moment.meshes):
                update_vertices(self._values, f"mesh{i}.", group, moment.meshes)
            update_footprints(self._values, f"mesh{i}.", group, moment.meshes)
        self._meshes = moment.meshes
        places = moment.lamps or fixed_places(self._lamps)
        if places != self._lamp_places:
            move_lamps(self._values, self._lamps, places)
            self._lamp_places = places
        _update_camera(self._values, moment.camera, self._film)
        set_pixel_width(self._values, moment.camera.fov_deg, self._film.size[1])
        self._values.update()
        self._tracer.scene_changed()

    def trace(self, seed: int, passes: range, total: int) -> LightLayers:
        """Return what the camera sees while nothing moves; see `Accumulator.add_passes`."""
        return self._tracer.trace(self.sensor, seed, passes, total)

    def accumulator(self) -> Accumulator:
        """Return an empty accumulator for the sensor of this scene."""
        return self._tracer.accumulator()


def choose_tracer(scene: Any, film: FullFilm, depth: int) -> tuple[Tracer, str]:
    """Return the tracer for a scene, and why it is not the wavefront tracer, or empty.

    Args:
        scene: of Mitsuba.
        film: size of the frame, and of its indirect light.
        depth: longest path, in segments.
    """
    reason = wavefront_limitation(scene)
    if reason:
        return PathTracer(scene, depth, film.rays), reason
    return Wavefront(scene, film.size, depth, half=film.soft_light == "half"), ""


def wavefront_limitation(scene: Any) -> str:
    """Return why the wavefront tracer does not support a scene, or empty."""
    variant = str(mi.variant())
    if not variant.startswith(("llvm", "cuda")):
        return f"{variant} has no wavefronts"
    if "spectral" in variant or "polarized" in variant:
        return f"{variant} carries more than three colours"
    if any(shape.is_medium_transition() for shape in scene.shapes()):
        return "a surface encloses a medium"
    return ""


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
    up = np.asarray(pose.up, float)
    if np.linalg.norm(np.cross(sight, up)) < 1e-6 * np.linalg.norm(sight):
        # Looking straight up or down, the top of the frame is -Z, as on a map.
        up = np.array([0.0, 0.0, -1.0])
    T = mi.ScalarTransform4f().look_at(list(pose.p_WC), list(pose.p_WT), up.tolist())
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
    for mesh in shot.meshes:
        material: Material = shot.materials[mesh.material]
        if mesh.uv is None or material.texture == "none" or material.color2 is None:
            continue
        r, g, b = (linear(material.color) + linear(material.color2)) / 2
        return float(r), float(g), float(b)
    return _NEUTRAL_GROUND
