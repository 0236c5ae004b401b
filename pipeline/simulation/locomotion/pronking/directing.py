"""Directing: what orders do to creatures that hop.

Source: Sims 1987, 3.2.4.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.locomotion.pronking import errands, phases
from pipeline.simulation.locomotion.pronking.hopping import Hopping
from pipeline.simulation.locomotion.pronking.parameters import Jump, jump_of
from pipeline.simulation.locomotion.pronking.pronker import LIFTS, Pronker
from pipeline.simulation.spatial import Array
from pipeline.spec.creature import Pronk
from pipeline.spec.script import Do, GoTo, HopOver, JumpOnce, JumpWords, SetSpeed, TurnBy, Wait

Solids = Mapping[str, Sequence[Array]]
"""Corners (n, 3) of the solids of performers, in the world [m]."""


def obey(hopping: Hopping, order: Do, solids: Solids) -> None:
    """Let a creature do as it is told from its next jump on."""
    kind = type(order) if not isinstance(order, str) else order
    ORDERS[kind](hopping, order, solids)
    phases.wake(hopping.of, hopping.state)


def jump_for(of: Pronker, words: JumpWords, where: str) -> Jump:
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
    return jump_of(where, Pronk(**given), of.tallest(LIFTS, 0.0))


def _hop(hopping: Hopping, order: Do, solids: Solids) -> None:
    """Hop on as its words say."""
    del order, solids
    hopping.state.course.onward = True


def _stop(hopping: Hopping, order: Do, solids: Solids) -> None:
    """Stand when the present jump has landed."""
    del order, solids
    course = hopping.state.course
    course.onward = False
    pushes = hopping.state.phase == "pushing" and course.leap is not None
    # What it pushes for already it jumps, but no more of that.
    course.errands = course.errands[:1] if pushes else []
    if course.leap is not None:
        course.leap = replace(course.leap, last=True)


def _go_to(hopping: Hopping, order: GoTo, solids: Solids) -> None:
    _stop(hopping, order, solids)
    hopping.state.course.errands.append(errands.GoThere(order.go_to))


def _turn(hopping: Hopping, order: TurnBy, solids: Solids) -> None:
    del solids
    hopping.state.course.errands.append(errands.TurnBy(math.radians(order.turn_deg)))


def _set_speed(hopping: Hopping, order: SetSpeed, solids: Solids) -> None:
    """Jump at the same angle, faster or slower: speed² = g h (r² / 8 + 2) with d = r h."""
    del solids
    course = hopping.state.course
    ratio = course.jump.distance / course.jump.height
    height = order.speed**2 / (GRAVITY * (ratio * ratio / 8.0 + 2.0))
    course.jump = Jump(ratio * height, height)


def _hop_over(hopping: Hopping, order: HopOver, solids: Solids) -> None:
    seen = solids.get(order.hop_over, ())
    hopping.state.course.errands.append(errands.HopOver(order.hop_over, seen))


def _jump(hopping: Hopping, order: JumpOnce, solids: Solids) -> None:
    del solids
    jump = jump_for(hopping.of, order.jump, "do.jump")
    spot = order.jump.land_at
    one = errands.Once(jump) if spot is None else errands.OnceTo(spot, jump)
    hopping.state.course.errands.append(one)


ORDERS: dict[Any, Callable[[Hopping, Any, Solids], None]] = {
    "hop": _hop,
    "walk": _hop,
    "stop": _stop,
    Wait: _stop,
    GoTo: _go_to,
    TurnBy: _turn,
    SetSpeed: _set_speed,
    HopOver: _hop_over,
    JumpOnce: _jump,
}
"""`walk` is what comes after a `wait`."""
