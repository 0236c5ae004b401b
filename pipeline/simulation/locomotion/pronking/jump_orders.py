"""Errands: what a script asks of a pronker, as jumps one after the other.

Source: Sims 1987, 3.2.4 and 11.3.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.locomotion.pronking.hop_phases import wake_if_jumping
from pipeline.simulation.locomotion.pronking.hop_simulation import HopSimulation
from pipeline.simulation.locomotion.pronking.hop_state import HopState, PlannedJump
from pipeline.simulation.locomotion.pronking.hopper import LIFT_OFF_STRETCH, Hopper
from pipeline.simulation.locomotion.pronking.hurdle_jump import (
    clearance_half_width,
    front_reach,
    hurdle_profile,
    plan_take_off,
    plan_vault,
)
from pipeline.simulation.locomotion.pronking.jump_parameters import Jump, resolve_jump
from pipeline.simulation.locomotion.routes.route import heading_vector
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground
from pipeline.spec.creature import Pronk
from pipeline.spec.script import Do, GoTo, HopOver, JumpOnce, JumpWords, SetSpeed, TurnBy, Wait

STRETCH_LIMIT = 1.15
"""How much longer than usual a jump may be that saves another one."""

ARRIVAL_DISTANCE = 0.04
"""Distance from a place that is not worth a jump, in leg lengths."""

MAX_TURN = math.radians(70.0)
"""By which one jump turns at most."""

TURN_JUMP_HEIGHT = 0.35
"""Height of a jump that only turns, in that of a usual one."""

EXTRA_ATTEMPTS = 12
"""Jumps in which a place before a hurdle is to be reached, beside those of the way."""


@dataclass(frozen=True, eq=False)
class SingleJump:
    """One jump, straight on.

    Attributes:
        jump: that is asked for.
    """

    jump: Jump

    def leap(self, of: Hopper, state: HopState, ground: Ground) -> PlannedJump | str:
        """Return it."""
        return PlannedJump(self.jump.up, state.facing, forward=self.jump.forward)


@dataclass(frozen=True, eq=False)
class JumpToPoint:
    """One jump to a place.

    Attributes:
        spot: (x, z) [m].
        jump: whose height it has above the ground there.
    """

    spot: tuple[float, float]
    jump: Jump

    def leap(self, of: Hopper, state: HopState, ground: Ground) -> PlannedJump | str:
        """Return it."""
        return PlannedJump(
            _upward_speed(state, ground, self.spot, self.jump), state.facing, self.spot
        )


@dataclass(eq=False)
class TurnJumps:
    """Jumps on the spot that turn.

    Attributes:
        left: by how much it is still to turn [rad].
    """

    left: float

    def leap(self, of: Hopper, state: HopState, ground: Ground) -> PlannedJump | str:
        """Return the next."""
        part = min(max(self.left, -MAX_TURN), MAX_TURN)
        if part == 0.0:
            return ""
        self.left -= part
        state.going += part
        up = math.sqrt(TURN_JUMP_HEIGHT) * state.course.jump.up
        return PlannedJump(up, state.facing + part, last=self.left == 0.0)


@dataclass(eq=False)
class HopToPoint:
    """Jumps to a place, the last of which lands on it.

    Attributes:
        spot: (x, z) [m].
        last: whether the errand ends there.
    """

    spot: tuple[float, float]
    last: bool = True

    def leap(self, of: Hopper, state: HopState, ground: Ground) -> PlannedJump | str:
        """Return the next."""
        here = _feet_centre(of, state)
        way = np.array(self.spot) - here
        far = float(np.hypot(*way))
        if far < ARRIVAL_DISTANCE * of.leg:
            return ""
        towards = math.atan2(-way[1], way[0])
        aside = math.remainder(towards - state.facing, 2.0 * math.pi)
        if abs(aside) > MAX_TURN and far > 0.5 * of.leg:
            part = math.copysign(MAX_TURN, aside)
            state.going = state.facing + part
            up = math.sqrt(TURN_JUMP_HEIGHT) * state.course.jump.up
            return PlannedJump(up, state.going, last=False)
        facing = state.facing + aside if far > 0.5 * of.leg else state.facing
        jump = state.course.jump
        count = max(
            math.ceil(far / (STRETCH_LIMIT * max(jump.distance, ARRIVAL_DISTANCE * of.leg))), 1
        )
        x, z = (here + way / count).tolist()
        state.going = facing
        up = _upward_speed(state, ground, (x, z), jump)
        return PlannedJump(up, facing, (x, z), last=self.last and count == 1)


@dataclass(eq=False)
class HurdleJump:
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

    def leap(self, of: Hopper, state: HopState, ground: Ground) -> PlannedJump | str:
        """Return the next."""
        here = state.now(of).origin[[0, 2]]
        if self.stand is None:
            self.heading = heading_towards(of, self.solids, here, state.going)
        hurdle = hurdle_profile(self.solids, here, self.heading, clearance_half_width(of))
        if hurdle is None or hurdle.far < 0.0:
            return f"'{self.name}' is not there to jump over any more"
        cause = "it does not come close enough"
        turned = math.remainder(self.heading - state.now(of).heading, 2.0 * math.pi)
        clear = hurdle.near > front_reach(of)
        if clear and abs(turned) < MAX_TURN and hurdle.near < 4.0 * of.leg:
            one = plan_vault(of, state, ground, hurdle, self.heading)
            if not isinstance(one, str):
                state.going = self.heading
                return one.leap
            cause = one
        if not self.comes:
            return f"cannot jump over '{self.name}': {cause}"
        if self.stand is None:
            found = plan_take_off(of, state, ground, hurdle, self.heading)
            if isinstance(found, str):
                return f"cannot jump over '{self.name}': {found}"
            x, z = (here + (hurdle.near - found[0]) * heading_vector(self.heading)).tolist()
            self.stand, self.tries = (x, z), EXTRA_ATTEMPTS
            self.tries += math.ceil(abs(hurdle.near - found[0]) / max(0.1, of.jump.distance))
        self.tries -= 1
        step = HopToPoint(self.stand, last=False).leap(of, state, ground)
        if isinstance(step, str) or self.tries < 0:
            return f"cannot jump over '{self.name}': {cause}"
        return step


def heading_towards(of: Hopper, solids: Sequence[Array], here: Array, going: float) -> float:
    """Return where to go to come to solids: straight on if they are there, else to their middle.

    Args:
        of: who goes.
        solids: their corners (n, 3) [m].
        here: (x, z) where it is [m].
        going: where it goes [rad].
    """
    ahead = hurdle_profile(solids, here, going, clearance_half_width(of))
    if ahead is not None and ahead.far > 0.0:
        return going
    corners = np.concatenate(list(solids))[:, [0, 2]]
    x, z = 0.5 * (corners.min(axis=0) + corners.max(axis=0)) - here
    return math.atan2(-z, x)


def _feet_centre(of: Hopper, state: HopState) -> Array:
    """Return (x, z) of the middle of the feet that are down [m]."""
    tips = state.tips[state.down]
    result: Array = tips[:, [0, 2]].mean(axis=0) if len(tips) else state.now(of).origin[[0, 2]]
    return result


def _upward_speed(state: HopState, ground: Ground, spot: tuple[float, float], jump: Jump) -> float:
    """Return with which upward speed a jump is as high above its landing as above its begin."""
    rise = max(float(ground.height(np.array(spot[0]), np.array(spot[1]))) - state.floor, 0.0)
    return Jump(0.0, jump.height + rise).up


Solids = Mapping[str, Sequence[Array]]
"""Corners (n, 3) of the solids of performers, in the world [m]."""


def apply_order(hopping: HopSimulation, order: Do, solids: Solids) -> None:
    """Let a creature do as it is told from its next jump on."""
    kind = type(order) if not isinstance(order, str) else order
    ORDER_HANDLERS[kind](hopping, order, solids)
    wake_if_jumping(hopping.of, hopping.state)


def scripted_jump(of: Hopper, words: JumpWords, where: str) -> Jump:
    """Return the jump that a script asks for.

    Args:
        of: who jumps.
        words: how.
        where: path of the words in the scene.

    Raises:
        SceneError: no jump is so.
    """
    given = {
        word: value
        for word in ("distance", "height", "speed")
        if (value := getattr(words, word)) is not None
    }
    if not given:
        return of.jump
    if set(given) == {"height"} and words.land_at is None:
        return Jump(of.jump.distance, given["height"])
    return resolve_jump(where, Pronk(**given), of.tallest(LIFT_OFF_STRETCH, 0.0))


def _resume_hopping(hopping: HopSimulation, order: Do, solids: Solids) -> None:
    """Hop on as its words say."""
    del order, solids
    hopping.state.course.onward = True


def _stop(hopping: HopSimulation, order: Do, solids: Solids) -> None:
    """Stand when the present jump has landed."""
    del order, solids
    course = hopping.state.course
    course.onward = False
    pushes = hopping.state.phase == "pushing" and course.leap is not None
    # What it pushes for already it jumps, but no more of that.
    course.errands = course.errands[:1] if pushes else []
    if course.leap is not None:
        course.leap = replace(course.leap, last=True)


def _go_to(hopping: HopSimulation, order: GoTo, solids: Solids) -> None:
    _stop(hopping, order, solids)
    hopping.state.course.errands.append(HopToPoint(order.go_to))


def _turn_by(hopping: HopSimulation, order: TurnBy, solids: Solids) -> None:
    del solids
    hopping.state.course.errands.append(TurnJumps(math.radians(order.turn_deg)))


def _set_speed(hopping: HopSimulation, order: SetSpeed, solids: Solids) -> None:
    """Jump at the same angle, faster or slower: speed² = g h (r² / 8 + 2) with d = r h."""
    del solids
    course = hopping.state.course
    ratio = course.jump.distance / course.jump.height
    height = order.speed**2 / (GRAVITY * (ratio * ratio / 8.0 + 2.0))
    course.jump = Jump(ratio * height, height)


def _hop_over(hopping: HopSimulation, order: HopOver, solids: Solids) -> None:
    seen = solids.get(order.hop_over, ())
    hopping.state.course.errands.append(HurdleJump(order.hop_over, seen))


def _jump_once(hopping: HopSimulation, order: JumpOnce, solids: Solids) -> None:
    del solids
    jump = scripted_jump(hopping.of, order.jump, "do.jump")
    spot = order.jump.land_at
    jump_order = SingleJump(jump) if spot is None else JumpToPoint(spot, jump)
    hopping.state.course.errands.append(jump_order)


ORDER_HANDLERS: dict[Any, Callable[[HopSimulation, Any, Solids], None]] = {
    "hop": _resume_hopping,
    "walk": _resume_hopping,
    "stop": _stop,
    Wait: _stop,
    GoTo: _go_to,
    TurnBy: _turn_by,
    SetSpeed: _set_speed,
    HopOver: _hop_over,
    JumpOnce: _jump_once,
}
"""`walk` is what comes after a `wait`."""
