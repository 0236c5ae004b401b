"""What the ground's material costs: nested textures, blends and bumps against one look.

Run: python benchmarks/ground.py
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any, cast

import numpy as np

from render.backend import choose

SIZE = (1280, 720)
ROUNDS = 9


def main() -> None:
    """Print milliseconds a sample of every pixel, and ratios."""
    backend = choose()
    if backend.variant.startswith("scalar"):
        sys.exit("the scalar variant has nested textures only")
    backend.activate()
    import mitsuba as mi

    from render.config import material
    from render.surfaces.material_bsdf import material_bsdf
    from render.surfaces.mitsuba_bsdf import opaque_bsdf, patterned_bsdf, rgb_texture

    words = material("dry soil")
    # Under the limit of what scatters evenly, patterns are nested in Mitsuba's principled BSDF.
    shiny = words.model_copy(update={"roughness": 0.69})
    one_sided = {
        "nested textures": patterned_bsdf(shiny, "ground"),
        "one colour": opaque_bsdf(words, rgb_texture(words.color)),
    }
    made = {
        name: mi.load_dict({"type": "twosided", "bsdf": surface})
        for name, surface in one_sided.items()
    }
    made["one look"] = material_bsdf(words, "ground")
    took = {name: milliseconds(surface) for name, surface in made.items()}
    for name, ms in took.items():
        print(f"{name:16} {ms:7.1f} ms  {ms / took['one colour']:5.2f} x one colour")
    print(f"one look is {took['nested textures'] / took['one look']:.1f} times as fast as nested")


def milliseconds(surface: Any) -> float:
    """Return the least time of evaluating and sampling a BSDF once a pixel."""
    import drjit as dr
    import mitsuba as mi

    scene = mi.load_dict({"type": "scene", "ground": hills(surface)})
    si = scene.ray_intersect(rays())
    dr.eval(si)
    wo = si.to_local(dr.normalize(mi.Vector3f(0.4, 0.8, 0.2)))
    dr.eval(wo)
    ctx, generator = mi.BSDFContext(), cast(Any, mi.PCG32)
    count = SIZE[0] * SIZE[1]

    def once(seed: Any) -> Any:
        rng = generator(size=count, initstate=dr.arange(mi.UInt32, count) + seed)
        u = mi.Point2f(rng.next_float32(), rng.next_float32())
        value, pdf, found, weight = si.bsdf().eval_pdf_sample(
            ctx, si, wo, rng.next_float32(), u, si.is_valid()
        )
        return value, pdf, found.wo, weight

    return least(once)


def least(once: Callable[[Any], Any]) -> float:
    """Return the least time of some rounds, without the first, which compiles [ms]."""
    import drjit as dr
    import mitsuba as mi

    times = []
    for i in range(ROUNDS):
        began = time.perf_counter()
        dr.eval(once(dr.opaque(mi.UInt32, i)))
        dr.sync_thread()
        times.append(time.perf_counter() - began)
    return min(times[1:]) * 1e3


def rays() -> Any:
    """Return a ray a pixel of a camera that looks over the hills."""
    import mitsuba as mi

    width, height = SIZE
    x, y = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
    d = np.stack([(x - 0.5).ravel(), (0.1 - 0.55 * y).ravel(), np.full(x.size, -1.0)])
    origin = mi.Point3f(0.0, 3.0, 10.0)
    return mi.Ray3f(origin, mi.Vector3f(*(mi.Float(v) for v in d / np.linalg.norm(d, axis=0))))


def hills(surface: Any) -> Any:
    """Return hilly ground of 60 m as a mesh of Mitsuba."""
    import mitsuba as mi

    from render.surfaces.mitsuba_bsdf import STEEP
    from render.vertex_normals import vertex_normals

    n = 200
    c = np.linspace(-30, 30, n)
    x, z = (a.ravel() for a in np.meshgrid(c, c))
    y = 0.8 * np.sin(0.5 * x + 0.3 * z) + 0.4 * np.sin(1.1 * z - 0.7 * x)
    i = np.arange(n * n).reshape(n, n)
    a, b, c4, d = (q.ravel() for q in (i[:-1, :-1], i[:-1, 1:], i[1:, 1:], i[1:, :-1]))
    faces = np.concatenate([np.stack([a, d, c4], 1), np.stack([a, c4, b], 1)]).astype(np.uint32)
    vertices = np.stack([x, y, z], axis=1).astype(np.float32)
    props = mi.Properties()
    props["mesh_bsdf"] = surface
    mesh = mi.Mesh("hills", n * n, len(faces), props=props, has_vertex_normals=True,
                   has_vertex_texcoords=True)  # fmt: skip
    mesh.add_attribute(STEEP, 1, [0.2] * (n * n))
    values = mi.traverse(mesh)
    arrays = {
        "faces": faces,
        "vertex_positions": vertices,
        "vertex_normals": vertex_normals(vertices, faces),
        "vertex_texcoords": vertices[:, [0, 2]],
    }
    for name, array in arrays.items():
        values[name] = type(values[name])(np.ascontiguousarray(array.ravel()))
    values.update()
    return mesh


if __name__ == "__main__":
    main()
