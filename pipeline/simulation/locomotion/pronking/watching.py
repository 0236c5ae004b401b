"""Watching: what may happen to a pronker within a phase, as margins that come to nothing.

Feet in the air are looked for on the ground while the body falls; while it rises they are
lifted over what is in their way. Feet that are down are watched for how far legs stretch and,
while the body sinks, how far they fold.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.simulation.locomotion.pronking.pronker import HOLDS, Pronker
from pipeline.simulation.locomotion.pronking.state import Moved, State
from pipeline.simulation.locomotion.swing.swing_trajectory import lowest_center_height
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground

GRACE = 0.16
"""How far a body sinks after a first foot touched until its legs carry, in leg lengths."""

FOLDED = 1.01
"""How near to their hips legs draw feet at most, in what they can."""

RISING = 1e-9
"""Vertical speed at which a body is not falling yet [m/s]."""


@dataclass(frozen=True, eq=False)
class Margins:
    """What is left until something happens; infinite for what cannot [m].

    Attributes:
        touch: (n,) feet above the ground.
        stretch, fold: (n,) legs.
        belly: (1,) the body above the ground.
        grace: (1,) way that the body may sink.
    """

    touch: Array
    stretch: Array
    fold: Array
    belly: Array
    grace: Array

    @property
    def all(self) -> Array:
        """All of them one after the other."""
        return np.concatenate([self.touch, self.stretch, self.fold, self.belly, self.grace])


def margins(of: Pronker, state: State, ground: Ground, at: Moved, highest: float) -> Margins:
    """Return what is left at some time of the phase.

    Args:
        of: the creature.
        state: at the begin of a sub-step.
        ground: below it.
        at: where it is at the time.
        highest: point of the ground [m].
    """
    n = len(of.hips)
    touch, stretch, fold, belly, grace = (np.full(k, np.inf) for k in (n, n, n, 1, 1))
    falls = at.v[1] <= RISING
    if state.phase in ("flight", "landing") and falls and not state.down.all():
        tips = at.points(state.swing.tips(at.time))
        if float(tips[:, 1].min()) - float(of.soles.max()) < highest + 0.05:
            air = ~state.down & ~state.released
            touch[air] = (
                tips[:, 1] - lowest_center_height(ground, tips[:, 0], tips[:, 2], of.soles)
            )[air]
    if state.down.any() and state.phase not in ("standing",):
        way = at.points(of.hips) - state.tips
        far = np.sqrt((way * way).sum(axis=-1))
        down = state.down
        stretch[down] = (HOLDS * of.lengths - far)[down]
        if state.phase in ("flight", "landing"):
            fold[down] = (far - FOLDED * of.folds)[down]
    if state.armed and state.phase != "standing":
        belly[0] = body_gap(of, ground, at, highest)
    if state.phase == "flight" and state.down.any():
        grace[0] = at.p[1] - (state.first - GRACE * of.leg)
    return Margins(touch, stretch, fold, belly, grace)


def body_gap(of: Pronker, ground: Ground, at: Moved, highest: float = np.inf) -> float:
    """Return how high the body is above the ground, at least [m]."""
    points = at.points(of.belly)
    if float(points[:, 1].min()) > highest + 0.5:
        return float(points[:, 1].min()) - highest
    return float((points[:, 1] - ground.height(points[:, 0], points[:, 2])).min())


def over_ground(of: Pronker, ground: Ground, tips: Array, highest: float) -> Array:
    """Return feet (n, 3) lifted out of the ground [m]."""
    if float(tips[:, 1].min()) - float(of.soles.max()) > highest:
        return tips
    result = tips.copy()
    np.maximum(
        tips[:, 1], lowest_center_height(ground, tips[:, 0], tips[:, 2], of.soles), out=result[:, 1]
    )
    return result
