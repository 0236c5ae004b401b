"""Untrodden ground: how far places are from where performers tread or stand."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from pipeline.production.scenery.treads import Treads
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Take

STANDING = 0.06
"""Radius around a limb within which it stands as a film begins [m]."""


def distance_from_treads(places: Array, take: Take) -> Array:
    """Return the distances (N,) of places (N, 2) from where performers tread or stand [m]."""
    treads = Treads.of(take)
    # Who stands on the ground as the film begins has not trodden on it.
    first = np.asarray(take.positions[0], float)[:, [0, 2]]
    lifts = [c.place for c in take.contacts if c.kind == "lift" and c.other == "terrain"]
    lifted = np.array(lifts, float).reshape(-1, 3)[:, [0, 2]]
    middles = np.concatenate([treads.places, lifted, first])
    stood = np.full(len(lifted) + len(first), STANDING)
    radii = np.concatenate([treads.radii, stood])
    if not len(middles):
        return np.full(len(places), np.inf)
    apart, number = cKDTree(middles).query(places, workers=1)
    return np.maximum(apart - radii[number], 0.0)
