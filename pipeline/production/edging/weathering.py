"""Weathering: colours of stains on the plaster of houses, and of rooms behind their panes.

Both vary over a facade, so its walls and panes are subdivided into cells with colours of vertices.

Source: J. Dorsey, H. K. Pedersen, P. Hanrahan, Flow and Changes in Appearance, 1996, for streaks
    below sills and cornices, where water leaves what it has carried.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pipeline.production.edging.carpentry import subdivide_sides
from pipeline.production.surroundings.lattice_noise import noise, smoothstep
from pipeline.simulation.spatial import Array
from render.shot import Mesh

CELL = {"wall": 0.12, "pane": 0.1}
"""Breadth of cells, at most [m]."""

DIRT, PALE = (0.055, 0.046, 0.034), (0.72, 0.68, 0.58)
"""Linear colours of what water leaves, and of plaster that has lost its wash."""

SPLASH, SPLASH_HEIGHT = 0.6, 0.6
"""Dirt at the foot of a wall, and the height over which it falls to 1/e [m]."""

EAVES, EAVES_HEIGHT = 0.42, 0.6
"""Dirt under the eaves, and the height over which it falls to 1/e [m]."""

DRIP, DRIP_HEIGHT, DRIP_WIDTH = 0.7, 0.8, 0.09
"""Dirt below the ends of sills, the height over which it falls to 1/e, and its breadth [m]."""

STREAKS, WORN = 0.22, 0.17
"""Dirt in streaks all over, and share of its wash that plaster loses at most in patches."""

ROOMS = (
    (0.105, 0.078, 0.050),
    (0.060, 0.072, 0.080),
    (0.080, 0.086, 0.062),
    (0.120, 0.100, 0.076),
    (0.085, 0.056, 0.046),
)
"""Linear colours of the walls of rooms as they are seen from a street by day."""


@dataclass(frozen=True, eq=False)
class Front:
    """The walls of a house that are exposed to rain.

    Attributes:
        place: middle of the foot of its facade, x and z [m].
        heading: of it [rad].
        size: width, depth, and height of the wall over its foot [m].
        foot: height of the ground before its door, about [m].
        sills: (N, 3) middles of sills along the facade, their heights over its foot, and their
            widths [m].
        panes: (N, 4) middles along, heights of the lower edges, widths and heights [m].
    """

    place: Array
    heading: float
    size: tuple[float, float, float]
    foot: float
    sills: list[tuple[float, float, float]] = field(default_factory=list)
    panes: list[tuple[float, float, float, float]] = field(default_factory=list)

    def local(self, points: Array) -> Array:
        """Return points (N, 3) along, over the foot of, and before the facade [m]."""
        c, s = np.cos(self.heading), np.sin(self.heading)
        x, z = points[:, 0] - self.place[0], points[:, 2] - self.place[1]
        return np.column_stack([c * x - s * z, points[:, 1] - self.foot, s * x + c * z])

    def shows(self, local: Array) -> Array:
        """Return whether points (N, 3) of its own frame are on its facade or its gable walls."""
        wide, deep, _ = self.size
        along, before = np.abs(local[:, 0]), local[:, 2]
        is_aside = (along > 0.5 * wide - 0.05) & (before > 0.05 - deep)
        is_facade = before > -0.3
        # The next house begins where this one ends.
        return np.asarray((is_aside | is_facade) & (along < 0.5 * wide + 0.01) & (before < 0.3))

    @property
    def key(self) -> tuple[int, int]:
        """Numbers by which it is told from its neighbours."""
        x, z = (np.rint(100.0 * self.place).astype(int) & 65535).tolist()
        return x, z


def add_weathering(mesh: Mesh, fronts: Sequence[Front], seed: int) -> Mesh:
    """Return plaster, in cells, with what the weather has left on it.

    Args:
        mesh: of boxes, four vertices to a side.
        fronts: of the houses that it is part of.
        seed: of the scene.
    """
    return _covered(mesh, fronts, CELL["wall"], lambda f, p: _weather(f, p, seed))


def add_rooms(mesh: Mesh, fronts: Sequence[Front], seed: int) -> Mesh:
    """Return panes, in cells, with the rooms behind them; see `add_weathering`."""
    return _covered(mesh, fronts, CELL["pane"], lambda f, p: _rooms(f, p, seed))


def _covered(
    mesh: Mesh, fronts: Sequence[Front], cell: float, color: Callable[[Front, Array], Array]
) -> Mesh:
    """Return a mesh with a cover that each front gives to its points (N, 3), as (N, 4)."""
    middles = mesh.vertices.reshape(-1, 4, 3).mean(axis=1).astype(float)
    is_seen = np.zeros(len(middles), bool)
    for front in fronts:
        is_seen |= front.shows(front.local(middles))
    mesh = subdivide_sides(mesh, cell, is_seen)
    cover = np.zeros((len(mesh.vertices), 4), np.float32)
    points = mesh.vertices.astype(float)
    for front in fronts:
        local = front.local(points)
        own = np.flatnonzero(front.shows(local))
        if len(own):
            cover[own] = color(front, local[own])
    return replace(mesh, cover=cover)


def _weather(front: Front, local: Array, seed: int) -> Array:
    """Return colours and shares (N, 4) of weather at points of a facade's own frame (N, 3)."""
    along, up, before = local.T
    wide, _, wall_height = front.size
    is_facade = (before > -0.3) & (np.abs(along) < 0.5 * wide - 0.02)
    # Around its corners the noise goes on along the depth of the house.
    unfolded = along + np.where(is_facade, 0.0, before)
    x, z = front.key
    key = (seed + 7919 * x + 104_729 * z) & 0xFFFFFF
    column = noise(np.column_stack([unfolded / 0.23, up / 3.1]), key)
    patch = noise(np.column_stack([unfolded / 1.7, up / 1.3]), key + 1)
    patch = patch + 0.6 * noise(np.column_stack([unfolded / 0.5, up / 0.4]), key + 2)
    uneven = 0.75 + 0.5 * column
    dirt = SPLASH * np.exp(-np.maximum(up, 0.0) / SPLASH_HEIGHT) * (0.8 + 0.5 * patch)
    # Over the eaves a gable fades again.
    dirt += EAVES * np.exp(-np.abs(up - wall_height) / EAVES_HEIGHT) * uneven
    dirt += STREAKS * np.maximum(column, 0.0)
    for middle, sill, width in front.sills:
        below = sill - up
        falls = np.where(is_facade & (below > 0.0), np.exp(-below / DRIP_HEIGHT), 0.0)
        end = np.abs(np.abs(along - middle) - 0.5 * width + 0.03)
        dirt += DRIP * falls * np.exp(-np.square(end / DRIP_WIDTH)) * uneven
        dirt += 0.3 * DRIP * falls * (np.abs(along - middle) < 0.5 * width) * uneven
    worn = WORN * smoothstep(0.15, 0.8, patch)
    dirt = np.clip(dirt, 0.0, 0.75)
    share = dirt + worn * (1.0 - dirt)
    mix = (dirt / np.maximum(share, 1e-6))[:, None]
    return np.column_stack([mix * np.array(DIRT) + (1.0 - mix) * np.array(PALE), share])


def _rooms(front: Front, local: Array, seed: int) -> Array:
    """Return colours and shares (N, 4) of the rooms behind panes.

    From below one sees the ceiling of an upper room, which the light from the street brightens,
    and what hangs from it; of a room at the street its furniture.
    """
    color = np.zeros((len(local), 4))
    for middle, low, wide, tall in front.panes:
        u, v = (local[:, 0] - middle) / wide, (local[:, 1] - low) / tall
        own = np.flatnonzero((np.abs(u) < 0.53) & (v > -0.03) & (v < 1.03))
        if not len(own):
            continue
        u, v = u[own], v[own]
        window = np.rint(100 * np.array([middle, low])).astype(int) & 65535
        rng = np.random.default_rng([seed, 467, *front.key, *window])
        wall = np.array(ROOMS[int(rng.integers(len(ROOMS)))])
        side = rng.choice((-1.0, 1.0))
        lit = 0.75 + 0.5 * side * u
        if low > 3.0:
            lit = lit * (0.45 + 1.15 * v)
            ceiling = smoothstep(0.0, 0.1, v - rng.uniform(0.45, 0.7))
            seen = wall + ceiling[:, None] * (np.array([0.21, 0.20, 0.18]) - wall)
        else:
            seen = np.tile(wall, (len(u), 1))
            top = rng.uniform(0.3, 0.6)
            at, half = rng.uniform(-0.3, 0.3), rng.uniform(0.12, 0.3)
            is_shelf = (np.abs(u - at) < half) & (v < top)
            seen[is_shelf] *= np.where(
                np.sin(23.0 * u + 31.0 * np.floor(6.0 * v)) > 0.2, 1.7, 0.45
            )[is_shelf, None]
        if rng.uniform() < 0.5:
            far = np.hypot((u - side * 0.18) / 0.16, (v - 0.72) / 0.1 * min(tall / 1.5, 1.0))
            seen = seen + (0.30 * np.array([1.0, 0.86, 0.62]) - seen) * (far < 1.0)[:, None]
        color[own, :3], color[own, 3] = lit[:, None] * seen, 1.0
    return color
