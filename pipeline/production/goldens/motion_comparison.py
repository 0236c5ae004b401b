"""Motion comparison: a take against its golden, by an exact and a tolerant rule."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from pipeline.production.goldens import motion_tolerance
from pipeline.production.goldens.motion_digest import (
    Fingerprints,
    header_facts,
    motion_digest,
)
from pipeline.production.goldens.motion_golden import (
    GroundSummary,
    MotionGolden,
    channel_stride,
    ground_summary,
    sampled,
    sampled_rows,
)
from pipeline.production.goldens.motion_invariants import broken_invariants
from pipeline.production.goldens.motion_marks import mark_differences, marks_of
from pipeline.production.goldens.motion_verdict import (
    WHOLE_TAKE,
    Difference,
    MotionOutcome,
    MotionVerdict,
    millimetres,
)
from pipeline.simulation.clock import Clock
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Take

# --- Motion deviations: differences of a take's poses, channels and ground from its golden


@dataclass(frozen=True, eq=False)
class Deviations:
    """Differences of tracks of one kind from their golden.

    Attributes:
        kind: such as "position".
        who: (n,) names of the tracks.
        steps: (K,) of the rows.
        amounts: (K, n) differences.
        allowed: (n,) tolerances.
        format: returns an amount of a track as text.
    """

    kind: str
    who: Sequence[str]
    steps: NDArray[np.int64]
    amounts: Array
    allowed: Array
    format: Callable[[int, float], str]

    def differences(self) -> Iterator[Difference]:
        """Yield one difference for each track that exceeds its tolerance."""
        beyond = self.amounts > self.allowed
        for n in np.flatnonzero(beyond.any(axis=0)).tolist():
            amounts = self.amounts[:, n]
            first, most = int(np.argmax(beyond[:, n])), int(np.argmax(amounts))
            allowed = self.format(n, float(self.allowed[n]))
            yield Difference(
                int(self.steps[first]),
                self.kind,
                self.who[n],
                TEXTS[self.kind].format(self.format(n, float(amounts[first])), allowed),
                float(amounts[most] / self.allowed[n]),
                f"{self.format(n, float(amounts[most]))} at step {self.steps[most]}",
            )


TEXTS = {
    "position": "lies {} off (allowed: {})",
    "rotation": "is turned {} off (allowed: {})",
    "scale": "is scaled {} off (allowed: {})",
    "alive": "is there where the golden has none, or the other way round",
    "channel": "is {} off (allowed: {})",
}


def deviations(golden: MotionGolden, take: Take) -> list[Deviations]:
    """Return the deviations of poses and channels, nodes first.

    The take must have the golden's nodes, channels and rows.
    """
    now = sampled(take, golden.stride, golden.nodes, list(golden.channels))
    then = {name: series.values for name, series in golden.series.items()}
    a_row = take.header.steps // take.header.samples
    rows = sampled_rows(len(take.positions), golden.stride)
    frames = sampled_rows(len(take.values), channel_stride(golden.stride, take.header.samples))
    units = list(golden.channels.values())

    def nodes(
        kind: str, amounts: Array, allowed: float, text: Callable[[float], str]
    ) -> Deviations:
        bounds = np.full(len(golden.nodes), allowed)
        return Deviations(
            kind, golden.nodes, rows * a_row, amounts, bounds, lambda _, amount: text(amount)
        )

    return [
        nodes(
            "position",
            _distances(now, then, "positions", 3),
            motion_tolerance.POSITION,
            millimetres,
        ),
        nodes(
            "rotation",
            _angles(now["rotations"], then["rotations"]),
            motion_tolerance.ROTATION,
            degrees,
        ),
        nodes("scale", _distances(now, then, "scales", 3), motion_tolerance.SCALE, plain_number),
        nodes("alive", _distances(now, then, "alive", 1), 0.5, plain_number),
        Deviations(
            "channel",
            list(golden.channels),
            frames * a_row,
            _channel_differences(now["values"], then["values"], list(golden.channels), units),
            np.array([motion_tolerance.channel_tolerance(unit) for unit in units]),
            lambda n, amount: f"{amount:.3g} {units[n] if units[n] != '1' else ''}".rstrip(),
        ),
    ]


def ground_differences(golden: MotionGolden, take: Take) -> Iterator[Difference]:
    """Yield the difference of the ground of `take`, with as many vertices, from `golden`'s."""
    then = golden.series["terrain"].values
    now = sampled(take, golden.stride, (), ())["terrain"]
    amounts = np.linalg.norm(now - then, axis=-1)
    if not len(amounts) or not amounts.max() > motion_tolerance.POSITION:
        return
    most = int(np.argmax(amounts))
    x, y, z = now[most]
    yield Difference(
        WHOLE_TAKE,
        "ground",
        take.terrain.material,
        f"differs at {np.count_nonzero(amounts > motion_tolerance.POSITION)} "
        f"of {len(amounts)} places, most at ({x:.2f}, {y:.2f}, {z:.2f}): "
        f"{millimetres(float(amounts[most]))}",
    )


def degrees(radians: float) -> str:
    """Return an angle as text."""
    return f"{np.degrees(radians):.3g} degrees"


def plain_number(amount: float) -> str:
    """Return a number as text."""
    return f"{amount:.3g}"


def _distances(now: dict[str, Array], then: dict[str, Array], name: str, width: int) -> Array:
    """Return distances (K, J) between vectors of `width`."""
    apart = _by_node(now[name] - then[name], width)
    result: Array = np.linalg.norm(apart, axis=-1)
    return _nan_as_infinity(result)


def _angles(now: Array, then: Array) -> Array:
    """Return the angles (K, J) between rotations [rad]; a quaternion and its negative are equal.

    The chord between unit quaternions of rotations that are θ apart is 2 sin(θ/4), which is
    precise at small angles, unlike the cosine.
    """
    p, q = _by_node(now, 4), _by_node(then, 4)
    q = q / np.linalg.norm(q, axis=-1, keepdims=True)
    chord = np.minimum(np.linalg.norm(p - q, axis=-1), np.linalg.norm(p + q, axis=-1))
    result: Array = 4.0 * np.arcsin(np.minimum(chord / 2.0, 1.0))
    return _nan_as_infinity(result)


def _channel_differences(now: Array, then: Array, names: list[str], units: list[str]) -> Array:
    """Return differences (K, C); angles and phases are periodic."""
    apart = np.where(np.isnan(now) & np.isnan(then), 0.0, now - then)
    for c, (name, unit) in enumerate(zip(names, units, strict=True)):
        period = 2.0 * np.pi if unit == "rad" else 1.0 if name.endswith("phase") else 0.0
        if period:
            apart[:, c] -= period * np.rint(apart[:, c] / period)
    return _nan_as_infinity(np.abs(apart))


def _by_node(values: Array, width: int) -> Array:
    return values.reshape(len(values), values.shape[1] // width, width)


def _nan_as_infinity(amounts: Array) -> Array:
    return np.where(np.isnan(amounts), np.inf, amounts)


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
