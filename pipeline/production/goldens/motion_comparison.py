"""Motion comparison: a take against its golden, by an exact and a tolerant rule."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import chain

from pipeline.production.goldens import motion_tolerance
from pipeline.production.goldens.motion_deviations import deviations, ground_differences
from pipeline.production.goldens.motion_digest import Fingerprints, header_facts, motion_digest
from pipeline.production.goldens.motion_golden import GroundSummary, MotionGolden, ground_summary
from pipeline.production.goldens.motion_invariants import broken_invariants
from pipeline.production.goldens.motion_marks import mark_differences, marks_of
from pipeline.production.goldens.motion_verdict import (
    WHOLE_TAKE,
    Difference,
    MotionOutcome,
    MotionVerdict,
)
from pipeline.simulation.clock import Clock
from pipeline.simulation.take import Take

IGNORED_VERSIONS = frozenset({"pronk", "simulation", "language", "python"})
"""Versions that may change without another golden."""

KINDS = ("take", "ground", "position", "rotation", "scale", "alive")
RANK = {kind: rank for rank, kind in enumerate(KINDS)}
"""Order of differences at one step; other kinds come after all nodes."""


def compare(golden: MotionGolden, take: Take) -> MotionVerdict:
    """Return the verdict on the motion of `take`.

    Exact rule: on the golden's class of processor and with its libraries, equal code gives equal
    bits, so the digests agree and the take is identical.

    Tolerant rule: elsewhere, or for code that rounds otherwise, poses and channels must lie within
    `motion_tolerance` at the rows that the golden keeps, contacts and sound events within a step.
    On the same class the verdict also locates the first bits that differ. Other rows, materials
    and the texts of notes are not compared.

    A chaotic motion is compared elsewhere up to the golden's `predictable` step, and from there on
    by its invariants: energy, extent, rest and counts.

    Anything else is changed. Of differences at one step, that of the node nearest to the root comes
    first, because nodes stand after their parents.
    """
    elsewhere = _environment_difference(golden.versions, take.header.versions)
    if golden.digest == motion_digest(take):
        return MotionVerdict(golden.scene, MotionOutcome.IDENTICAL, elsewhere)
    other = list(_structure_differences(golden, take))
    found = other or list(_motion_differences(golden, take))
    horizon = golden.predictable if elsewhere and not other else None
    if horizon is not None:
        found = [difference for difference in found if difference.step < horizon]
        found += broken_invariants(golden, take, horizon)
        elsewhere += f"; chaotic, so poses up to step {horizon}, then energy, rest and counts"
    order = {who: n for n, who in enumerate(golden.nodes)}
    found.sort(key=lambda d: (d.step, order.get(d.who, len(order)), RANK.get(d.kind, len(RANK))))
    return MotionVerdict(
        golden.scene,
        MotionOutcome.CHANGED if found else MotionOutcome.WITHIN,
        elsewhere,
        tuple(found),
        _moment_text(found[0].step, take) if found else "",
        _totals(golden),
        "" if elsewhere or other else _first_bits(golden, take),
    )


def _environment_difference(then: dict[str, str], now: dict[str, str]) -> str:
    """Return the differences of processor and libraries as text, empty if there are none."""
    names = sorted((then.keys() | now.keys()) - IGNORED_VERSIONS)
    return ", ".join(
        f"{name} {now.get(name, 'missing')}, the golden's {then.get(name, 'missing')}"
        for name in names
        if now.get(name) != then.get(name)
    )


def _structure_differences(golden: MotionGolden, take: Take) -> Iterator[Difference]:
    """Yield differences that make the numbers incomparable."""
    for name, fact in header_facts(take.header).items():
        if fact != golden.facts.get(name):
            text = f"is {fact}, the golden's {golden.facts.get(name)}"
            yield Difference(WHOLE_TAKE, "take", name, text)
    units = {channel.name: channel.unit for channel in take.channels}
    yield from _name_differences("node", golden.nodes, [node.name for node in take.nodes])
    yield from _name_differences("channel", golden.channels, units)
    for name in golden.channels.keys() & units.keys():
        if units[name] != golden.channels[name]:
            text = f"is in {units[name]}, the golden's in {golden.channels[name]}"
            yield Difference(WHOLE_TAKE, "take", name, text)
    yield from _ground_structure(golden.land, ground_summary(take))


def _name_differences(kind: str, then: Iterable[str], now: Iterable[str]) -> Iterator[Difference]:
    old, new = list(then), list(now)
    for fate, names in (
        ("is gone", [name for name in old if name not in new]),
        ("is new", [name for name in new if name not in old]),
    ):
        for name in names:
            yield Difference(WHOLE_TAKE, "take", name, f"{fate}: this {kind}")


def _ground_structure(then: GroundSummary, now: GroundSummary) -> Iterator[Difference]:
    if (now.cells, now.vertices) != (then.cells, then.vertices):
        text = f"has {now.cells} cells, the golden's {then.cells}"
        yield Difference(WHOLE_TAKE, "ground", "the ground", text)
    if now.material != then.material:
        text = f"is of {now.material}, the golden's of {then.material}"
        yield Difference(WHOLE_TAKE, "ground", "the ground", text)


def _motion_differences(golden: MotionGolden, take: Take) -> Iterator[Difference]:
    then, now = golden.land.forbidden, ground_summary(take).forbidden
    if abs(now - then) > motion_tolerance.FORBIDDEN * take.terrain.forbidden.size:
        text = f"forbids {now} cells, the golden's {then}"
        yield Difference(WHOLE_TAKE, "ground", "the ground", text)
    yield from ground_differences(golden, take)
    yield from chain.from_iterable(d.differences() for d in deviations(golden, take))
    yield from mark_differences(golden.marks, marks_of(take), take.header.steps)


def _moment_text(step: int, take: Take) -> str:
    """Return a step as text, with its time and the first frame that shows it."""
    if step == WHOLE_TAKE:
        return "of all"
    header = take.header
    clock = Clock(header.rate, header.frames, header.steps, header.samples)
    time = float(clock.time_of(step))
    return f"at step {step} ({time:.3f} s, frame {clock.frame_of(step, 0.0)})"


def _totals(golden: MotionGolden) -> tuple[tuple[str, int], ...]:
    nodes = len(golden.nodes)
    marks = [mark.kind for mark in golden.marks]
    return (
        *((kind, nodes) for kind in KINDS[2:]),
        ("channel", len(golden.channels)),
        *((kind, marks.count(kind)) for kind in ("contact", "event", "note")),
        *((kind, 0) for kind in KINDS[:2]),
    )


def _first_bits(golden: MotionGolden, take: Take) -> str:
    """Return the place of the first bits that differ, as text."""
    then, now = golden.fingerprints, Fingerprints.of(take)
    place = [node.name for node in take.nodes] + [channel.name for channel in take.channels]
    rows = [k for k, pair in enumerate(zip(then.rows, now.rows, strict=True)) if pair[0] != pair[1]]
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
