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
from pipeline.simulation.spatial import Array, matrix, turn, unturn
from pipeline.simulation.terrain import Ground

if TYPE_CHECKING:
    from pipeline.simulation.dynamics.ragdoll import Ragdoll


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
        assert self._ragdoll is not None
        knocks = self._ragdoll.advance(h)
        it = self._ragdoll.attitude
        R = matrix(it.q)
        w, arm = turn(R, it.w), turn(R, self._centre)
        state.p, state.v = it.p + arm, it.v + np.cross(w, arm)
        a, b, c, d = it.q.tolist()
        x, y, z = w.tolist()
        state.turning = (a, b, c, d), (x, y, z)
        return [
            Happening(
                "body",
                state.time + one.time,
                -1,
                one.place,
                one.normal,
                one.speed,
                one.energy,
                link=one.bone,
            )
            for one in knocks
        ]

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
