"""Puffs of dust and spray for Dr.Jit.

Each is a flat Gaussian cloud, whose depth along a ray up to the surface has a closed form; noise
where the ray is nearest to its middle makes it ragged.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from render.airborne.plumes import PlumeLight
from render.lights.lattice_noise import noise3
from render.plume import PUFF_REACH, Puff

_FLATNESS = 1.5
"""Width of a puff, in heights."""
_FORWARD = 1.6
"""Light that dust scatters of the key light, relative to what it would scatter to all sides."""
_AROUND = 1.25
"""Light from all sides, with what is scattered more than once, relative to that scattered once."""


@dataclass
class Puffs:
    """All puffs of one moment, opaque to recordings.

    Attributes:
        place: middles [m].
        radius: [m].
        depth: optical depths through their middles.
        color: of what they scatter, with the light on them.
        seed: of their noise.
        count: of puffs.
    """

    place: mi.Point3f
    radius: mi.Float
    depth: mi.Float
    color: mi.Color3f
    seed: mi.Float
    count: mi.UInt32

    @staticmethod
    def of(puffs: Sequence[Puff], light: PlumeLight) -> Puffs:
        """Return puffs for Dr.Jit, at least one."""
        lit = light.key * (_FORWARD / (4 * np.pi)) + _AROUND * light.ambient
        colors = np.array([puff.color for puff in puffs]) * lit
        made = Puffs(
            mi.Point3f(np.array([puff.p_WP for puff in puffs], np.float32).T.copy()),
            mi.Float(np.array([puff.radius for puff in puffs], np.float32)),
            mi.Float(np.array([puff.depth for puff in puffs], np.float32)),
            mi.Color3f(colors.astype(np.float32).T.copy()),
            mi.Float(np.array([float(puff.seed % 977) for puff in puffs], np.float32)),
            mi.UInt32(len(puffs)),
        )
        dr.make_opaque(made.place, made.radius, made.depth, made.color, made.seed, made.count)
        return made

    def seen(self, ray: Any, distances: Sequence[Any]) -> tuple[Any, Any]:
        """Return the share of light that passes, `mi.Float`, and the light added, `mi.Color3f`.

        Args:
            ray: from the camera.
            distances: to surfaces that end it in different parts of a pixel [m].
        """

        def body(i: Any, depth: Any, color: Any) -> Any:
            center = dr.gather(mi.Point3f, self.place, i)
            radius = dr.gather(mi.Float, self.radius, i)
            # In a space where it is round; lengths along the ray stay as they are.
            stretch = mi.Vector3f(1.0, _FLATNESS, 1.0)
            way = (center - ray.o) * stretch
            d = ray.d * stretch
            scale = dr.dot(d, d)
            t = dr.dot(way, d) / scale
            nearest = way - d * t
            out = dr.dot(nearest, nearest) / (radius * radius)
            is_near = (out < PUFF_REACH * PUFF_REACH) & (t > 0.0)

            def thickened(depth: Any, color: Any) -> Any:
                # Of the whole depth, what lies before the surfaces.
                ends = [dr.erf((end - t) * dr.sqrt(scale) / radius) for end in distances]
                part = 0.5 + (0.5 / len(ends)) * sum(ends[1:], ends[0])
                q = (ray(t) - center) / (0.42 * radius)
                salt = dr.gather(mi.Float, self.seed, i)
                ragged = 0.65 * noise3(q.x + salt, q.y, q.z) + 0.35 * noise3(
                    2.3 * q.x, 2.3 * q.y + salt, 2.3 * q.z
                )
                edge = dr.clip(1.0 - out / (PUFF_REACH * PUFF_REACH), 0.0, 1.0)
                shape = dr.exp(-out) * edge * dr.clip(3.2 * ragged - 0.9, 0.0, 1.8)
                here = dr.gather(mi.Float, self.depth, i) * part * shape
                own: Any = dr.gather(mi.Color3f, self.color, i)
                return depth + here, color + own * here

            depth, color = dr.if_stmt(
                (depth, color),
                is_near,
                thickened,
                lambda depth, color: (depth, color),
                rv_labels=("depth", "color"),
            )
            return i + 1, depth, color

        n = dr.width(distances[0])
        _, depth, color = dr.while_loop(
            (dr.zeros(mi.UInt32, n), dr.zeros(mi.Float, n), dr.zeros(mi.Color3f, n)),
            lambda i, depth, color: i < self.count,
            body,
            labels=("i", "depth", "color"),
        )
        passed: Any = dr.exp(-depth)
        return passed, color * ((1.0 - passed) / dr.maximum(depth, 1e-6))
