"""Stiff: a pronker that has toppled, and falls as one rigid body.

Its joints hold what they were at; the hull of all its links strikes the ground, slides and
comes to rest.

Source: Sims 1987, 9.4 and ch. 12.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.kinematics import Tree
from pipeline.simulation.figures.reroot import displaced
from pipeline.simulation.figures.skeleton import BODY
from pipeline.simulation.locomotion.pronking.falling import Limbs
from pipeline.simulation.locomotion.pronking.happening import Happening
from pipeline.simulation.locomotion.pronking.pronker import Pronker
from pipeline.simulation.locomotion.pronking.state import State
from pipeline.simulation.spatial import Array, quaternion
from pipeline.simulation.terrain import Ground

if TYPE_CHECKING:
    from pipeline.simulation.dynamics.bouncing import Bouncing

BOUNCINESS, FRICTION, ROLLING = 0.22, 0.7, 0.03
"""Of flesh."""

LIFT = 0.002
"""What a hull is lifted by above the ground that it would begin in [m]."""


class StiffFall:
    """One creature as it falls; see `Fall`.

    Attributes:
        figure: its.
    """

    def __init__(self, figure: Figure) -> None:
        self.figure = figure
        self._bouncing: Bouncing | None = None

    def begin(self, of: Pronker, ground: Ground, state: State, limbs: Limbs) -> None:
        """Let it fall from now on, as it is."""
        # Bodies need a compiler, whose loading who stays on its feet need not wait for.
        from pipeline.simulation.dynamics.bouncing import Bouncing
        from pipeline.simulation.dynamics.hull import hull_of
        from pipeline.simulation.dynamics.rigid import Bodies, Build, unturned
        from pipeline.simulation.dynamics.rigid import State as Rigid

        hull = hull_of(_outline(self.figure, limbs.q) - of.mass.centre)
        mass = replace(of.mass, centre=np.zeros(3))
        body = Build(mass, hull, 0.0, BOUNCINESS, FRICTION, ROLLING)
        now = state.now(of)
        w = unturned(now.R, np.array(state.turning[1]))
        q = quaternion(now.R[None])
        rigid = Rigid(now.p[None].copy(), q, state.v[None].copy(), w[None])
        self._bouncing = Bouncing(Bodies.of([body]), rigid, ground)
        deep = float(self._bouncing.depths()[0])
        if deep > 0.0:
            self._bouncing.state.p[0, 1] += deep + LIFT
            self._bouncing.look()
            state.p = self._bouncing.state.p[0].copy()

    def advance(self, state: State, h: float) -> list[Happening]:
        """Go on by `h` [s]; return what struck the ground."""
        from pipeline.simulation.dynamics.rigid import turned
        from pipeline.simulation.spatial import matrix

        bouncing = self._bouncing
        assert bouncing is not None
        found = [
            Happening(
                "body",
                state.time + one.time,
                -1,
                np.array(one.place),
                np.array(one.normal),
                one.speed,
                one.energy,
            )
            for one in bouncing.advance(h)
        ]
        rigid = bouncing.state
        state.p, state.v = rigid.p[0].copy(), rigid.v[0].copy()
        a, b, c, d = rigid.q[0].tolist()
        x, y, z = turned(matrix(rigid.q[0]), rigid.w[0]).tolist()
        state.turning = (a, b, c, d), (x, y, z)
        return found

    @property
    def q(self) -> None:
        """Joints hold what they were at."""
        return None


def _outline(figure: Figure, q: Array) -> Array:
    """Return the points of a figure's links that lie farthest out, (k, 3) [m]."""
    tree = Tree.of(figure.skeleton)
    X_BJ, points = tree.pose(q), []
    grid = np.array([(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)])
    for piece in figure.pieces:
        joint = figure.skeleton.links[piece.link].joint
        vertices = piece.solid.vertices
        if joint != BODY:
            X = displaced(tree, X_BJ, joint)
            vertices = vertices @ X[:3, :3].T + X[:3, 3]
        points.append(vertices[np.unique((vertices @ grid.T).argmax(axis=0))])
    return np.concatenate(points)
