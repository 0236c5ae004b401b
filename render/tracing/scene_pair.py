"""Scene pair: a scene that moves and one that stands still, traced as one.

Embree rebuilds all of a scene's acceleration structures when one vertex moves, and with a million
triangles of grass that would take longer than the rest of a frame. So what stands still over a
film has a scene of its own, which is never updated, and each ray takes the nearer hit of both.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi


@dataclass
class ScenePair:
    """Two scenes with the methods of one that tracers call.

    Attributes:
        moving: the scene, `mi.Scene`, with all emitters; it may be updated.
        still: a scene, `mi.Scene`, without emitters that is never updated.
    """

    moving: Any
    still: Any

    def ray_intersect_preliminary(
        self, ray: Any, coherent: bool = False, active: Any = True
    ) -> Any:
        """Return the nearer hit of both scenes."""
        hit = self.moving.ray_intersect_preliminary(ray, coherent=coherent, active=active)
        shorter = mi.Ray3f(ray)
        shorter.maxt = dr.minimum(ray.maxt, hit.t)
        near = self.still.ray_intersect_preliminary(shorter, coherent=coherent, active=active)
        return dr.select(near.is_valid(), near, hit)

    def first_hit(self, ray: Any, held: Any, coherent: bool = False) -> tuple[Any, Any]:
        """Return the rays that meet the nearer surface, and their hits.

        Args:
            ray: to what stands still.
            held: to what moves; close to the others.
            coherent: whether neighbouring rays are close to each other.
        """
        hit = self.moving.ray_intersect_preliminary(held, coherent=coherent)
        shorter = mi.Ray3f(ray)
        shorter.maxt = hit.t
        near = self.still.ray_intersect_preliminary(shorter, coherent=coherent)
        is_still = near.is_valid() | ~hit.is_valid()
        origin, way = dr.select(is_still, ray.o, held.o), dr.select(is_still, ray.d, held.d)
        return mi.Ray3f(origin, way), dr.select(is_still, near, hit)

    def ray_intersect(self, ray: Any, ray_flags: Any, coherent: bool = False) -> Any:
        """Return the surface at the nearer hit."""
        hit = self.ray_intersect_preliminary(ray, coherent)
        return hit.compute_surface_interaction(ray, ray_flags)

    def ray_test(self, ray: Any, coherent: bool, active: Any) -> Any:
        """Return whether a surface of either scene is met."""
        hit = self.moving.ray_test(ray, coherent, active)
        return hit | self.still.ray_test(ray, coherent, active & ~hit)

    def sample_emitter_direction(self, *args: Any) -> Any:
        """Return a direction to an emitter; see `mi.Scene`."""
        return self.moving.sample_emitter_direction(*args)

    def pdf_emitter_direction(self, *args: Any) -> Any:
        """Return the density of sampling a direction to an emitter; see `mi.Scene`."""
        return self.moving.pdf_emitter_direction(*args)

    def environment(self) -> Any:
        """Return the emitter around both scenes, or None."""
        return self.moving.environment()

    def joined(self) -> Any:
        """Return a new scene, `mi.Scene`, of all that both hold."""
        lights = [light for light in self.moving.emitters() if light.get_shape() is None]
        parts = [*self.moving.shapes(), *self.still.shapes(), *lights, *self.moving.sensors()]
        return mi.load_dict({"type": "scene", **{part.id(): part for part in parts}})


def emitters_of(scene: Any) -> Any:
    """Return the scene, `mi.Scene`, that has the emitters of a scene or pair."""
    return scene.moving if isinstance(scene, ScenePair) else scene
