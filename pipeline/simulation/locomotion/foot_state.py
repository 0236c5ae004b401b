"""Foot state: where the feet of a herd stand, and how they swing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.curves import ease
from pipeline.simulation.locomotion.foot_placement.foothold_search import Foothold
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.spatial import Array

# Least time in which a body rises again that was lowered for a foothold, in cycles.
RELEASE = 0.5


@dataclass(slots=True, eq=False)
class FootState:
    """The feet of a herd with L legs.

    Attributes:
        start, end: (L, 3) tips at the ends of each leg's swing; a standing leg stands at `end` [m].
        swing_height: (L,) of each leg [m].
        bend: (L, m, 3) deviation of the swings from plain arches, None if all are plain [m].
        lowering: (2, L) of the body for each leg's foothold before `end`, and for that at `end`
            [m]. See `present_lowering`.
        held_up: (2, L) whether each foot was held up before this swing and will be after it, 0 or
            1.
        lift_phase: (L,) phase at which the swing began, whole cycles counted; of feet that have not
            swung -inf.
        swing_length: (L,) duration of the swing, in cycles.
        swinging: (L,) which feet are in the air.
        next_lift: (L,) phases at which standing feet lift, if their creatures go on.
        up: (L,) foot-up phases of legs whose gait does not change.
        changing: creatures whose gait changes.
        footholds: present or next one of each leg.
    """

    start: Array
    end: Array
    swing_height: Array
    bend: Array | None
    lowering: Array
    held_up: Array
    lift_phase: Array
    swing_length: Array
    swinging: NDArray[np.bool_]
    next_lift: Array
    up: Array
    changing: set[int] = field(default_factory=set)
    footholds: list[Foothold] = field(default_factory=list)

    @staticmethod
    def of(herd: Herd, bend: Array | None) -> FootState:
        """Return the state of feet that have not been placed."""
        legs = len(herd.owner)
        return FootState(
            start=np.zeros((legs, 3)),
            end=np.zeros((legs, 3)),
            swing_height=np.zeros(legs),
            bend=bend,
            lowering=np.zeros((2, legs)),
            held_up=np.zeros((2, legs)),
            lift_phase=np.full(legs, -np.inf),
            swing_length=herd.swings.copy(),
            swinging=np.zeros(legs, dtype=bool),
            next_lift=np.full(legs, np.inf),
            up=herd.up.copy(),
        )

    def copied(self) -> FootState:
        """Return a copy whose arrays stay as they are."""
        bend = None if self.bend is None else self.bend.copy()
        return replace(
            self, bend=bend, **{name: getattr(self, name).copy() for name in SWING_STATE}
        )

    @staticmethod
    def stacked(moments: Sequence[FootState]) -> FootState:
        """Return the states at n moments as one, with arrays (n, ...)."""
        bends = [feet.bend for feet in moments if feet.bend is not None]
        arrays: dict[str, Any] = {
            name: np.stack([getattr(feet, name) for feet in moments]) for name in SWING_STATE
        }
        return replace(moments[0], bend=np.stack(bends) if bends else None, **arrays)

    def bend_of(self, leg: int) -> Array | None:
        """Return the bend (m, 3) of a leg's swing."""
        return None if self.bend is None else self.bend[leg]


# Arrays that change with the swings, without `bend`.
SWING_STATE = (
    "start",
    "end",
    "swing_height",
    "lowering",
    "held_up",
    "lift_phase",
    "swing_length",
    "swinging",
    "next_lift",
)


def present_lowering(feet: FootState, phase: Array, s: Array | float = 1.0) -> Array:
    """Return how far bodies are lowered (..., L) for their feet [m].

    Legs reach as well from a low body, so it need not rise within a short swing.

    Args:
        feet: (..., L) where they are.
        phase: (..., L) of their bodies.
        s: (..., L) fractions of the swings, 1 for standing feet.
    """
    before, after = feet.lowering[..., 0, :], feet.lowering[..., 1, :]
    since = (phase - feet.lift_phase) / np.maximum(feet.swing_length, RELEASE)
    part = np.where(after < before, ease(np.clip(since, 0.0, 1.0)), ease(np.asarray(s)))
    result: Array = before + part * (after - before)
    return result


def place_foot(feet: FootState, leg: int, hold: Foothold) -> None:
    """Let a foot stand on a foothold, wherever it has been."""
    feet.start[leg] = feet.end[leg] = hold.tip
    feet.lowering[:, leg], feet.swing_height[leg] = hold.lowering, 0.0
    feet.footholds[leg], feet.swinging[leg] = hold, False
    if feet.bend is not None:
        feet.bend[leg] = 0.0


def start_swing(feet: FootState, leg: int, hold: Foothold, phase: float) -> None:
    """Let a foot swing from where it stands to a foothold, from `phase` on."""
    feet.start[leg], feet.end[leg] = feet.end[leg], hold.tip
    feet.lowering[:, leg] = float(present_lowering(feet, np.array(phase))[leg]), hold.lowering
    feet.held_up[:, leg] = 0.0
    feet.footholds[leg] = hold
    feet.swing_height[leg] = hold.swing_height


def hold_up(feet: FootState, leg: int, phase: float) -> None:
    """Hold a foot up from `phase` on."""
    feet.start[leg] = feet.end[leg]
    feet.swing_height[leg] = 0.0
    if feet.bend is not None:
        feet.bend[leg] = 0.0
    feet.lowering[:, leg] = float(present_lowering(feet, np.array(phase))[leg]), 0.0
    feet.held_up[:, leg] = feet.held_up[1, leg], 1.0
    feet.lift_phase[leg], feet.swinging[leg] = phase, True
