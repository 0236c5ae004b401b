"""Jump report: the jumps of a scene's creatures, with the values given and those resolved."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pipeline.errors import UsageError
from pipeline.production.reports.tables import Report
from pipeline.simulation.jump_summaries import CHOSEN_KEYS, JumpSummary, jump_summaries
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
    summaries = jump_summaries(scene)
    if not summaries:
        raise UsageError(
            "nobody in this scene hops, so there are no jumps to tell; give a creature `pronk: {}`"
        )
    return Report("\n\n".join(map(table, summaries)), [facts(summary) for summary in summaries])


def facts(summary: JumpSummary) -> dict[str, Any]:
    """Return the jump of one creature as plain values in SI units.

    `max_force`, `push_force` and `landing_force` are of one leg in body weights, and `balance` in
    body weights times leg length; newtons and newton metres stand beside them. `distance`,
    `speed`, `forward` and `flight` are null where `land_at` says how far each jump goes, and the
    loads of a jump are null where the legs are too short for it.
    """
    jump, weight = summary.rehearsal, summary.weight
    aimed = summary.is_aimed
    return {
        "name": summary.name,
        "figure": summary.figure,
        "mass": summary.mass,
        "legs": summary.legs,
        "leg_length": summary.leg_length,
        "distance": None if aimed else summary.distance,
        "height": summary.height,
        "speed": None if aimed else summary.speed,
        "up": summary.up,
        "forward": None if aimed else summary.forward,
        "flight": None if aimed or jump is None else jump.flight,
        "standing": summary.standing,
        "crouch": summary.crouch,
        "lowest": summary.lowest,
        "rise": jump and jump.rise,
        "sinks": jump and jump.sinks,
        "push_seconds": jump and jump.push,
        "landing_seconds": jump and jump.landing,
        "max_force": summary.max_force / weight,
        "max_force_newtons": summary.max_force,
        "push_force": jump and jump.push_force / weight,
        "push_force_newtons": jump and jump.push_force,
        "landing_force": jump and jump.landing_force / weight,
        "landing_force_newtons": jump and jump.landing_force,
        "saturated": None if jump is None else jump.greatest_force > summary.max_force * ROUNDING,
        "balance": summary.balance / (weight * summary.leg_length),
        "balance_newton_metres": summary.balance,
        "asked": list(summary.asked),
        "resolved": [key for key in CHOSEN_KEYS if key not in summary.asked],
    }


def table(summary: JumpSummary) -> str:
    """Return the jump of one creature, a quantity per line."""
    rows = [*_flight_rows(summary), *_crouch_rows(summary), *_force_rows(summary)]
    wide, long = (max(len(row[k]) for row in rows) for k in (0, 1))
    legs = "1 leg" if summary.legs == 1 else f"{summary.legs} legs"
    head = f"{summary.name} ({summary.figure}, {summary.mass:.4g} kg on {legs})"
    lines = [f"  {a:<{wide}}  {b:<{long}}  {c}".rstrip() for a, b, c in rows]
    return "\n".join([head, *lines])


def _flight_rows(summary: JumpSummary) -> Iterator[Row]:
    up = f"{summary.up:.4g} m/s up"
    if summary.is_aimed:
        yield "distance", "-", "each jump as far as its place in land_at"
        yield "height", f"{summary.height:.4g} m", f"{_origin(summary, 'height')}, {up}"
        return
    yield "distance", f"{summary.distance:.4g} m", _origin(summary, "distance")
    yield "height", f"{summary.height:.4g} m", _origin(summary, "height")
    speeds = f"{up}, {summary.forward:.4g} m/s forward"
    yield "speed", f"{summary.speed:.4g} m/s", f"{_origin(summary, 'speed')}: {speeds}"
    if summary.rehearsal is not None:
        yield "flight", f"{summary.rehearsal.flight:.3g} s", ""


def _crouch_rows(summary: JumpSummary) -> Iterator[Row]:
    yield "standing", f"{summary.standing:.4g} m", "height of the body"
    lowest = f"{summary.lowest:.4g} m at the lowest"
    yield "crouch", f"{summary.crouch:.4g} m", f"{_origin(summary, 'crouch')}; {lowest}"
    jump = summary.rehearsal
    if jump is None:
        yield "travel", "-", "on level ground its legs cannot make this jump"
        return
    sinks = f"in {jump.push:.2g} s, after sinking by {jump.sinks:.3g} m"
    yield "travel", f"{jump.rise:.3g} m", f"{sinks} in {jump.landing:.2g} s"


def _force_rows(summary: JumpSummary) -> Iterator[Row]:
    jump, weight = summary.rehearsal, summary.weight
    if jump is not None:
        force = jump.greatest_force
        what = f"a jump of {summary.distance:.3g} m" if summary.is_aimed else "it"
        text = f"body weights a leg, {force:.4g} N: what {what} takes on level ground"
        if force > summary.max_force * ROUNDING:
            text += ", which is more than there is"
        yield "force", f"{force / weight:.3g}", text
    text = f"body weights a leg, {summary.max_force:.4g} N: {_origin(summary, 'max_force')}"
    yield "max_force", f"{summary.max_force / weight:.4g}", text
    share = summary.balance / (weight * summary.leg_length)
    text = f"body weights × leg length, {summary.balance:.4g} N m: {_origin(summary, 'balance')}"
    yield "balance", f"{share:.4g}", text


def _origin(summary: JumpSummary, key: str) -> str:
    """Return whether a key was asked for, or where its value comes from."""
    if key in summary.asked:
        return "as asked"
    others = [other for other in ("distance", "height", "speed") if other != key]
    if len(others) == 2 and set(others) <= set(summary.asked):
        return f"from {' and '.join(others)}"
    return "from distance and height" if key == "speed" else "chosen"
