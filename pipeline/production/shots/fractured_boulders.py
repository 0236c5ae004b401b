"""Fractured boulders: boulders as frost and bedding have broken them, as the picture shows them.

For footholds boulders are smooth ellipsoids, and the stones of a pit are round and flat. In the
picture each boulder is cut by planes of its own into faces and edges, and by ledges along the
bedding that all of them share, as they come from one rock; faces are chipped off the stones of a
pit. Where performers tread they stay as they are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.ndimage import find_objects, label

from pipeline.production.shots.natural_ground import is_natural_ground
from pipeline.production.shots.untrodden import distance_from_treads
from pipeline.production.surroundings.lattice_noise import fractal, smoothstep
from pipeline.simulation.seeds import generator
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Take, TerrainRecord
from pipeline.simulation.terrain.heightfield import HeightField
from pipeline.simulation.terrain.natural_terrain import Boulders, scattered_boulders, swells
from pipeline.spec.scene import Scene
from pipeline.spec.terrain.kinds import BouldersTerrain, StonesTerrain

TOPS, SIDES = (2, 4), (5, 7)
"""Numbers of planes that cut the top and the sides of a boulder."""

TOP_TILT, SIDE_TILT = 0.45, (0.95, 1.4)
"""Greatest tilt of a top, and tilts of sides from upright normals [rad]."""

TOP_AT, SIDE_AT = (0.84, 1.08), (0.86, 1.06)
"""Distances of the planes from a boulder's middle, relative to its axes."""

WIDEST = 1.2
"""How far a boulder may reach where its planes leave a corner, relative to its axes."""

BEDDING, DIP, LEDGE = 0.1, 0.28, 0.75
"""Thickness of a bed [m], its rise per metre, and how far its edge stands out."""

ROUGH, ROUGH_WIDTH = 0.012, 0.16
"""Half of the unevenness of a face, and its width [m]."""

LARGE = 0.2
"""Length from which a boulder shows its bedding fully [m]."""

CHIPS, CHIP_AT, CHIP_SLOPE = 5, (0.35, 0.85), (0.5, 1.5)
"""Number of faces chipped off a stone of a pit, their distances from its middle relative to its
radius, and their falls per metre."""

GROUP, GROUP_EDGE, GROUP_CORE = 3.4, (-0.12, 0.2), (0.15, 0.75)
"""Width of groups of boulders [m], and values of their noise between which groups begin, and
between which their boulders grow."""

GROWN, LEAST_SIZE = 2.6, 0.25
"""By how much the largest of a group are longer, and sizes below which boulders are left out,
relative to those that feet find."""

SAME = 1e-6
"""Height over the bed up to which ground belongs to it [m]."""

TREAD_EDGE, RISE_EDGE = 0.09, 0.45
"""Distances from treads over which the picture leaves the true ground, downward and upward [m]."""


def fractured(terrain: TerrainRecord, scene: Scene, take: Take) -> TerrainRecord:
    """Return a take's terrain as it is drawn: with fractured boulders, if it has any.

    Args:
        terrain: of the take.
        scene: of the film.
        take: whose performers tread on it.
    """
    author = scene.terrain
    if not isinstance(author, BouldersTerrain) or not is_natural_ground(terrain, scene):
        return terrain
    shape = terrain.cells[1] + 1, terrain.cells[0] + 1
    if len(terrain.vertices) != shape[0] * shape[1]:
        return terrain
    before = terrain.vertices[:, 1].astype(float)
    return _away_from_feet(terrain, _broken(author, scene.seed, take).ravel() - before, take)


def chipped(terrain: TerrainRecord, scene: Scene, take: Take) -> TerrainRecord:
    """Return a terrain as it is drawn: with chipped stones, if it is a pit of them in water.

    Args:
        terrain: with the weathered pit.
        scene: of the film.
        take: whose performers tread on it.
    """
    if terrain is take.terrain or not isinstance(scene.terrain, StonesTerrain):
        return terrain
    shape = terrain.cells[1] + 1, terrain.cells[0] + 1
    grid = np.asarray(take.terrain.vertices, float).reshape(*shape, 3)
    height = grid[..., 1]
    number, _ = label(height > height.min() + SAME)
    rng = np.random.default_rng(scene.seed + 680)
    cut = np.zeros(shape)
    ends = set(np.unique(number[:, [0, -1]]).tolist())
    for k, box in enumerate(find_objects(number), start=1):
        planes = [rng.uniform(0.0, 2.0 * np.pi, CHIPS), rng.uniform(*CHIP_AT, CHIPS)]
        planes.append(rng.uniform(*CHIP_SLOPE, CHIPS))
        if k in ends:
            continue
        own = number[box] == k
        places = grid[box][..., [0, 2]]
        radius = float(np.ptp(places[own], axis=0).max()) / 2.0
        x, z = np.moveaxis(places - places[own].mean(axis=0), -1, 0)
        chips = [
            slope * np.maximum(np.cos(way) * x + np.sin(way) * z - at * radius, 0.0)
            for way, at, slope in zip(*planes, strict=True)
        ]
        uneven = 0.5 * ROUGH * np.maximum(1.0 + fractal(places / ROUGH_WIDTH, 690, 3), 0.0)
        cut[box] += own * (np.max(chips, axis=0) + uneven)
    # What has sunk already is not cut below the bed.
    deep = terrain.vertices[:, 1].astype(float) - float(terrain.vertices[:, 1].min())
    return _away_from_feet(terrain, -np.minimum(cut.ravel(), deep), take)


def _away_from_feet(terrain: TerrainRecord, shift: Array, take: Take) -> TerrainRecord:
    """Return a terrain with its heights shifted by (V,) where no performer treads on it [m]."""
    before = terrain.vertices[:, 1].astype(float)
    # Down to the face of a plane nearly at once; up only away from feet and legs.
    away = distance_from_treads(terrain.vertices[:, [0, 2]].astype(float), take)
    shift *= smoothstep(0.0, TREAD_EDGE, away)
    shift = np.where(shift > 0.0, shift * smoothstep(0.0, RISE_EDGE, away), shift)
    vertices = np.array(terrain.vertices)
    vertices[:, 1] = before + shift
    return replace(terrain, vertices=vertices)


def _broken(author: BouldersTerrain, seed: int, take: Take) -> Array:
    """Return the heights of ground with fractured boulders, about the origin."""
    ground_rng, heap_rng = generator(seed, "terrain").spawn(2)
    heights = swells(author, author.height, author.spacing, ground_rng)
    ground = HeightField(heights, author.size)
    boulders = _grouped(scattered_boulders(author, heap_rng), seed, take)
    foot = ground.height(boulders.xz[:, 0], boulders.xz[:, 1])
    middle = foot + boulders.axes[:, 2] * (1.0 - 2.0 * author.buried)
    x, z = (
        np.linspace(-0.5 * length, 0.5 * length, n + 1)
        for length, n in zip(author.size, author.cells, strict=True)
    )
    rng = np.random.default_rng(seed + 660)
    heights = heights.copy()
    for k in range(len(middle)):
        reach = WIDEST * boulders.axes[k, 0]
        i, j = (
            slice(*np.searchsorted(a, [at - reach, at + reach]))
            for a, at in zip((x, z), boulders.xz[k], strict=True)
        )
        part = heights[j, i]
        if part.size:
            own = _rock(boulders, k, np.meshgrid(x[i], z[j]), rng)
            np.maximum(part, middle[k] + own, out=part)
    return heights


def _grouped(boulders: Boulders, seed: int, take: Take) -> Boulders:
    """Return boulders in groups of large ones, with open ground between; trodden ones stay."""
    away = distance_from_treads(boulders.xz, take)
    long = boulders.axes[:, 0]
    value = fractal(boulders.xz / GROUP, seed + 661, 2)
    size = smoothstep(*GROUP_EDGE, value) * (1.0 + GROWN * smoothstep(*GROUP_CORE, value))
    # A large one ends before the next tread, or a foot would cut a notch into it.
    size = np.clip(size, 0.0, np.maximum((away - RISE_EDGE) / (WIDEST * long), 1.0))
    size = np.where(away < WIDEST * long, 1.0, size)
    tall = size ** np.where(size > 1.0, 1.15, 1.0)
    axes = boulders.axes * np.stack([size, size, tall], axis=-1)
    grouped = Boulders(boulders.xz, axes, boulders.turn)
    return grouped.subset(size > LEAST_SIZE)


def _rock(boulders: Boulders, k: int, places: Sequence[Array], rng: np.random.Generator) -> Array:
    """Return the heights of one boulder over its middle, far below it where there is none."""
    tilts = np.concatenate(
        [
            rng.uniform(0.0, TOP_TILT, rng.integers(TOPS[0], TOPS[1] + 1)),
            rng.uniform(*SIDE_TILT, rng.integers(SIDES[0], SIDES[1] + 1)),
        ]
    )
    count = len(tilts)
    # Sides lie about evenly around a boulder, or it would have none somewhere.
    around = 2.0 * np.pi * (np.arange(count) + rng.uniform(-0.35, 0.35, count)) / count
    around = rng.permutation(around)
    at = np.where(tilts > TOP_TILT, rng.uniform(*SIDE_AT, count), rng.uniform(*TOP_AT, count))
    x, z = (a - own for a, own in zip(places, boulders.xz[k], strict=True))
    c, s = boulders.turn[k]
    long, wide, tall = boulders.axes[k]
    u, v = (c * x + s * z) / long, (c * z - s * x) / wide
    up, aside = np.cos(tilts), np.sin(tilts)
    tops = [
        (at[n] - aside[n] * (np.cos(around[n]) * u + np.sin(around[n]) * v)) / up[n]
        for n in range(count)
    ]
    is_side = tilts[np.argmin(tops, axis=0)] > TOP_TILT
    top = tall * np.min(tops, axis=0)
    spots = np.stack(places, axis=-1)
    top += ROUGH * fractal(spots / ROUGH_WIDTH, 670, 3)
    bed = (top + DIP * (0.8 * places[0] + 0.6 * places[1])) / BEDDING
    edge = bed - np.floor(bed)
    share = LEDGE * float(smoothstep(0.5 * LARGE, LARGE, np.array(2.0 * long)))
    # Beds crop out at the sides; on tops they would be ripples.
    top += share * is_side * BEDDING * (smoothstep(0.3, 1.0, edge) - edge)
    return np.where(np.hypot(u, v) < WIDEST, top, -np.inf)
