"""Tree feet: taller grass around trunks, where nobody treads, and nothing grazes or mows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipeline.production.scenery.placement import Placed, Placement, Wanted
from pipeline.production.scenery.species import KINDS
from pipeline.production.surroundings.lattice_noise import hashed

TUFTS, NEAR = 22, 45.0
"""Tufts around a trunk, and the distance up to which trunks have them [m], for frames 1280 pixels
wide."""

AROUND = (0.16, 0.95)
"""Least and greatest distance of tufts from the middle of a trunk [m]."""

GRASSY = frozenset({"turf", "tufts", "untrodden", "clumps"})
"""Habitats of what stands around trunks."""


def at_feet(
    placement: Placement, trees: Sequence[Placed], wanted: Sequence[Wanted]
) -> list[Placed]:
    """Return the tallest grasses that are wanted on terrain and land, around the feet of trees."""
    grasses = [
        one
        for one in wanted
        if KINDS[one.name].widens and KINDS[one.name].habitat in GRASSY and one.where == "dry"
    ]
    grasses.sort(key=lambda one: KINDS[one.name].height * one.size)
    near = NEAR * placement.detail
    feet = np.concatenate(
        [np.zeros((0, 3)), *(tree.points[tree.distances < near] for tree in trees)]
    )
    if not grasses or not len(feet):
        return []
    k = np.arange(TUFTS)
    i, j = (np.rint(64.0 * feet[:, a]).astype(np.int32)[:, None] + k * 7919 for a in (0, 2))
    chance = np.stack([hashed(i, j, placement.seed + n).ravel() for n in range(6)], axis=-1)
    # Most stand close to the bark.
    radius = AROUND[0] + (AROUND[1] - AROUND[0]) * chance[:, 4].astype(float) ** 1.6
    angle = 2.0 * np.pi * chance[:, 5].astype(float)
    x, z = (
        np.repeat(feet[:, a], TUFTS) + radius * part
        for a, part in ((0, np.cos(angle)), (2, np.sin(angle)))
    )
    ground = placement.ground.at(x, z)
    points = np.stack([x, ground.height, z], axis=-1)
    result = []
    for here, its in (
        (ground.on_terrain, [one for one in grasses if one.on_terrain]),
        (~ground.on_terrain, [one for one in grasses if one.on_land]),
    ):
        some = np.flatnonzero(here & ground.dry)
        if not its or not len(some):
            continue
        tallest = its[-1]
        some = some[placement.is_seen_and_free(tallest, points[some])]
        result.append(
            Placed(
                *(tallest.name, points[some], ground.normals[some], ground.color[some]),
                placement.view.distances(points[some]),
                *(chance[some, 0].astype(float), chance[some, :4].astype(float), tallest.size),
            )
        )
    return result
