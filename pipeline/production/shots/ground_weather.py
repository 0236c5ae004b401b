"""Ground weather: how rain and snow change the ground, and rain whoever is out in it.

What is wet is darker, because water leads light into it, and glossier. Snow lies where it is level.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from pipeline.production.surroundings.choice import NATURAL
from pipeline.production.surroundings.land_cover import SNOW
from render.config import MATERIALS, Material, Weather
from render.shot import Mesh
from render.vertex_normals import vertex_normals

WET_SHARE = 0.52
"""Brightness of soaked ground, as a share of dry ground, in sRGB values."""
WET_ROUGHNESS, WET_RELIEF = 0.5, 0.55
"""Roughness of soaked ground, and the share of its relief that is left: water fills the pores, and
a rough film that mirrors the sun would be foil."""
SOAKED = 0.5
"""Rain from which natural ground is soaked."""
FLOOR_SOAKED, WET_FLOOR_ROUGHNESS = 0.2, 0.2
"""Rain from which a floor is soaked, as nothing of it seeps away, and its roughness then."""

WET_COAT, WET_SMOOTHNESS, WET_DARKNESS = 1.05, 0.35, 0.3
"""Of what is soaked: weight of the film of water on what is smooth, share of the roughness that is
gone, and by how much what is rough is darker."""

_COVERED = 0.6
"""Snowfall at which all level ground is white."""
_SLOPES = 0.62, 0.86
"""Cosines of slopes at which snow begins to lie, and lies fully."""
_STEEP_DEG = 40.0
_FROST = 0.8
"""Share of what faces up of plants and stones that is white in full snow."""

_COLORS = ("color", "color2", "steep_color", "crest_color", "hollow_color")


def ground_in_weather(material: Material, weather: Weather) -> Material:
    """Return a material of the ground as wetness and snow change it."""
    values: dict[str, Any] = {}
    if weather.wetness > 0.0:
        is_natural = material.texture in NATURAL
        soaked, smooth = (
            (SOAKED, WET_ROUGHNESS) if is_natural else (FLOOR_SOAKED, WET_FLOOR_ROUGHNESS)
        )
        wet = min(weather.wetness / soaked, 1.0)
        values |= _darkened(material, 1.0 + wet * (WET_SHARE - 1.0))
        values["roughness"] = min(
            material.roughness, material.roughness + wet * (smooth - material.roughness)
        )
        if is_natural:
            values["bump"] = material.bump * (1.0 + wet * (WET_RELIEF - 1.0))
        # Rough snow, cloth and leaves keep their other qualities; what needs a dull surface goes.
        values |= {"translucency": 0.0, "sheen": 0.0}
    if weather.snow > 0.0:
        snow, lying = MATERIALS["snow"], min(weather.snow / _COVERED, 1.0)
        for key in ("color", "color2"):
            own = values.get(key, getattr(material, key)) or values.get("color", material.color)
            white = getattr(snow, key) or snow.color
            values[key] = tuple(a + lying * (b - a) for a, b in zip(own, white, strict=True))
        values["steep_color"] = values.get("steep_color") or material.steep_color or material.color
        values["steep_deg"] = max(_STEEP_DEG, material.steep_deg)
        values |= {"crest_color": None, "hollow_color": None}
        if lying > 0.5:
            values |= {
                "texture": snow.texture,
                "texture_scale": snow.texture_scale,
                "bump": snow.bump,
                "roughness": snow.roughness,
            }
    return material.model_copy(update=values) if values else material


def wetted(material: Material, weather: Weather) -> Material:
    """Return a material of what rain wets: a film of water lies on what is smooth.

    What water leads light into is darker. Leaves, glass, and what glows stay as they are.
    """
    if weather.wetness == 0.0 or material.translucency or material.transmission or material.glow:
        return material
    wet, rough = min(weather.wetness / SOAKED, 1.0), material.roughness
    share = 1.0 - WET_DARKNESS * wet * rough * (1.0 - material.metallic)
    values = _darkened(material, share) | {
        "clearcoat": min(max(material.clearcoat, wet * (WET_COAT - rough)), 1.0),
        "roughness": rough * (1.0 - WET_SMOOTHNESS * wet),
    }
    return material.model_copy(update=values)


def _darkened(material: Material, share: float) -> dict[str, Any]:
    """Return all colours of a material, as shares of what they are."""
    colors = {key: getattr(material, key) for key in _COLORS}
    return {key: tuple(share * c for c in color) for key, color in colors.items() if color}


def snowed_cover(mesh: Mesh, weather: Weather) -> Mesh:
    """Return land whose cover is white where it is level enough for snow to lie."""
    if weather.snow == 0.0 or mesh.cover is None:
        return mesh
    low, high = _SLOPES
    t = ((np.abs(vertex_normals(mesh.vertices, mesh.faces)[:, 1]) - low) / (high - low)).clip(
        0.0, 1.0
    )
    share = (t * t * (3 - 2 * t) * min(weather.snow / _COVERED, 1.0))[:, None]
    color = mesh.cover[:, :3] * (1 - share) + np.array(SNOW) * share
    cover = np.concatenate([color, mesh.cover[:, 3:]], axis=1).astype(np.float32)
    return replace(mesh, cover=cover)


def frosted(mesh: Mesh, weather: Weather) -> Mesh:
    """Return plants or stones with snow on what faces up."""
    if weather.snow == 0.0 or mesh.colors is None or mesh.normals is None:
        return mesh
    share = _FROST * min(weather.snow / _COVERED, 1.0) * mesh.normals[:, 1:2].clip(0.15, 1.0)
    colors = mesh.colors + share * (np.array(SNOW, np.float32) - mesh.colors)
    return replace(mesh, colors=colors.astype(np.float32))
