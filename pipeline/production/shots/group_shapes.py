"""Group shapes: how the members of some groups look from near, other than as they are simulated.

A drop of rain is a spindle of six sides for those who simulate it, and flat when it has struck. In
the picture it is a narrow open tube of clear water: falling it is a streak, and as it is spread
where it strikes its rim stands up as the crown of a splash. Blades of grass are drawn narrower,
short and tall, and winding. Only the meshes differ, vertex by vertex; the nodes that they follow
are those of the take.

Source: K. Garg and S. Nayar, Photorealistic rendering of rain streaks, 2006, for the width and
    clearness of streaks; A. Worthington, A Study of Splashes, 1908, for their crowns.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from pipeline.simulation.spatial import Array
from pipeline.simulation.take import UNSEEN, Mesh, Part, Take
from pipeline.spec.group import Grass, Group, Rain
from pipeline.spec.scene import Scene
from render.config import Material

RAIN_DROP = "rain drop"
"""Material of drops that the author leaves to be water."""

MATERIALS: Mapping[str, Material] = {
    RAIN_DROP: Material.model_validate(
        {"color": "#eef3f5", "roughness": 0.0, "transmission": 1.0, "ior": 1.07}
    )
}

DROP_SIDES = 6
"""Sides of a simulated drop, which has four rings and two ends."""

STREAK_RADIUS, STREAK_LENGTH = 0.0058, 0.8
"""Radius of a streak and its length, relative to the length of a drop."""

CROWN = (1.0, 0.35, 0.8, 0.2, 0.95, 0.45)
"""Heights of the points of a crown around its rim, as shares of the highest."""

BLADE_WIDTH = 0.36
"""Width of a blade as it is drawn, relative to the simulated one."""

BLADE_HEIGHTS, BLADE_LEAN, BLADE_WAVE = (0.3, 1.0), 0.2, 0.13
"""Least and greatest height of a blade relative to the simulated one, and by how much its tip
leans over and it winds sidewards, relative to its height."""


def drawn(take: Take, scene: Scene) -> Take:
    """Return the take with the meshes and materials of its groups as they are drawn."""
    rules = {member.name: member.group for member in scene.cast if isinstance(member, Group)}
    meshes, parts = list(take.meshes), list(take.parts)
    for i, part in enumerate(parts):
        rule = rules.get(part.performer)
        if part.seen == UNSEEN or not isinstance(rule, Rain | Grass):
            continue
        mesh = meshes[part.seen]
        if isinstance(rule, Rain):
            meshes[part.seen] = _with(mesh, _streaks(mesh, rule.size))
            parts[i] = _clear(part)
        else:
            meshes[part.seen] = _with(mesh, _grown(mesh))
    if parts == list(take.parts) and all(a is b for a, b in zip(meshes, take.meshes, strict=True)):
        return take
    return replace(take, meshes=tuple(meshes), parts=tuple(parts))


def _clear(part: Part) -> Part:
    return replace(part, material=RAIN_DROP) if part.material == "water" else part


def _with(mesh: Mesh, vertices: Array) -> Mesh:
    return replace(mesh, vertices=vertices.astype(np.float32))


def _streaks(mesh: Mesh, size: float) -> Array:
    """Return the vertices (V, 3) of streaks; V is a multiple of a drop's.

    Args:
        mesh: of the drops, all about their nodes.
        size: length of a drop [m].
    """
    angle = np.arange(DROP_SIDES) * (2.0 * np.pi / DROP_SIDES)
    low, high = -0.5 * STREAK_LENGTH, 0.5 * STREAK_LENGTH
    # Up the inner side of a wall to its rim and down the outer one; both feet are in the ground.
    radii = STREAK_RADIUS * np.array([0.8, 1.0, 1.05, 1.1])
    rings = np.zeros((4, DROP_SIDES, 3))
    rings[..., 0] = radii[:, None] * np.sin(angle)
    rings[..., 2] = radii[:, None] * np.cos(angle)
    rings[..., 1] = low
    rings[1:3, :, 1] = low + (high - low) * np.array(CROWN)
    ends = np.array([[0.0, low, 0.0], [0.0, low, 0.0]])
    one = size * np.concatenate([rings.reshape(-1, 3), ends])
    count = len(mesh.vertices) // len(one)
    return np.tile(one, (count, 1))


def _grown(mesh: Mesh) -> Array:
    """Return the vertices (V, 3) of blades that differ: narrower, short and tall, and winding."""
    vertices = np.asarray(mesh.vertices, float).copy()
    blade = mesh.nodes[:, 0]
    count = int(blade.max()) + 1
    rng = np.random.default_rng(count)
    height = rng.uniform(*BLADE_HEIGHTS, count)
    # One at least is as tall as it was.
    height[blade[np.argmax(vertices[:, 1])]] = 1.0
    lean, phase = rng.normal(0.0, BLADE_LEAN, (count, 2)), rng.uniform(0.0, 2 * np.pi, count)
    low, high = np.full(count, np.inf), np.full(count, -np.inf)
    np.minimum.at(low, blade, vertices[:, 1])
    np.maximum.at(high, blade, vertices[:, 1])
    long = np.maximum(high - low, 1e-9)[blade] * height[blade]
    part = (vertices[:, 1] - low[blade]) / np.maximum(high - low, 1e-9)[blade]
    wind = BLADE_WAVE * part * np.sin(phase[blade] + 5.0 * part)
    number = np.maximum(np.bincount(blade), 1)
    for k, axis in enumerate((0, 2)):
        middle = (np.bincount(blade, weights=vertices[:, axis]) / number)[blade]
        aside = lean[blade, k] * part**2 + wind * (np.cos, np.sin)[k](3.0 * phase[blade])
        vertices[:, axis] = middle + BLADE_WIDTH * (vertices[:, axis] - middle) + long * aside
    vertices[:, 1] = low[blade] + long * part
    return vertices
