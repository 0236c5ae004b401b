"""Tracers: what turns a scene of Mitsuba into light, pass by pass.

`wavefront` is ours and the faster one. Mitsuba's own `path` does what that does not handle.
"""

from __future__ import annotations

from typing import Any

import mitsuba as mi

from render.config import FullFilm
from render.tracing.path_tracer import PathTracer
from render.tracing.tracer import Tracer
from render.tracing.wavefront import Wavefront


def tracer(scene: Any, film: FullFilm, depth: int) -> tuple[Tracer, str]:
    """Return the tracer for a scene, and why it is not ours, or nothing.

    Args:
        scene: of Mitsuba.
        film: size of the picture, and of its soft light.
        depth: longest path, in segments; more than the film says where there is glass.
    """
    why = refusal(scene)
    if why:
        return PathTracer(scene, depth, film.rays), why
    return Wavefront(scene, film.size, depth, half=film.soft_light == "half"), ""


def refusal(scene: Any) -> str:
    """Return why the wavefront tracer does not handle a scene, or nothing."""
    variant = str(mi.variant())
    if not variant.startswith(("llvm", "cuda")):
        return f"{variant} has no wavefronts"
    if "spectral" in variant or "polarized" in variant:
        return f"{variant} carries more than three colours"
    if any(shape.is_medium_transition() for shape in scene.shapes()):
        return "a surface has a medium inside"
    return ""
