"""Foot roll: the directions of hooves, paws and feet, which legs alone would tilt with themselves.

A foot keeps its direction to the ground while it stands, rolls over its toe when its leg trails
behind, is flicked back as it leaves the ground, and comes down toe up: a sole on its heel, about
which the toe turns down until the foot is flat at the touchdown. All of it follows from where the
foot is, relative to its hip and to the ground: a foot that does not move does not turn, one that
moves twice as fast turns twice as fast, and it goes on through changes of gait and speed without a
gap.

Source: Hildebrand 1960 for the order of events; angles of people after Winter 1991 (the heel rises
by some 60 degrees until the toe leaves the ground, and the sole is at 20 to 25 when it comes down),
of hooves as seen in films of horses.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.curves import bounded, ease
from pipeline.simulation.figures.foot_link import STEEP, last_links, slopes
from pipeline.simulation.locomotion.foot_state import FootState
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.spatial import Array, turn, turn_inverse
from pipeline.simulation.terrain import Ground


@dataclass(frozen=True, slots=True)
class RollAngles:
    """How feet of one posture roll [rad].

    Attributes:
        roll: over the toe, when the leg trails most.
        flick: backward, in the air behind the hip.
        toe_up: in the air before the hip.
        lands_on_heel: whether the heel comes down first, and the toe turns down about it.
    """

    roll: float
    flick: float
    toe_up: float
    lands_on_heel: bool


SOLE, TOES = RollAngles(0.9, 0.25, 0.38, True), RollAngles(0.4, 0.55, 0.1, False)
"""Feet that stand on their soles, and those that stand on toes or hooves."""

SLOPING_TOE_UP = 0.2
"""Greatest angle by which a toe goes up of a foot that slopes [rad]."""

TRAILING = -0.05, 0.55
"""Distance of a foot behind its hip between which it rolls, in leg lengths."""

AHEAD = -0.25, 0.25
"""Distance of a foot behind its hip between which toes that are up turn to heels."""

LIFT_RATE, MOST_RATE = 1.5, 8.0
"""Angle by which a foot turns when it begins to rise, and most angle by which the toe of one that
lands on its heel does, per leg length [rad]."""


@dataclass(frozen=True, slots=True, eq=False)
class Steps:
    """Steps of a herd at n moments.

    Attributes:
        feet: where they stand, come from and go to.
        s: (n, L) fractions of the swings, 1 for standing feet.
        weight: (n, C) how far creatures walk, 1, rather than jump, 0.
    """

    feet: FootState
    s: Array
    weight: Array


class FootRoll:
    """Directions of the last links of a herd's legs."""

    def __init__(self, herd: Herd, ground: Ground) -> None:
        self.herd, self.ground = herd, ground
        legs = herd.legs
        has_foot = np.zeros(len(legs.lengths), dtype=bool)
        for chain in herd.chains:
            has_foot[chain.rows] = chain.foot is not None
        self._own = own = np.flatnonzero(has_foot)
        self._last = np.zeros((len(legs.lengths), 3))
        link = last_links(legs)[own] if len(own) else np.zeros((0, 3))
        # In the plane in which legs swing: forward, and up.
        self._angle = np.arctan2(link[:, 1], link[:, 0])
        self._roll, self._flick, self._toe_up, on_heel = (
            np.where(slopes(link) > STEEP, getattr(TOES, name), getattr(SOLE, name))
            for name in ("roll", "flick", "toe_up", "lands_on_heel")
        )
        # A toe that turns up as fast as the tip rises leaves the heel on the ground.
        sole = herd.soles[own] / legs.lengths[own]
        on_heel = on_heel & (sole > 1.0 / MOST_RATE)
        # The others do not come down on their heels, whose last links slope.
        self._toe_up = np.where(on_heel, self._toe_up, np.minimum(self._toe_up, SLOPING_TOE_UP))
        self._toe_rate = np.where(on_heel, 1.0 / np.maximum(sole, 1.0 / MOST_RATE), LIFT_RATE)

    def directions(
        self,
        tips: Array,
        bodies: tuple[Array, Array],
        limp: NDArray[np.bool_],
        steps: Steps | None = None,
    ) -> Array | None:
        """Return the wanted directions (n, L, 3) of last links in the frames of their bodies.

        Args:
            tips: (n, L, 3) at n moments [m].
            bodies: R_WB (n, C, 3, 3) and p_WB (n, C, 3) [m].
            limp: (n, C) fallen creatures, whose feet stay as they are.
            steps: of the feet; without, they keep level and roll alone, as in jumps.

        Returns:
            Zero where legs do as they like; None where no leg has a foot.
        """
        own = self._own
        if not len(own):
            return None
        herd, (R_WB, p_WB) = self.herd, bodies
        owner, lengths = herd.owner[own], herd.legs.lengths[own]
        R = R_WB[:, owner]
        forward = R[..., [0, 2], 0]
        forward /= np.maximum(np.linalg.norm(forward, axis=-1, keepdims=True), 1e-9)
        hips = p_WB[:, owner] + turn(R, herd.hips[own])
        away = (tips[:, own] - hips)[..., [0, 2]]
        behind = -(away * forward).sum(axis=-1) / lengths
        first, last = TRAILING
        trails = ease(np.clip((behind - first) / (last - first), 0.0, 1.0))
        angle = self._angle - self._roll * trails
        if steps is not None:
            angle = angle + self._step_angles(steps, tips, forward, behind)
        level = np.cos(angle)[..., None] * forward
        there = np.stack([level[..., 0], np.sin(angle), level[..., 1]], axis=-1)
        result = np.zeros_like(tips)
        result[:, own] = turn_inverse(R, there)
        return self._held(result, limp)

    def _step_angles(self, steps: Steps, tips: Array, forward: Array, behind: Array) -> Array:
        """Return how far steps and slopes turn feet (n, l) [rad].

        Args:
            steps: of all feet.
            tips: (n, L, 3) [m].
            forward: (n, l, 2) level directions of the bodies.
            behind: (n, l) distances of feet behind their hips, in leg lengths.
        """
        own, feet = self._own, steps.feet
        first, last = AHEAD
        heels = ease(np.clip((behind - first) / (last - first), 0.0, 1.0))
        s, start, end = steps.s[:, own], feet.start[:, own], feet.end[:, own]
        level = start[..., 1] + ease(s) * (end - start)[..., 1]
        rise = np.maximum(tips[:, own, 1] - level, 0.0) / self.herd.legs.lengths[own]
        flick = self._flick * bounded(LIFT_RATE * rise / self._flick)
        up = self._toe_up * bounded(self._toe_rate * rise / self._toe_up)
        slope = self._slopes(start, forward)
        slope += ease(s) * (self._slopes(end, forward) - slope)
        result: Array = steps.weight[:, self.herd.owner[own]] * (up - heels * (flick + up) + slope)
        return result

    def _held(self, directions: Array, limp: NDArray[np.bool_]) -> Array:
        """Return directions (n, L, 3) in which those of fallen creatures stay."""
        for row in np.flatnonzero(limp.any(axis=1)).tolist():
            before = directions[row - 1] if row else self._last
            fallen = limp[row, self.herd.owner]
            directions[row, fallen] = before[fallen]
        self._last = directions[-1].copy()
        return directions

    def _slopes(self, places: Array, forward: Array) -> Array:
        """Return the slopes of the ground (n, l) along `forward` (n, l, 2) at places [rad]."""
        shape = places.shape[:-1]
        x, _, z = places.reshape(-1, 3).T
        normal = self.ground.normal(x, z).reshape(*shape, 3)
        along = (normal[..., [0, 2]] * forward).sum(axis=-1)
        return -np.arctan2(along, normal[..., 1])
