"""Silhouette: the points of a creature that lie farthest out, by which it passes over things.

Its legs bend as its feet are drawn up; heads, tails and feelers are taken to hang a little lower
than they are held at rest, for they trail behind.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.chains import chains_of
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.kinds import LEG
from pipeline.simulation.figures.kinematics import Tree
from pipeline.simulation.figures.reroot import displaced
from pipeline.simulation.figures.settling import settle
from pipeline.simulation.figures.skeleton import BODY
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.spatial import Array, turn

DIRECTIONS = np.array([(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)])
"""In which points are looked for."""


SAGS = 0.12
"""How far limbs that carry nothing hang lower than at rest [rad]."""


class Silhouette:
    """The points of one creature.

    Attributes:
        body: (k, 3) of all that does not belong to its legs, in its frame [m].
    """

    def __init__(self, herd: Herd, own: NDArray[np.int64]) -> None:
        figure = herd.figures[int(herd.owner[own[0]])]
        self.body = _without_legs(figure)
        self._legs = herd.legs.rows(own)
        self._chains = chains_of(self._legs, np.zeros(len(own), dtype=np.int64))
        # Leg and joint that each of these points hangs on, and where they are from that.
        self._at, self._arms = _on_legs(figure, self._legs.places)

    def legs(self, feet: Array) -> Array:
        """Return the points (m, k, 3) of legs with their tips at (m, n, 3), in its frame [m]."""
        X = settle(self._legs, self._chains, feet).X_BJ[:, self._at[:, 0], self._at[:, 1]]
        result: Array = X[..., :3, 3] + turn(X[..., :3, :3], self._arms)
        return result


def _without_legs(figure: Figure) -> Array:
    tree = Tree.of(figure.skeleton)
    X_BJ, found = tree.pose(figure.skeleton.preferred), []
    limbs = {link: limb for limb in figure.skeleton.limbs for link in limb.links}
    for piece in figure.pieces:
        limb = limbs.get(piece.link)
        if limb is not None and limb.kind == LEG:
            continue
        joint, points = figure.skeleton.links[piece.link].joint, _outermost(piece.solid.vertices)
        if joint != BODY:
            X = displaced(tree, X_BJ, joint)
            points = points @ X[:3, :3].T + X[:3, 3]
        if limb is not None:
            out = points - X_BJ[limb.joints[0], :3, 3]
            points[:, 1] -= SAGS * np.hypot(out[:, 0], out[:, 2])
        found.append(points)
    return np.concatenate(found)


def _on_legs(figure: Figure, places: Array) -> tuple[NDArray[np.int64], Array]:
    at, arms = list[tuple[int, int]](), []
    for leg, limb in enumerate(figure.skeleton.legs):
        for piece in figure.pieces:
            if piece.link not in limb.links:
                continue
            column = limb.joints.index(figure.skeleton.links[piece.link].joint)
            own = _outermost(piece.solid.vertices) - places[leg, column]
            at += [(leg, column)] * len(own)
            arms.append(own)
    return np.array(at), np.concatenate(arms)


def _outermost(vertices: Array) -> Array:
    result: Array = vertices[np.unique((vertices @ DIRECTIONS.T).argmax(axis=0))]
    return result
