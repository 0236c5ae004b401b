"""Limp: a pronker that has toppled, and falls as rigid bodies that hang together.

Source: Sims 1987, 9.4.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.locomotion.pronking.falling import Limbs
from pipeline.simulation.locomotion.pronking.happening import Happening
from pipeline.simulation.locomotion.pronking.pronker import Pronker
from pipeline.simulation.locomotion.pronking.state import State
from pipeline.simulation.spatial import UP, Array, matrix, turn, unturn
from pipeline.simulation.terrain import Ground

if TYPE_CHECKING:
    from pipeline.simulation.dynamics.ragdoll import Knock, Ragdoll


QUICK = 4.0
"""Speed from which a limb has not moved but was put elsewhere, in that of a leg that swings."""


class LimpFall:
    """One creature as it falls; see `Fall`.

    Attributes:
        figure: its.
    """

    def __init__(self, figure: Figure) -> None:
        self.figure = figure
        self._ragdoll: Ragdoll | None = None
        self._order = np.zeros(0, dtype=np.int64)
        self._centre = np.zeros(3)

    def begin(self, of: Pronker, ground: Ground, state: State, limbs: Limbs) -> None:
        """Let it fall from now on, as it is."""
        # Who stays on its feet need not wait for MuJoCo.
        from pipeline.simulation.dynamics.ragdoll import Attitude, Ragdoll
        from pipeline.simulation.figures.bones import bones_of

        own = bones_of(self.figure)
        now = state.now(of)
        w = np.array(state.turning[1])
        begin = Attitude(
            p=now.origin,
            q=np.array(state.turning[0]),
            v=state.v + np.cross(w, now.origin - now.p),
            w=unturn(now.R, w),
            joints=limbs.q[own.joints],
            speeds=self._calm(limbs.speeds, QUICK * math.sqrt(GRAVITY / of.leg))[own.joints],
        )
        self._order, self._centre = own.joints, of.mass.centre
        self._ragdoll = Ragdoll(own.bones, begin, ground.field)

    def advance(self, state: State, h: float) -> list[Happening]:
        """Go on by `h` [s]; return what struck the ground."""
        ragdoll = self._ragdoll
        assert ragdoll is not None
        if ragdoll.is_at_rest:
            return []
        knocks = ragdoll.advance(h)
        it = ragdoll.attitude
        R = matrix(it.q)
        w, arm = turn(R, it.w), turn(R, self._centre)
        state.p, state.v = it.p + arm, it.v + np.cross(w, arm)
        a, b, c, d = it.q.tolist()
        x, y, z = w.tolist()
        state.turning = (a, b, c, d), (x, y, z)
        found = [_body(state.time, one) for one in knocks]
        if ragdoll.is_gone:
            text = "left the terrain, and is followed no farther"
            end = state.time + h
            found.append(Happening("dropped", end, -1, it.p, UP, 0.0, 0.0, text))
        return found

    def _calm(self, speeds: Array, quick: float) -> Array:
        """Return speeds of joints (J,), of limbs that inverse kinematics turned in no time none."""
        result = speeds.copy()
        for limb in self.figure.skeleton.limbs:
            own = list(limb.joints)
            if float(np.abs(speeds[own]).max()) > quick:
                result[own] = 0.0
        return result

    @property
    def q(self) -> Array | None:
        """(J,) values of its joints [rad or m]."""
        if self._ragdoll is None:
            return None
        q = np.empty(len(self._order))
        q[self._order] = self._ragdoll.attitude.joints
        return q


def _body(began: float, one: Knock) -> Happening:
    time, place, normal = began + one.time, one.place, one.normal
    return Happening("body", time, -1, place, normal, one.speed, one.energy, link=one.bone)
