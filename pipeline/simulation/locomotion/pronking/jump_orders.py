"""Scripted orders for hoppers, as sequences of jumps.

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
from pipeline.simulation.locomotion.pronking.hop_state import HopState, JumpOrder, PlannedJump
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
from pipeline.simulation.members import MemberState, goal_place
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground
from pipeline.spec.creature import Pronk
from pipeline.spec.script import Do, GoTo, HopOver, JumpOnce, JumpSettings, SetSpeed, TurnBy, Wait

STRETCH_LIMIT = 1.15
"""Longest jump that saves an extra one, in usual distances."""

ARRIVAL_DISTANCE = 0.04
"""Distance from a target that is not worth a jump, in leg lengths."""

MAX_TURN = math.radians(70.0)
"""Greatest turn of one jump [rad]."""

TURN_JUMP_HEIGHT = 0.35
"""Height of a jump that only turns, in usual heights."""

FALLEN = "it has fallen"
"""Reason for which orders are given up after a fall."""

EXTRA_ATTEMPTS = 12
"""Jumps allowed to reach a place before a hurdle, beyond those of the way."""


Members = Mapping[str, MemberState]
"""States of the members that orders name."""


@dataclass(frozen=True, eq=False)
class SingleJump:
    """One jump straight on.

    Attributes:
        jump: its parameters.
    """

    jump: Jump

    def next_jump(self, hopper: Hopper, state: HopState, ground: Ground) -> PlannedJump | str:
        """Return the jump."""
        return PlannedJump(self.jump.up, state.next_heading, forward=self.jump.forward)


@dataclass(frozen=True, eq=False)
class JumpToPoint:
    """One jump to a place.

    Attributes:
        target: (x, z) [m].
        jump: gives its height above the ground there.
    """

    target: tuple[float, float]
    jump: Jump

    def next_jump(self, hopper: Hopper, state: HopState, ground: Ground) -> PlannedJump | str:
        """Return the jump."""
        return PlannedJump(
            _upward_speed(state, ground, self.target, self.jump), state.next_heading, self.target
        )


@dataclass(eq=False)
class TurnJumps:
    """Jumps on the spot that turn the body.

    Attributes:
        remaining: angle still to turn [rad].
    """

    remaining: float

    def next_jump(self, hopper: Hopper, state: HopState, ground: Ground) -> PlannedJump | str:
        """Return the next jump."""
        part = min(max(self.remaining, -MAX_TURN), MAX_TURN)
        if part == 0.0:
            return ""
        self.remaining -= part
        state.travel_heading += part
        up = math.sqrt(TURN_JUMP_HEIGHT) * state.queue.jump.up
        return PlannedJump(up, state.next_heading + part, is_last=self.remaining == 0.0)


@dataclass(eq=False)
class HopToPoint:
    """Jumps to a place; the last one lands on it.

    Attributes:
        target: (x, z) [m].
        is_last: whether the order ends there.
    """

    target: tuple[float, float]
    is_last: bool = True

    def next_jump(self, hopper: Hopper, state: HopState, ground: Ground) -> PlannedJump | str:
        """Return the next jump."""
        here = _feet_centre(hopper, state)
        offset = np.array(self.target) - here
        distance = float(np.hypot(*offset))
        if distance < ARRIVAL_DISTANCE * hopper.leg_length:
            return ""
        bearing = math.atan2(-offset[1], offset[0])
        aside = math.remainder(bearing - state.next_heading, 2.0 * math.pi)
        if abs(aside) > MAX_TURN and distance > 0.5 * hopper.leg_length:
            part = math.copysign(MAX_TURN, aside)
            state.travel_heading = state.next_heading + part
            up = math.sqrt(TURN_JUMP_HEIGHT) * state.queue.jump.up
            return PlannedJump(up, state.travel_heading, is_last=False)
        heading = (
            state.next_heading + aside if distance > 0.5 * hopper.leg_length else state.next_heading
        )
        jump = state.queue.jump
        count = max(
            math.ceil(
                distance
                / (STRETCH_LIMIT * max(jump.distance, ARRIVAL_DISTANCE * hopper.leg_length))
            ),
            1,
        )
        x, z = (here + offset / count).tolist()
        state.travel_heading = heading
        up = _upward_speed(state, ground, (x, z), jump)
        return PlannedJump(up, heading, (x, z), is_last=self.is_last and count == 1)


@dataclass(eq=False)
class HurdleJump:
    """Jumps to a place before a hurdle, and over it.

    Attributes:
        name: of the performer that is jumped over.
        solids: its corners (n, 3), in the world [m].
        can_approach: whether it may hop to a better place before it jumps.
        stand: (x, z) of that place, once known [m].
        heading: of the jump [rad].
        tries: jumps left to get there.
    """

    name: str
    solids: Sequence[Array]
    can_approach: bool = True
    stand: tuple[float, float] | None = None
    heading: float = 0.0
    tries: int = 0

    def next_jump(self, hopper: Hopper, state: HopState, ground: Ground) -> PlannedJump | str:
        """Return the next jump."""
        here = state.body(hopper).origin[[0, 2]]
        if self.stand is None:
            self.heading = heading_towards(hopper, self.solids, here, state.travel_heading)
        hurdle = hurdle_profile(self.solids, here, self.heading, clearance_half_width(hopper))
        if hurdle is None or hurdle.far < 0.0:
            return f"'{self.name}' is not there to jump over any more"
        reason = "it does not come close enough"
        turn = math.remainder(self.heading - state.body(hopper).heading, 2.0 * math.pi)
        is_clear = hurdle.near > front_reach(hopper)
        if is_clear and abs(turn) < MAX_TURN and hurdle.near < 4.0 * hopper.leg_length:
            vault = plan_vault(hopper, state, ground, hurdle, self.heading)
            if not isinstance(vault, str):
                state.travel_heading = self.heading
                return vault.planned
            reason = vault
        if not self.can_approach:
            return f"cannot jump over '{self.name}': {reason}"
        if self.stand is None:
            take_off = plan_take_off(hopper, state, ground, hurdle, self.heading)
            if isinstance(take_off, str):
                return f"cannot jump over '{self.name}': {take_off}"
            x, z = (here + (hurdle.near - take_off[0]) * heading_vector(self.heading)).tolist()
            self.stand, self.tries = (x, z), EXTRA_ATTEMPTS
            self.tries += math.ceil(abs(hurdle.near - take_off[0]) / max(0.1, hopper.jump.distance))
        self.tries -= 1
        step = HopToPoint(self.stand, is_last=False).next_jump(hopper, state, ground)
        if isinstance(step, str) or self.tries < 0:
            return f"cannot jump over '{self.name}': {reason}"
        return step


def heading_towards(hopper: Hopper, solids: Sequence[Array], here: Array, going: float) -> float:
    """Return the heading to solids: straight on if they are ahead, else towards their middle.

    Args:
        hopper: the creature.
        solids: their corners (n, 3) [m].
        here: (x, z) of the creature [m].
        going: its heading [rad].
    """
    ahead = hurdle_profile(solids, here, going, clearance_half_width(hopper))
    if ahead is not None and ahead.far > 0.0:
        return going
    corners = np.concatenate(list(solids))[:, [0, 2]]
    x, z = 0.5 * (corners.min(axis=0) + corners.max(axis=0)) - here
    return math.atan2(-z, x)


def _feet_centre(hopper: Hopper, state: HopState) -> Array:
    """Return the mean (x, z) of the feet that are down [m]."""
    tips = state.tips[state.down]
    return tips[:, [0, 2]].mean(axis=0) if len(tips) else state.body(hopper).origin[[0, 2]]


def _upward_speed(
    state: HopState, ground: Ground, target: tuple[float, float], jump: Jump
) -> float:
    """Return the speed of a jump that rises as high above its landing as above its start [m/s]."""
    height = float(ground.height(np.array(target[0]), np.array(target[1])))
    rise = max(height - state.floor_height, 0.0)
    return Jump(0.0, jump.height + rise).up


def apply_order(simulation: HopSimulation, order: Do, members: Members) -> JumpOrder | None:
    """Apply a scripted order from the next jump on; return its jumps, None if it has none."""
    kind, queue = type(order) if not isinstance(order, str) else order, simulation.state.queue
    before = list(queue.orders)
    ORDER_HANDLERS[kind](simulation, order, members)
    wake_if_jumping(simulation.hopper, simulation.state)
    return next((jumps for jumps in queue.orders if jumps not in before), None)


def scripted_jump(hopper: Hopper, config: JumpSettings, where: str) -> Jump:
    """Return the parameters of a scripted jump.

    Args:
        hopper: the creature.
        config: the `jump` block.
        where: path of the block in the scene.

    Raises:
        SceneError: the values contradict each other.
    """
    values = {
        key: value
        for key in ("distance", "height", "speed")
        if (value := getattr(config, key)) is not None
    }
    if not values:
        return hopper.jump
    if set(values) == {"height"} and config.land_at is None:
        return Jump(hopper.jump.distance, values["height"])
    return resolve_jump(where, Pronk(**values), hopper.greatest_height(LIFT_OFF_STRETCH, 0.0))


def _resume_hopping(simulation: HopSimulation, order: Do, members: Members) -> None:
    """Make configured jumps from now on."""
    del order, members
    queue = simulation.state.queue
    queue.keep_hopping, queue.hops_from = True, 0.0


def _stop(simulation: HopSimulation, order: Do, members: Members) -> None:
    """Stop after the current jump."""
    del order, members
    queue = simulation.state.queue
    queue.keep_hopping = False
    pushes = simulation.state.phase == "pushing" and queue.planned is not None
    # A jump that is already pushed for is made, but is the last of its order.
    queue.orders = queue.orders[:1] if pushes else []
    if queue.planned is not None:
        queue.planned = replace(queue.planned, is_last=True)


def _go_to(simulation: HopSimulation, order: GoTo, members: Members) -> None:
    _stop(simulation, order, members)
    simulation.state.queue.orders.append(HopToPoint(goal_place(order.go_to, members)))


def _turn_by(simulation: HopSimulation, order: TurnBy, members: Members) -> None:
    del members
    simulation.state.queue.orders.append(TurnJumps(math.radians(order.turn_deg)))


def _set_speed(simulation: HopSimulation, order: SetSpeed, members: Members) -> None:
    """Jump at the same angle but another speed: speed² = g h (r² / 8 + 2) with d = r h."""
    del members
    queue = simulation.state.queue
    ratio = queue.jump.distance / queue.jump.height
    height = order.speed**2 / (GRAVITY * (ratio * ratio / 8.0 + 2.0))
    queue.jump = Jump(ratio * height, height)


def _hop_over(simulation: HopSimulation, order: HopOver, members: Members) -> None:
    solids = members[order.hop_over].solids
    simulation.state.queue.orders.append(HurdleJump(order.hop_over, solids))


def jump_once(hopper: Hopper, config: JumpSettings) -> JumpOrder:
    """Return the order of a scripted jump: straight on, or to its `land_at`."""
    jump = scripted_jump(hopper, config, "do.jump")
    return SingleJump(jump) if config.land_at is None else JumpToPoint(config.land_at, jump)


def _jump_once(simulation: HopSimulation, order: JumpOnce, members: Members) -> None:
    del members
    simulation.state.queue.orders.append(jump_once(simulation.hopper, order.jump))


ORDER_HANDLERS: dict[Any, Callable[[HopSimulation, Any, Members], None]] = {
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
"""`walk` resumes after a `wait`."""
