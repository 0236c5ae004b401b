"""Errands: what a script asks of a pronker, as jumps one after the other.

Source: Sims 1987, 3.2.4 and 11.3.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.locomotion.pronking.course import Leap
from pipeline.simulation.locomotion.pronking.hurdle import hurdle_on
from pipeline.simulation.locomotion.pronking.parameters import Jump
from pipeline.simulation.locomotion.pronking.pronker import Pronker
from pipeline.simulation.locomotion.pronking.state import State
from pipeline.simulation.locomotion.pronking.vaulting import (
    before,
    half_width,
    stand_before,
    vault,
)
from pipeline.simulation.locomotion.routes.route import heading_vector
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground

FARTHER = 1.15
"""How much longer than usual a jump may be that saves another one."""

THERE = 0.04
"""Distance from a place that is not worth a jump, in leg lengths."""

MOST_TURN = math.radians(70.0)
"""By which one jump turns at most."""

PIROUETTE = 0.35
"""Height of a jump that only turns, in that of a usual one."""

TRIES = 12
"""Jumps in which a place before a hurdle is to be reached, beside those of the way."""


@dataclass(frozen=True, eq=False)
class Once:
    """One jump, straight on.

    Attributes:
        jump: that is asked for.
    """

    jump: Jump

    def leap(self, of: Pronker, state: State, ground: Ground) -> Leap | str:
        """Return it."""
        return Leap(self.jump.up, state.facing, forward=self.jump.forward)


@dataclass(frozen=True, eq=False)
class OnceTo:
    """One jump to a place.

    Attributes:
        spot: (x, z) [m].
        jump: whose height it has above the ground there.
    """

    spot: tuple[float, float]
    jump: Jump

    def leap(self, of: Pronker, state: State, ground: Ground) -> Leap | str:
        """Return it."""
        return Leap(_up_to(state, ground, self.spot, self.jump), state.facing, self.spot)


@dataclass(eq=False)
class TurnBy:
    """Jumps on the spot that turn.

    Attributes:
        left: by how much it is still to turn [rad].
    """

    left: float

    def leap(self, of: Pronker, state: State, ground: Ground) -> Leap | str:
        """Return the next."""
        part = min(max(self.left, -MOST_TURN), MOST_TURN)
        if part == 0.0:
            return ""
        self.left -= part
        state.going += part
        up = math.sqrt(PIROUETTE) * state.course.jump.up
        return Leap(up, state.facing + part, last=self.left == 0.0)


@dataclass(eq=False)
class GoThere:
    """Jumps to a place, the last of which lands on it.

    Attributes:
        spot: (x, z) [m].
        last: whether the errand ends there.
    """

    spot: tuple[float, float]
    last: bool = True

    def leap(self, of: Pronker, state: State, ground: Ground) -> Leap | str:
        """Return the next."""
        here = _middle(of, state)
        way = np.array(self.spot) - here
        far = float(np.hypot(*way))
        if far < THERE * of.leg:
            return ""
        towards = math.atan2(-way[1], way[0])
        aside = math.remainder(towards - state.facing, 2.0 * math.pi)
        if abs(aside) > MOST_TURN and far > 0.5 * of.leg:
            part = math.copysign(MOST_TURN, aside)
            state.going = state.facing + part
            up = math.sqrt(PIROUETTE) * state.course.jump.up
            return Leap(up, state.going, last=False)
        facing = state.facing + aside if far > 0.5 * of.leg else state.facing
        jump = state.course.jump
        count = max(math.ceil(far / (FARTHER * max(jump.distance, THERE * of.leg))), 1)
        x, z = (here + way / count).tolist()
        state.going = facing
        up = _up_to(state, ground, (x, z), jump)
        return Leap(up, facing, (x, z), last=self.last and count == 1)


@dataclass(eq=False)
class HopOver:
    """Jumps to before a hurdle, and over it.

    Attributes:
        name: of what is jumped over.
        solids: corners (n, 3) of it, in the world [m].
        comes: whether it hops to where it can jump over it, or jumps from where it is.
        stand: (x, z) from where, once that is known [m].
        heading: in which it jumps then [rad].
        tries: jumps made to get there.
    """

    name: str
    solids: Sequence[Array]
    comes: bool = True
    stand: tuple[float, float] | None = None
    heading: float = 0.0
    tries: int = 0

    def leap(self, of: Pronker, state: State, ground: Ground) -> Leap | str:
        """Return the next."""
        here = state.now(of).origin[[0, 2]]
        if self.stand is None:
            self.heading = heading_to(of, self.solids, here, state.going)
        hurdle = hurdle_on(self.solids, here, self.heading, half_width(of))
        if hurdle is None or hurdle.far < 0.0:
            return f"'{self.name}' is not there to jump over any more"
        cause = "it does not come close enough"
        turned = math.remainder(self.heading - state.now(of).heading, 2.0 * math.pi)
        clear = hurdle.near > before(of)
        if clear and abs(turned) < MOST_TURN and hurdle.near < 4.0 * of.leg:
            one = vault(of, state, ground, hurdle, self.heading)
            if not isinstance(one, str):
                state.going = self.heading
                return one.leap
            cause = one
        if not self.comes:
            return f"cannot jump over '{self.name}': {cause}"
        if self.stand is None:
            found = stand_before(of, state, ground, hurdle, self.heading)
            if isinstance(found, str):
                return f"cannot jump over '{self.name}': {found}"
            x, z = (here + (hurdle.near - found[0]) * heading_vector(self.heading)).tolist()
            self.stand, self.tries = (x, z), TRIES
            self.tries += math.ceil(abs(hurdle.near - found[0]) / max(0.1, of.jump.distance))
        self.tries -= 1
        step = GoThere(self.stand, last=False).leap(of, state, ground)
        if isinstance(step, str) or self.tries < 0:
            return f"cannot jump over '{self.name}': {cause}"
        return step


def heading_to(of: Pronker, solids: Sequence[Array], here: Array, going: float) -> float:
    """Return where to go to come to solids: straight on if they are there, else to their middle.

    Args:
        of: who goes.
        solids: their corners (n, 3) [m].
        here: (x, z) where it is [m].
        going: where it goes [rad].
    """
    ahead = hurdle_on(solids, here, going, half_width(of))
    if ahead is not None and ahead.far > 0.0:
        return going
    corners = np.concatenate(list(solids))[:, [0, 2]]
    x, z = 0.5 * (corners.min(axis=0) + corners.max(axis=0)) - here
    return math.atan2(-z, x)


def _middle(of: Pronker, state: State) -> Array:
    """Return (x, z) of the middle of the feet that are down [m]."""
    tips = state.tips[state.down]
    result: Array = tips[:, [0, 2]].mean(axis=0) if len(tips) else state.now(of).origin[[0, 2]]
    return result


def _up_to(state: State, ground: Ground, spot: tuple[float, float], jump: Jump) -> float:
    """Return with which upward speed a jump is as high above its landing as above its begin."""
    rise = max(float(ground.height(np.array(spot[0]), np.array(spot[1]))) - state.floor, 0.0)
    return Jump(0.0, jump.height + rise).up
