"""Branches: skeletons of trees and shrubs that grow towards the light.

Points of free space attract the nearest node of the skeleton within reach; each node that is
attracted grows a step towards the mean of its attractors, and points that are reached disappear.

Sources: Runions, Lane, Prusinkiewicz, Modeling Trees with a Space Colonization Algorithm, 2007;
Shinozaki et al., A Quantitative Analysis of Plant Form: the Pipe Model Theory, 1964, for radii.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from pipeline.production.scenery.furrowed_bark import add_furrowed_bark
from pipeline.production.scenery.prototype import Shape, add_tubes, unit
from pipeline.simulation.spatial import Array

PIPE_EXPONENT = 2.25
"""Of the radii whose powers add up where branches meet."""

MAX_ROUNDS = 90

FLARE = 2.0
"""Radius of the foot of a trunk relative to the trunk just above it."""


@dataclass(frozen=True, eq=False)
class Skeleton:
    """A skeleton; parents come before children.

    Attributes:
        nodes: (N, 3) places [m].
        parents: (N,) numbers of parents, -1 for roots.
        radii: (N,) [m].
        ways: (N, 3) unit vectors from parents to nodes.
    """

    nodes: Array
    parents: NDArray[np.int64]
    radii: Array
    ways: Array

    @property
    def tips(self) -> NDArray[np.int64]:
        """Numbers of the nodes without children."""
        return np.setdiff1d(np.arange(len(self.nodes)), self.parents)


def grown(
    stems: list[Array],
    attractors: Array,
    step: float,
    foot_radius: float,
    *,
    sag: float = 0.0,
    reach: float = 6.0,
    kill: float = 1.6,
) -> Skeleton:
    """Return the skeleton that grows from stems into the space of attractors.

    Args:
        stems: (n, 3) points each, the first in the ground [m].
        attractors: (A, 3) [m].
        step: of growth [m].
        foot_radius: of the thickest stem [m].
        sag: by which tips are pulled down, relative to the step.
        reach: within which attractors act [steps].
        kill: distance at which an attractor is reached [steps].
    """
    nodes: list[Array] = []
    parents: list[int] = []
    for stem in stems:
        parents += [-1, *range(len(nodes), len(nodes) + len(stem) - 1)]
        nodes += list(stem)
    rest, places = attractors, np.array(nodes)
    for _ in range(MAX_ROUNDS):
        if not len(rest):
            break
        distance, nearest = cKDTree(places).query(rest, workers=1)
        near = distance < reach * step
        if not near.any():
            near = distance <= distance.min() + step
        pull = np.zeros_like(places)
        np.add.at(pull, nearest[near], unit(rest[near] - places[nearest[near]]))
        growing = np.unique(nearest[near])
        way = unit(pull[growing]) - [0.0, sag, 0.0]
        made = places[growing] + step * unit(way)
        # Two attractors on opposite sides would hold a node where it is for ever.
        apart = cKDTree(places).query(made, workers=1)[0] > 0.35 * step
        if not apart.any():
            break
        parents += growing[apart].tolist()
        places = np.concatenate([places, made[apart]])
        rest = rest[cKDTree(places).query(rest, workers=1)[0] > kill * step]
    return _with_radii(places, np.array(parents), foot_radius)


def _with_radii(nodes: Array, parents: NDArray[np.int64], foot_radius: float) -> Skeleton:
    loads = np.zeros(len(nodes))
    has_children = np.zeros(len(nodes), bool)
    has_children[parents[parents >= 0]] = True
    for k in range(len(nodes) - 1, -1, -1):
        loads[k] += 0.0 if has_children[k] else 1.0
        if parents[k] >= 0:
            # Long branches thicken a little even without side branches.
            loads[parents[k]] += loads[k] + 0.04
    radii = loads ** (1.0 / PIPE_EXPONENT)
    radii *= foot_radius / radii.max()
    ways = unit(nodes - nodes[np.maximum(parents, 0)])
    ways[parents < 0] = [0.0, 1.0, 0.0]
    return Skeleton(nodes, parents, radii, ways)


def add_bark(
    shape: Shape,
    skeleton: Skeleton,
    colors: Array,
    least_radius: float,
    sides: int,
    furrowed: float = np.inf,
) -> None:
    """Add tubes around all branches of at least a radius.

    Args:
        shape: to which they are added.
        skeleton: of the tree.
        colors: (N, 3) of the nodes, linear.
        least_radius: of branches that are shown [m].
        sides: of the tubes.
        furrowed: radius from which branches have furrows [m].
    """
    shown = np.flatnonzero((skeleton.parents >= 0) & (skeleton.radii >= least_radius))
    if not len(shown):
        return
    above = skeleton.parents[shown]
    heaviest = np.zeros(len(skeleton.nodes), np.int64)
    order = np.argsort(skeleton.radii, kind="stable")
    inner = order[skeleton.parents[order] >= 0]
    heaviest[skeleton.parents[inner]] = inner
    # The main branch goes on with the ring of its parent; others set out with one of their own.
    goes_on = heaviest[above] == shown
    own = skeleton.ways[shown]
    start = np.where(goes_on[:, None], skeleton.ways[above], own)
    wide = np.where(goes_on, skeleton.radii[above], 1.2 * skeleton.radii[shown])
    # The foot of a trunk spreads.
    is_foot = skeleton.parents[above] < 0
    wide = np.where(is_foot, FLARE * wide, wide)
    # Bark changes by degrees: a tube of one colour is seen as a ring.
    tones = np.stack([colors[above], colors[shown]], axis=1)
    low, high = skeleton.nodes[above], skeleton.nodes[shown]
    radii = skeleton.radii[shown]
    for is_thick in (True, False):
        some = (radii >= furrowed) == is_thick
        piece = low[some], high[some], wide[some], radii[some], tones[some]
        ways = start[some], own[some]
        if not is_thick:
            add_tubes(shape, *piece, sides, ways)
        elif some.any():
            add_furrowed_bark(shape, *piece, ways)
