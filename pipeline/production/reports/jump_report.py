"""Jump report: how the creatures of a scene hop, what was asked for and what was resolved.

Nothing is simulated but a few jumps of each creature on level ground.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from pipeline.errors import UsageError
from pipeline.simulation.locomotion.pronking.hopper import Hopper
from pipeline.simulation.locomotion.pronking.hopper_troupe import HopperTroupe
from pipeline.simulation.locomotion.pronking.reference_jump import (
    ReferenceJump,
    rehearse_jump,
)
from pipeline.simulation.simulate import Simulation
from pipeline.simulation.terrain import level_ground
from pipeline.spec import Scene

WORDS = ("distance", "height", "speed", "crouch", "max_force", "balance")
"""Of the language, that an author gives or leaves to be chosen."""

ROUNDING = 1.0 + 1e-9


@dataclass(frozen=True, eq=False)
class Hop:
    """One creature that hops.

    Attributes:
        figure: its.
        of: its constants.
        jump: that it makes on level ground; None if its legs cannot make it.
    """

    figure: str
    of: Hopper
    jump: ReferenceJump | None

    @property
    def is_aimed(self) -> bool:
        """Whether the way of each jump follows from where it is to land."""
        return bool(self.of.config.land_at)


@dataclass(frozen=True, slots=True)
class Told:
    """A report.

    Attributes:
        text: a table of each creature.
        facts: the same, one mapping a creature.
    """

    text: str
    facts: list[dict[str, Any]]


def report_jumps(scene: Scene) -> Told:
    """Return how the creatures of a scene hop.

    Raises:
        UsageError: nobody does.
        PronkError: the scene cannot begin.
    """
    found = hops_of(scene)
    return Told("\n\n".join(table(hop) for hop in found), [facts(hop) for hop in found])


def hops_of(scene: Scene) -> list[Hop]:
    """Return the creatures of a scene that hop.

    Raises:
        UsageError: there are none.
        PronkError: the scene cannot begin.
    """
    found = []
    for troupe in Simulation(scene).troupes:
        if isinstance(troupe, HopperTroupe):
            level = level_ground(0.0, troupe.world.ground)
            for c, (of, hopping) in enumerate(zip(troupe.hoppers, troupe.simulations, strict=True)):
                jump = rehearse_jump(of, level, hopping)
                found.append(Hop(troupe.herd.figures[c].name, of, jump))
    if not found:
        raise UsageError(
            "nobody in this scene hops, so there are no jumps to tell; give a creature `pronk: {}`"
        )
    return found


def facts(hop: Hop) -> dict[str, Any]:
    """Return what is told of one creature, for other programs.

    SI units; `max_force`, `push_force` and `landing_force` are of one leg in body weights, and
    `balance` in body weights times leg length, with their values in newtons and newton metres
    beside them. `distance`, `speed`, `forward` and `flight` are null where `land_at` says how
    far each jump goes, and what a jump takes is null where legs are too short for it. `asked`
    and `resolved` share the words of the language between them.
    """
    of, jump = hop.of, hop.jump
    aimed = hop.is_aimed
    asked = [word for word in WORDS if getattr(of.config, word) is not None]
    return {
        "name": of.name,
        "figure": hop.figure,
        "mass": of.mass.mass,
        "legs": len(of.hips),
        "leg_length": of.leg_length,
        "distance": None if aimed else of.jump.distance,
        "height": of.jump.height,
        "speed": None if aimed else of.jump.speed,
        "up": of.jump.up,
        "forward": None if aimed else of.jump.forward,
        "flight": None if aimed or jump is None else jump.flight,
        "standing": of.standing_height,
        "crouch": of.crouch_height,
        "lowest": of.lowest_height,
        "rise": jump and jump.rise,
        "sinks": jump and jump.sinks,
        "push_seconds": jump and jump.push,
        "landing_seconds": jump and jump.landing,
        "max_force": of.max_leg_force / of.weight,
        "max_force_newtons": of.max_leg_force,
        "push_force": jump and jump.push_force / of.weight,
        "push_force_newtons": jump and jump.push_force,
        "landing_force": jump and jump.landing_force / of.weight,
        "landing_force_newtons": jump and jump.landing_force,
        "saturated": None if jump is None else jump.greatest_force > of.max_leg_force * ROUNDING,
        "balance": of.max_balance_moment / (of.weight * of.leg_length),
        "balance_newton_metres": of.max_balance_moment,
        "asked": asked,
        "resolved": [word for word in WORDS if word not in asked],
    }


def table(hop: Hop) -> str:
    """Return what is told of one creature, a line each."""
    of = hop.of
    rows = [*_flying(hop), *_crouching(hop), *_pushing(hop)]
    wide, long = (max(len(row[k]) for row in rows) for k in (0, 1))
    head = f"{of.name} ({hop.figure}, {of.mass.mass:.4g} kg on {_legs(len(of.hips))})"
    lines = [f"  {a:<{wide}}  {b:<{long}}  {c}".rstrip() for a, b, c in rows]
    return "\n".join([head, *lines])


Row = tuple[str, str, str]


def _flying(hop: Hop) -> Iterator[Row]:
    of, jump = hop.of, hop.of.jump
    up = f"{jump.up:.4g} m/s up"
    if hop.is_aimed:
        yield "distance", "-", "each jump as far as its place in land_at"
        yield "height", f"{jump.height:.4g} m", f"{_origin(of, 'height')}, {up}"
        return
    yield "distance", f"{jump.distance:.4g} m", _origin(of, "distance")
    yield "height", f"{jump.height:.4g} m", _origin(of, "height")
    speeds = f"{up}, {jump.forward:.4g} m/s forward"
    yield "speed", f"{jump.speed:.4g} m/s", f"{_origin(of, 'speed')}: {speeds}"
    if hop.jump is not None:
        yield "flight", f"{hop.jump.flight:.3g} s", ""


def _crouching(hop: Hop) -> Iterator[Row]:
    of = hop.of
    yield "standing", f"{of.standing_height:.4g} m", "height of the body"
    yield (
        "crouch",
        f"{of.crouch_height:.4g} m",
        f"{_origin(of, 'crouch')}; {of.lowest_height:.4g} m at the lowest",
    )
    if hop.jump is None:
        yield "travel", "-", "on level ground its legs cannot make this jump"
        return
    sinks = f"in {hop.jump.push:.2g} s, after sinking by {hop.jump.sinks:.3g} m"
    yield "travel", f"{hop.jump.rise:.3g} m", f"{sinks} in {hop.jump.landing:.2g} s"


def _pushing(hop: Hop) -> Iterator[Row]:
    of, jump = hop.of, hop.jump
    if jump is not None:
        force = jump.greatest_force
        what = f"a jump of {of.jump.distance:.3g} m" if hop.is_aimed else "it"
        says = f"body weights a leg, {force:.4g} N: what {what} takes on level ground"
        if force > of.max_leg_force * ROUNDING:
            says += ", which is more than there is"
        yield "force", f"{force / of.weight:.3g}", says
    says = f"body weights a leg, {of.max_leg_force:.4g} N: {_origin(of, 'max_force')}"
    yield "max_force", f"{of.max_leg_force / of.weight:.4g}", says
    share = of.max_balance_moment / (of.weight * of.leg_length)
    says = f"body weights × leg length, {of.max_balance_moment:.4g} N m: {_origin(of, 'balance')}"
    yield "balance", f"{share:.4g}", says


def _origin(of: Hopper, word: str) -> str:
    """Return whether a word was asked for, or where its value comes from."""
    words = of.config
    if getattr(words, word) is not None:
        return "as asked"
    others = [w for w in ("distance", "height", "speed") if w != word]
    if word in ("distance", "height", "speed") and all(
        getattr(words, w) is not None for w in others
    ):
        return f"from {' and '.join(others)}"
    if word == "speed":
        return "from distance and height"
    return "chosen"


def _legs(count: int) -> str:
    return "1 leg" if count == 1 else f"{count} legs"
