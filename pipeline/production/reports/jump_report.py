"""Jump report: how the creatures of a scene hop, what was asked for and what was resolved."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pipeline.errors import UsageError
from pipeline.production.reports.tables import Report
from pipeline.simulation.jump_plans import CHOSEN_KEYS, JumpPlan, jump_plans
from pipeline.spec import Scene

ROUNDING = 1.0 + 1e-9
"""Ratio of forces that counts as equal."""

Row = tuple[str, str, str]


def report_jumps(scene: Scene) -> Report:
    """Return how the creatures of a scene hop.

    Raises:
        UsageError: none does.
        PronkError: the scene cannot start.
    """
    plans = jump_plans(scene)
    if not plans:
        raise UsageError(
            "nobody in this scene hops, so there are no jumps to tell; give a creature `pronk: {}`"
        )
    return Report("\n\n".join(map(table, plans)), [facts(plan) for plan in plans])


def facts(plan: JumpPlan) -> dict[str, Any]:
    """Return the jump of one creature as plain values in SI units.

    `max_force`, `push_force` and `landing_force` are of one leg in body weights, and `balance` in
    body weights times leg length; newtons and newton metres stand beside them. `distance`,
    `speed`, `forward` and `flight` are null where `land_at` says how far each jump goes, and the
    loads of a jump are null where the legs are too short for it.
    """
    jump, weight = plan.rehearsal, plan.weight
    aimed = plan.is_aimed
    return {
        "name": plan.name,
        "figure": plan.figure,
        "mass": plan.mass,
        "legs": plan.legs,
        "leg_length": plan.leg_length,
        "distance": None if aimed else plan.distance,
        "height": plan.height,
        "speed": None if aimed else plan.speed,
        "up": plan.up,
        "forward": None if aimed else plan.forward,
        "flight": None if aimed or jump is None else jump.flight,
        "standing": plan.standing,
        "crouch": plan.crouch,
        "lowest": plan.lowest,
        "rise": jump and jump.rise,
        "sinks": jump and jump.sinks,
        "push_seconds": jump and jump.push,
        "landing_seconds": jump and jump.landing,
        "max_force": plan.max_force / weight,
        "max_force_newtons": plan.max_force,
        "push_force": jump and jump.push_force / weight,
        "push_force_newtons": jump and jump.push_force,
        "landing_force": jump and jump.landing_force / weight,
        "landing_force_newtons": jump and jump.landing_force,
        "saturated": None if jump is None else jump.greatest_force > plan.max_force * ROUNDING,
        "balance": plan.balance / (weight * plan.leg_length),
        "balance_newton_metres": plan.balance,
        "asked": list(plan.asked),
        "resolved": [key for key in CHOSEN_KEYS if key not in plan.asked],
    }


def table(plan: JumpPlan) -> str:
    """Return the jump of one creature, a quantity per line."""
    rows = [*_flight_rows(plan), *_crouch_rows(plan), *_force_rows(plan)]
    wide, long = (max(len(row[k]) for row in rows) for k in (0, 1))
    legs = "1 leg" if plan.legs == 1 else f"{plan.legs} legs"
    head = f"{plan.name} ({plan.figure}, {plan.mass:.4g} kg on {legs})"
    lines = [f"  {a:<{wide}}  {b:<{long}}  {c}".rstrip() for a, b, c in rows]
    return "\n".join([head, *lines])


def _flight_rows(plan: JumpPlan) -> Iterator[Row]:
    up = f"{plan.up:.4g} m/s up"
    if plan.is_aimed:
        yield "distance", "-", "each jump as far as its place in land_at"
        yield "height", f"{plan.height:.4g} m", f"{_origin(plan, 'height')}, {up}"
        return
    yield "distance", f"{plan.distance:.4g} m", _origin(plan, "distance")
    yield "height", f"{plan.height:.4g} m", _origin(plan, "height")
    speeds = f"{up}, {plan.forward:.4g} m/s forward"
    yield "speed", f"{plan.speed:.4g} m/s", f"{_origin(plan, 'speed')}: {speeds}"
    if plan.rehearsal is not None:
        yield "flight", f"{plan.rehearsal.flight:.3g} s", ""


def _crouch_rows(plan: JumpPlan) -> Iterator[Row]:
    yield "standing", f"{plan.standing:.4g} m", "height of the body"
    lowest = f"{plan.lowest:.4g} m at the lowest"
    yield "crouch", f"{plan.crouch:.4g} m", f"{_origin(plan, 'crouch')}; {lowest}"
    jump = plan.rehearsal
    if jump is None:
        yield "travel", "-", "on level ground its legs cannot make this jump"
        return
    sinks = f"in {jump.push:.2g} s, after sinking by {jump.sinks:.3g} m"
    yield "travel", f"{jump.rise:.3g} m", f"{sinks} in {jump.landing:.2g} s"


def _force_rows(plan: JumpPlan) -> Iterator[Row]:
    jump, weight = plan.rehearsal, plan.weight
    if jump is not None:
        force = jump.greatest_force
        what = f"a jump of {plan.distance:.3g} m" if plan.is_aimed else "it"
        text = f"body weights a leg, {force:.4g} N: what {what} takes on level ground"
        if force > plan.max_force * ROUNDING:
            text += ", which is more than there is"
        yield "force", f"{force / weight:.3g}", text
    text = f"body weights a leg, {plan.max_force:.4g} N: {_origin(plan, 'max_force')}"
    yield "max_force", f"{plan.max_force / weight:.4g}", text
    share = plan.balance / (weight * plan.leg_length)
    text = f"body weights × leg length, {plan.balance:.4g} N m: {_origin(plan, 'balance')}"
    yield "balance", f"{share:.4g}", text


def _origin(plan: JumpPlan, key: str) -> str:
    """Return whether a key was asked for, or where its value comes from."""
    if key in plan.asked:
        return "as asked"
    others = [other for other in ("distance", "height", "speed") if other != key]
    if len(others) == 2 and set(others) <= set(plan.asked):
        return f"from {' and '.join(others)}"
    return "from distance and height" if key == "speed" else "chosen"
