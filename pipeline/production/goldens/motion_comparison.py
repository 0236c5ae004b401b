"""Comparison: whether a take still moves like its golden, and where it first does not."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import chain

from pipeline.production.goldens import motion_tolerance
from pipeline.production.goldens.motion_deviations import deviations, ground
from pipeline.production.goldens.motion_digest import facts_of, motion_digest
from pipeline.production.goldens.motion_fingerprints import Fingerprints
from pipeline.production.goldens.motion_golden import Land, MotionGolden, land_of
from pipeline.production.goldens.motion_invariants import broken_invariants
from pipeline.production.goldens.motion_marks import marks_of
from pipeline.production.goldens.motion_matching import unmatched
from pipeline.production.goldens.motion_verdict import WHOLE, Difference, Outcome, Verdict
from pipeline.simulation.clock import Clock
from pipeline.simulation.take import Take

OUR_OWN = frozenset({"pronk", "simulation", "language", "python"})
"""Versions that may change without another golden: the point is to see that motion does not."""

RANK = ("take", "ground", "position", "rotation", "scale", "alive")
"""What is named first of differences at one step; the rest comes after all nodes."""


def compare(golden: MotionGolden, take: Take) -> Verdict:
    """Say whether `take` moves like its golden.

    Exact rule: on the class of processor and with the libraries of the golden, equal code
    gives equal bits, so the digest of the motion agrees and the take is identical.

    Tolerant rule: elsewhere, or where code was written otherwise and rounds otherwise, a
    take passes as equal within tolerance: poses and channels within `motion_tolerance` at the
    rows that the golden keeps, contacts and sound events within a step. On the same
    class the verdict then says where the first bits differ. Rows between those that are
    kept are not judged by it, nor are words without numbers (materials, notes' texts).

    A chaotic motion is compared elsewhere up to the golden's `predictable` step, and from there on
    by its invariants: energy, extent, rest and counts.

    Anything else is changed. Of differences at one step the node named first is the one
    nearest to the root, for nodes stand after their parents.
    """
    elsewhere = _elsewhere(golden.versions, take.header.versions)
    if golden.digest == motion_digest(take):
        return Verdict(golden.scene, Outcome.IDENTICAL, elsewhere)
    other = list(_structure(golden, take))
    found = other or list(_motion(golden, take))
    horizon = golden.predictable if elsewhere and not other else None
    if horizon is not None:
        found = [difference for difference in found if difference.step < horizon]
        found += broken_invariants(golden, take, horizon)
        elsewhere += f"; chaotic, so poses up to step {horizon}, then energy, rest and counts"
    order = {who: n for n, who in enumerate(golden.nodes)}
    found.sort(key=lambda d: (d.step, order.get(d.who, len(order)), _rank(d.kind)))
    return Verdict(
        golden.scene,
        Outcome.CHANGED if found else Outcome.WITHIN,
        elsewhere,
        tuple(found),
        _moment(found[0].step, take) if found else "",
        _totals(golden),
        "" if elsewhere or other else _first_bits(golden, take),
    )


def _elsewhere(then: dict[str, str], now: dict[str, str]) -> str:
    """Return how the processor and the libraries differ, in words; empty if they do not."""
    names = sorted((then.keys() | now.keys()) - OUR_OWN)
    return ", ".join(
        f"{name} {now.get(name, 'missing')}, the golden's {then.get(name, 'missing')}"
        for name in names
        if now.get(name) != then.get(name)
    )


def _structure(golden: MotionGolden, take: Take) -> Iterator[Difference]:
    """Yield what keeps the numbers from being compared."""
    for name, fact in facts_of(take.header).items():
        if fact != golden.facts.get(name):
            told = f"is {fact}, the golden's {golden.facts.get(name)}"
            yield Difference(WHOLE, "take", name, told)
    units = {channel.name: channel.unit for channel in take.channels}
    yield from _names("node", golden.nodes, [node.name for node in take.nodes])
    yield from _names("channel", golden.channels, units)
    for name in golden.channels.keys() & units.keys():
        if units[name] != golden.channels[name]:
            told = f"is in {units[name]}, the golden's in {golden.channels[name]}"
            yield Difference(WHOLE, "take", name, told)
    yield from _land(golden.land, land_of(take))


def _names(what: str, then: Iterable[str], now: Iterable[str]) -> Iterator[Difference]:
    old, new = list(then), list(now)
    for fate, names in (
        ("is gone", [name for name in old if name not in new]),
        ("is new", [name for name in new if name not in old]),
    ):
        for name in names:
            yield Difference(WHOLE, "take", name, f"{fate}: this {what}")


def _land(then: Land, now: Land) -> Iterator[Difference]:
    if (now.cells, now.vertices) != (then.cells, then.vertices):
        told = f"has {now.cells} cells, the golden's {then.cells}"
        yield Difference(WHOLE, "ground", "the ground", told)
    if now.material != then.material:
        told = f"is of {now.material}, the golden's of {then.material}"
        yield Difference(WHOLE, "ground", "the ground", told)


def _motion(golden: MotionGolden, take: Take) -> Iterator[Difference]:
    yield from _forbidden(golden.land, land_of(take), take.terrain.forbidden.size)
    yield from ground(golden, take)
    yield from chain.from_iterable(d.differences() for d in deviations(golden, take))
    yield from unmatched(golden.marks, marks_of(take), take.header.steps)


def _forbidden(then: Land, now: Land, cells: int) -> Iterator[Difference]:
    if abs(now.forbidden - then.forbidden) > motion_tolerance.FORBIDDEN * cells:
        told = f"forbids {now.forbidden} cells, the golden's {then.forbidden}"
        yield Difference(WHOLE, "ground", "the ground", told)


def _rank(kind: str) -> int:
    return RANK.index(kind) if kind in RANK else len(RANK)


def _moment(step: int, take: Take) -> str:
    """Return a step in words, with the time and the first frame that shows it."""
    if step == WHOLE:
        return "of all"
    header = take.header
    clock = Clock(header.rate, header.frames, header.steps, header.samples)
    time = float(clock.time_of(step))
    return f"at step {step} ({time:.3f} s, frame {clock.frame_of(step, 0.0)})"


def _totals(golden: MotionGolden) -> tuple[tuple[str, int], ...]:
    nodes = len(golden.nodes)
    marks = [mark.kind for mark in golden.marks]
    return (
        *((kind, nodes) for kind in RANK[2:]),
        ("channel", len(golden.channels)),
        *((kind, marks.count(kind)) for kind in ("contact", "event", "note")),
        *((kind, 0) for kind in RANK[:2]),
    )


def _first_bits(golden: MotionGolden, take: Take) -> str:
    """Return in words where the bits of a take of the same class first differ."""
    then, now = golden.fingerprints, Fingerprints.of(take)
    place = [node.name for node in take.nodes] + [channel.name for channel in take.channels]
    rows = [k for k, (one, two) in enumerate(zip(then.rows, now.rows, strict=True)) if one != two]
    names = [*golden.nodes, *golden.channels]
    track = dict(zip(place, now.tracks, strict=True))
    tracks = [name for name, bits in zip(names, then.tracks, strict=True) if track[name] != bits]
    if not rows or not tracks:
        return "no bit of a pose or a channel differs, but a word or a number of what happened"
    step = rows[0] * take.header.steps // take.header.samples
    return (
        f"not identical: bits differ from step {step} on, in {len(rows)} of {len(now.rows)} rows "
        f"and {len(tracks)} of {len(names)} tracks, the first of them {tracks[0]}"
    )
