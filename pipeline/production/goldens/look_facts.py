"""Look facts: film settings, lights, materials and shapes of a film, before anything is rendered.

The settings are those of the scene with its presets written out, so that another wording of the
same look is equal, and a preset that changed is not.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import isclose
from pathlib import Path
from typing import Any, Final

import numpy as np
from pydantic import BaseModel

from pipeline.production.reports.stills import spread
from pipeline.simulation.take import UNSEEN, Take
from render.config import Film, Light, Material
from render.panorama_file import file_digest

Look = dict[str, dict[str, str]]
"""Block, such as "film" or "material clay" -> path of a setting -> its value."""

Shapes = dict[str, tuple[float, ...]]
"""Part -> extents along the axes of its rest pose [m], number of vertices, first and last row in
which it is visible."""

MAX_SHAPES: Final = 300
"""Parts whose shapes are kept, spread evenly."""

EXTENT_TOLERANCE: Final = 5e-4
"""Of the extent of a part [m]."""


def look_of(film: Film, light: Light, materials: Mapping[str, Material]) -> Look:
    """Return the settings of a film by block."""
    look = {"film": _settings(film), "light": _settings(light)}
    if light.hdr is not None:
        panorama = Path(light.hdr.file)
        look["light"]["hdr.file"] = f"{panorama.name} {file_digest(panorama)}".strip()
    return look | {f"material {name}": _settings(kind) for name, kind in materials.items()}


def _settings(block: BaseModel) -> dict[str, str]:
    values = block.model_dump(mode="json", exclude={"preset"})
    return {path: value for path, value in _paths(values) if path}


def _paths(value: Any, path: str = "") -> Iterator[tuple[str, str]]:
    """Yield the values of a nested mapping with their paths, and its blocks as "given"."""
    if isinstance(value, Mapping):
        yield path, "given"
        items: Any = value.items()
    elif isinstance(value, list) and any(isinstance(item, Mapping) for item in value):
        yield path, f"{len(value)} given"
        items = enumerate(value)
    else:
        yield path, _text(value)
        return
    for key, item in items:
        yield from _paths(item, f"{path}.{key}" if path else str(key))


def _text(value: Any) -> str:
    if isinstance(value, list):
        return f"[{', '.join(map(_text, value))}]"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def shapes_of(take: Take) -> Shapes:
    """Return the shapes of the visible parts of a take."""
    parts = [part for part in take.parts if part.seen != UNSEEN]
    shapes = {}
    for number in spread(len(parts), MAX_SHAPES):
        part = parts[number - 1]
        vertices = take.meshes[part.seen].vertices
        extents = np.ptp(vertices, axis=0) if len(vertices) else np.zeros(3)
        sizes = (round(float(extent), 4) for extent in extents)
        shapes[part.name] = (*sizes, float(len(vertices)), *map(float, part.life))
    return shapes


def look_differences(then: Look, now: Look) -> Iterator[str]:
    """Yield the settings that differ from their golden as text."""
    for block in then | now:
        if block not in then or block not in now:
            yield f"{block} is {'gone' if block in then else 'new'}"
            continue
        # Settings that only one of both has are unknown to a version, or of a block that is told.
        for path in sorted(then[block].keys() & now[block].keys()):
            if then[block][path] != now[block][path]:
                yield f"{block}: {path} is {now[block][path]}, the golden's {then[block][path]}"


def shape_differences(then: Shapes, now: Shapes) -> Iterator[str]:
    """Yield the parts that have another shape than in the golden as text.

    Parts that one of both lacks are told by their names already.
    """
    for name, shape in then.items():
        text = _shape_text(shape, now[name]) if name in now else ""
        if text:
            yield f"part {name} {text}"


def _shape_text(then: Sequence[float], now: Sequence[float]) -> str:
    pairs = zip(then[:3], now[:3], strict=True)
    if not all(isclose(a, b, rel_tol=0.0, abs_tol=EXTENT_TOLERANCE) for a, b in pairs):
        new, old = (" x ".join(f"{extent:.4g}" for extent in shape[:3]) for shape in (now, then))
        return f"is {new} m large, in the golden {old}"
    if then[3] != now[3]:
        return f"has {now[3]:.0f} vertices, in the golden {then[3]:.0f}"
    if then[4:] != now[4:]:
        new, old = (f"{shape[4]:.0f} to {shape[5]:.0f}" for shape in (now, then))
        return f"is visible in rows {new}, in the golden {old}"
    return ""
