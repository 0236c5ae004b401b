"""Sparks and embers of fires for Dr.Jit, which only add light.

An image of a spark is as wide as the spark or the pixel, whichever is more, and fainter by their
ratio, so that nothing sparkles.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from render.airborne.picture_area import picture_area
from render.fire_streaks import fire_streaks, streak_spheres
from render.plume import Plume
from render.shot import CameraPose


@dataclass
class Sparks:
    """All sparks and embers of one moment, opaque to recordings."""

    tail: mi.Point3f
    way: mi.Vector3f
    radius: mi.Float
    radiance: mi.Color3f
    count: mi.UInt32
    area: mi.Bool

    @staticmethod
    def of(
        plumes: Sequence[Plume], time: float, camera: CameraPose, size: tuple[int, int]
    ) -> Sparks:
        """Return the sparks of fires for Dr.Jit, of one fire at least.

        Args:
            plumes: flames.
            time: since the film began [s].
            camera: that sees them.
            size: width and height of the frame [pixels].
        """
        found = [fire_streaks(plume, time) for plume in plumes]
        tail, head, radiance = (
            np.concatenate([getattr(one, name) for one in found]).astype(np.float32)
            for name in ("tail", "head", "radiance")
        )
        spheres = np.concatenate([streak_spheres(one) for one in found])
        made = Sparks(
            mi.Point3f(tail.T.copy()),
            mi.Vector3f((head - tail).T.copy()),
            mi.Float(np.concatenate([one.radius for one in found]).astype(np.float32)),
            mi.Color3f(radiance.T.copy()),
            mi.UInt32(len(tail)),
            mi.Bool(picture_area(camera, spheres, size).ravel()),
        )
        dr.make_opaque(made.tail, made.way, made.radius, made.radiance, made.count, made.area)
        return made

    def seen(self, pixels: Any, ray: Any, distance: Any, pixel_angle: Any) -> Any:
        """Return the light that sparks add, `mi.Color3f`.

        Args:
            pixels: numbers of those that rays go through.
            ray: from the camera, of unit direction.
            distance: to the surface [m].
            pixel_angle: width of a pixel [rad].
        """

        def body(i: Any, light: Any) -> Any:
            way = dr.gather(mi.Vector3f, self.way, i)
            radius = dr.gather(mi.Float, self.radius, i)
            back = ray.o - dr.gather(mi.Point3f, self.tail, i)
            # The nearest points of the ray and of the streak.
            along, ahead = dr.dot(ray.d, way), dr.dot(ray.d, back)
            bend = dr.maximum(dr.squared_norm(way) - along * along, 1e-9)
            s = dr.clip((dr.dot(back, way) - along * ahead) / bend, 0.0, 1.0)
            t = s * along - ahead
            away = dr.norm(back + ray.d * t - way * s)
            width = radius + 0.6 * pixel_angle * t
            shape = dr.maximum(1.0 - away / width, 0.0)
            shape = dr.minimum(1.6 * shape, 1.0) * (radius / width) * (0.25 + 0.75 * s)
            is_seen = (t > 0.0) & (t < distance)
            own: Any = dr.gather(mi.Color3f, self.radiance, i)
            return i + 1, light + dr.select(is_seen, shape, 0.0) * own

        # Packets of rays far from any spark end at once.
        near = dr.gather(mi.Bool, self.area, pixels)
        n = dr.width(distance)
        _, light = dr.while_loop(
            (dr.zeros(mi.UInt32, n), dr.zeros(mi.Color3f, n)),
            lambda i, light: near & (i < self.count),
            body,
            labels=("i", "light"),
        )
        return light
