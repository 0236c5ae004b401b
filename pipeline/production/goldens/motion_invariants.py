"""Invariants: what a chaotic motion keeps after rounding has led it elsewhere.

Once a chaotic scene has diverged, no pose can be compared any more. Energy, extent, rest and the
number of contacts still agree with the golden in size.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.production.goldens.motion_golden import MotionGolden, sampled, sampled_rows
from pipeline.production.goldens.motion_marks import Mark, marks_of
from pipeline.production.goldens.motion_verdict import Difference
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Take

GRAVITY = 9.81
"""[m/s²]."""

LEAST_ENERGY_RANGE = 0.1
"""Range assumed for scenes at rest [J/kg]: a centimetre of height."""


@dataclass(frozen=True)
class InvariantLimits:
    """How far two diverged runs of one scene may differ.

    Ten chaotic scenes were measured on another class of processor and from starts shifted by 1e-9
    to 1e-7 m: energy differed by up to 0.37, extent by 0.05, rest by 0.25, counts by 23 of 53 and
    by 20 % of many.

    Attributes:
        energy: of the mean specific energy, as a fraction of its range in the golden.
        extent: beyond the golden's bounding box, as a fraction of its diagonal.
        rest_speed: below which a node is at rest [m/s].
        rest: of the fraction of nodes at rest at the end.
        counts: of the number of marks of a kind, as a fraction.
        few: marks of a kind that may be missing or added in any case.
    """

    energy: float = 0.5
    extent: float = 0.2
    rest_speed: float = 0.02
    rest: float = 0.4
    counts: float = 0.3
    few: int = 15


LIMITS = InvariantLimits()


@dataclass(frozen=True, eq=False)
class Summary:
    """Sizes of a motion from one step on.

    Attributes:
        energy: (K,) mean specific energy of the nodes that are alive [J/kg].
        low, high: (3,) corners of the bounding box of all alive nodes over the whole film [m].
        at_rest: fraction of the nodes that rest at the end.
        alive: number of nodes that are alive at the end.
        counts: number of marks by kind, after that step.
    """

    energy: Array
    low: Array
    high: Array
    at_rest: float
    alive: int
    counts: Counter[str]


def broken_invariants(golden: MotionGolden, take: Take, start: int) -> Iterator[Difference]:
    """Yield the invariants that `take` does not keep from step `start` on.

    Args:
        golden: of the same scene.
        take: with the golden's nodes and rows.
        start: first step that is not predictable.
    """
    steps = sampled_rows(len(take.positions), golden.stride)
    steps = steps * take.header.steps // take.header.samples
    seconds = steps / (take.header.steps * float(take.header.rate))
    now = sampled(take, golden.stride, golden.nodes, ())
    then = {name: series.values for name, series in golden.series.items()}
    before = _summary(then, golden.marks, seconds, steps, start)
    after = _summary(now, marks_of(take), seconds, steps, start)
    if not np.isfinite(now["positions"]).all():
        yield Difference(start, "position", "a node", "is not finite")
        return
    yield from _compare(before, after, start)


def _compare(before: Summary, after: Summary, start: int) -> Iterator[Difference]:
    span = max(float(np.ptp(before.energy)), LEAST_ENERGY_RANGE)
    late = slice(len(before.energy) // 2, None)
    apart = abs(float(after.energy[late].mean() - before.energy[late].mean())) / span
    if apart > LIMITS.energy:
        yield _invariant(start, f"mean energy is off by {apart:.0%} of its range", apart)
    room = LIMITS.extent * float(np.linalg.norm(before.high - before.low))
    out = float(max((before.low - after.low).max(), (after.high - before.high).max()))
    if out > room:
        yield _invariant(start, f"nodes leave the golden's space by {out:.2f} m", out / room)
    lost = before.at_rest - after.at_rest
    if lost > LIMITS.rest:
        yield _invariant(start, f"{lost:.0%} of the nodes do not come to rest", lost)
    if before.alive != after.alive:
        yield _invariant(start, f"{after.alive} nodes are alive at the end, not {before.alive}", 1)
    for kind in sorted(before.counts.keys() | after.counts.keys()):
        old, new = before.counts[kind], after.counts[kind]
        if abs(new - old) > LIMITS.few + LIMITS.counts * max(new, old):
            yield _invariant(start, f"{new} times {kind}, the golden has {old}", abs(new - old))


def _invariant(step: int, text: str, excess: float) -> Difference:
    return Difference(step, "invariant", "the whole scene", text, excess)


def _summary(
    series: dict[str, Array],
    marks: tuple[Mark, ...],
    seconds: Array,
    steps: NDArray[np.int64],
    start: int,
) -> Summary:
    p = series["positions"].reshape(len(seconds), -1, 3)
    alive = series["alive"] > 0.5
    speed = np.linalg.norm(np.gradient(p, seconds, axis=0), axis=-1)
    energy = GRAVITY * p[..., 1] + 0.5 * speed * speed
    weight = np.maximum(alive.sum(axis=1), 1)
    diverged = steps >= start
    seen = p[alive] if alive.any() else np.zeros((1, 3))
    return Summary(
        (np.where(alive, energy, 0.0).sum(axis=1) / weight)[diverged],
        seen.min(axis=0),
        seen.max(axis=0),
        float(((speed[-1] < LIMITS.rest_speed) & alive[-1]).sum() / weight[-1]),
        int(alive[-1].sum()),
        Counter(f"{mark.kind} {mark.what.split()[0]}" for mark in marks if mark.moment >= start),
    )
