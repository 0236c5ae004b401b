"""A shot in Mitsuba: built once, then moved in place from frame to frame.

Building anew for each frame would leak (mitsuba3, issue 1890) and cost far more
than the frame.
"""

from __future__ import annotations

import math
from typing import Any

import mitsuba as mi
import numpy as np

from render.color import linear
from render.config import FullFilm, Material
from render.errors import ShotError
from render.exposure import Exposure
from render.lights.emitters import emitters
from render.lights.lamps import fixed_places, lamp_emitters, move_lamps
from render.meshes import Group, built, groups, imprint, moved, update
from render.shot import CameraPose, LampPlace, Mesh, Moment, Shot
from render.surfaces.bsdf_plugins import set_pixel
from render.surfaces.material_bsdf import light_paths
from render.tracer import tracer
from render.tracing.tracer import Plate

_NEUTRAL_GROUND = (0.30, 0.26, 0.21)


class Stage:
    """The Mitsuba scene of all shots that share a `Shot.build`.

    Attributes:
        build: the digest of what it was built for.
        scene: of Mitsuba.
        sensor: the camera in it.
        depth: longest light path, in segments; glass takes more than the film asks for.
        handed_over: why Mitsuba's own path tracer is at work, or nothing.
        wide: whether lights that surfaces ask for are so wide that their shadows are soft.
    """

    def __init__(self, shot: Shot) -> None:
        self.build = shot.build
        self._film = shot.film.resolved()
        self._groups: tuple[Group, ...] = groups(shot.meshes, shot.materials)
        parts: dict[str, Any] = {
            f"mesh{i}": built(group, shot.meshes, shot.materials[group.material])
            for i, group in enumerate(self._groups)
        }
        self._lamps = shot.light.lamps
        # Moved there once more below, so that a fresh build equals one that was moved.
        self._shining: tuple[LampPlace, ...] = ()
        self.scene = mi.load_dict(
            {
                "type": "scene",
                **parts,
                **emitters(shot.light, _ground(shot)),
                **lamp_emitters(self._lamps, shot.lamps or fixed_places(self._lamps)),
                "camera": _camera(self._film, shot.camera),
            }
        )
        self.sensor = self.scene.sensors()[0]
        self.wide = self.scene.environment().sampling_weight() > 0.0
        self.depth = self._film.depth + light_paths(shot.materials.values())
        self._tracer, self.handed_over = tracer(self.scene, self._film, self.depth)
        self._values = mi.traverse(self.scene)
        self._shown: tuple[Mesh, ...] = shot.meshes
        self.move(shot.moments[0])

    def move(self, moment: Moment) -> None:
        """Move meshes, lamps and camera to where they stand at a moment of a shot of one build."""
        for i, group in enumerate(self._groups):
            if moved(group, self._shown, moment.meshes):
                update(self._values, f"mesh{i}.", group, moment.meshes)
            imprint(self._values, f"mesh{i}.", group, moment.meshes)
        self._shown = moment.meshes
        shining = moment.lamps or fixed_places(self._lamps)
        if shining != self._shining:
            move_lamps(self._values, self._lamps, shining)
            self._shining = shining
        _aim(self._values, moment.camera, self._film)
        set_pixel(self._values, moment.camera.fov_deg, self._film.size[1])
        self._values.update()
        self._tracer.moved()

    def expose(self, seed: int, passes: range, of: int) -> Exposure:
        """Return what the camera sees while nothing moves; see `Plate.expose`."""
        return self._tracer.expose(self.sensor, seed, passes, of)

    def plate(self) -> Plate:
        """Return a plate that the sensor of this stage may be exposed on."""
        return self._tracer.plate()


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


def _aim(values: Any, pose: CameraPose, film: FullFilm) -> None:
    sight = np.subtract(pose.p_WT, pose.p_WC)
    if not np.isfinite([*sight, *pose.up]).all() or np.linalg.norm(sight) == 0:
        raise ShotError(f"the camera at {pose.p_WC} cannot look at {pose.p_WT}")
    up = np.asarray(pose.up, float)
    if np.linalg.norm(np.cross(sight, up)) < 1e-6 * np.linalg.norm(sight):
        # Looking straight up or down: let the top of the picture be -Z, as on a map.
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


def _ground(shot: Shot) -> tuple[float, float, float]:
    """Return the linear colour of the ground: that of the first material laid as ground."""
    for mesh in shot.meshes:
        words: Material = shot.materials[mesh.material]
        if mesh.uv is not None and words.texture != "none" and words.color2 is not None:
            r, g, b = (linear(words.color) + linear(words.color2)) / 2
            return float(r), float(g), float(b)
    return _NEUTRAL_GROUND
