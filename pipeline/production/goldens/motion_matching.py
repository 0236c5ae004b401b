"""Matching: which mark of a take answers which of its golden."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator
from itertools import zip_longest
from math import dist

from pipeline.production.goldens import motion_tolerance
from pipeline.production.goldens.motion_deviations import millimetres
from pipeline.production.goldens.motion_marks import Mark
from pipeline.production.goldens.motion_verdict import Difference

ROUNDING = 1e-3
"""More than moments [steps] and speeds [m/s] are rounded by."""


def unmatched(then: Iterable[Mark], now: Iterable[Mark], steps: int) -> Iterator[Difference]:
    """Yield what is missing, new, or moved beyond tolerance.

    Marks of one kind, part and word answer one another in the order of time.

    Args:
        then: marks of the golden.
        now: marks of the take.
        steps: world steps a frame.
    """
    groups: dict[tuple[str, str, str], tuple[list[Mark], list[Mark]]]
    groups = defaultdict(lambda: ([], []))
    for side, marks in enumerate((then, now)):
        for mark in marks:
            groups[mark.kind, mark.who, mark.what][side].append(mark)
    for old, new in groups.values():
        for one, two in _pairs(old, new):
            text = _told(one, two, steps)
            if text:
                moment = min(mark.moment for mark in (one, two) if mark)
                kind, who = (one or two or new[0]).kind, (one or two or new[0]).who
                yield Difference(int(moment), kind, who, text)


def _pairs(old: list[Mark], new: list[Mark]) -> Iterator[tuple[Mark | None, Mark | None]]:
    """Yield pairs in the order of time; as many as there were answer one by one."""
    old, new = (sorted(marks, key=lambda mark: mark.moment) for marks in (old, new))
    if len(old) == len(new):
        yield from zip_longest(old, new)
        return
    n = 0
    for one in old:
        while n < len(new) and new[n].moment < one.moment - motion_tolerance.MOMENT:
            yield None, new[n]
            n += 1
        if n < len(new) and new[n].moment <= one.moment + motion_tolerance.MOMENT:
            yield one, new[n]
            n += 1
        else:
            yield one, None
    yield from ((None, two) for two in new[n:])


def _told(one: Mark | None, two: Mark | None, steps: int) -> str:
    """Return how a mark differs from its golden `one`, empty if within tolerance."""
    if one is None or two is None:
        mark = one or two
        fate = "is missing" if one else "is new"
        return f"{mark.what} at step {mark.moment:g}: this {mark.kind} {fate}" if mark else ""
    late = two.moment - one.moment
    what = f"{one.what} at step {one.moment:g}"
    if abs(late) > motion_tolerance.MOMENT + ROUNDING:
        return f"{what}: {one.kind} moved to step {two.moment:g}, frame {_frames(one, two)}"
    if one.frame != two.frame and not _boundary_between(one, two, steps):
        return f"{what}: {one.kind} moved from frame {one.frame} to {two.frame}"
    if one.place and (apart := dist(one.place, two.place)) > motion_tolerance.PLACE:
        return f"{what}: {one.kind} lies {millimetres(apart)} off"
    bound = motion_tolerance.STRENGTH * (1.0 + abs(one.strength)) + ROUNDING
    if abs(two.strength - one.strength) > bound:
        return f"{what}: {one.kind} of {two.strength:g} m/s instead of {one.strength:g} m/s"
    return ""


def _frames(one: Mark, two: Mark) -> str:
    return f"{two.frame} instead of {one.frame}"


def _boundary_between(one: Mark, two: Mark, steps: int) -> bool:
    """Say whether the moments lie on two sides of a frame, which explains another frame."""
    if abs(one.frame - two.frame) != 1:
        return False
    edge = (min(one.frame, two.frame) - 1) * steps
    early, late = sorted((one.moment, two.moment))
    return early - ROUNDING <= edge <= late + ROUNDING
