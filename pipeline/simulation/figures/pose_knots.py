"""Pose knots: times between which the joints of a posed limb go from pose to pose."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.figures.goal_miss import FULL_WEIGHT
from pipeline.simulation.figures.limb_goals import LimbGoals
from pipeline.simulation.figures.pose_plan import JointRun, PointRun
from pipeline.simulation.keyframe_track import BlendedTrack, Track
from pipeline.simulation.spatial import Array
from pipeline.spec.keyframes import SmoothEase

KNOT_SPACING, MOST_BETWEEN = 0.15, 12
"""Movement of goals, in lengths of the limb or radians, and greatest number, of knots between."""

CHECKED = np.linspace(0.0, 1.0, 9)
"""Where the way from key to key is checked, in fractions of its time."""


@dataclass(slots=True, eq=False)
class Knot:
    """A time at which goals change: of a key, or where one takes over or ends.

    Attributes:
        time: [s].
        taken: which of the points, then of the joints, hold the limb there alone.
        ease: that leads to it.
        is_between: whether it stands on the way between two others.
        detours: whether the joints lead to it regardless of the goals on the way, because on the
            way of the goals they would have to jump; None until it is known.
        is_met: whether its pose meets its goals.
        before, after: (k,) its pose at the last renewal and the next; None until it is needed.
        targets: goals for which `after` was found.
    """

    time: float
    taken: tuple[bool, ...]
    ease: SmoothEase
    is_between: bool
    detours: bool | None = None
    is_met: bool = True
    before: Array | None = None
    after: Array | None = None
    targets: LimbGoals | None = None


def weights_of(asked: Sequence[PointRun | JointRun], times: Array) -> Array:
    """Return the weights (n, m) of demands at `times` (n,)."""
    return np.stack([one.run.weight(times) for one in asked], axis=-1)


def find_knots(
    points: Sequence[PointRun],
    joints: Sequence[JointRun],
    body: Sequence[BlendedTrack],
    size: float,
) -> Iterator[Knot]:
    """Return the knots in the order of time.

    Args:
        points: goals of the limb's nodes.
        joints: goals of its joints.
        body: what the author asks of the body, which carries the limb.
        size: length of the limb [m].
    """
    eases: dict[float, SmoothEase] = {}
    for run in [asked.run for asked in (*points, *joints)]:
        for time in (*run.taken, *run.let_go):
            if math.isfinite(time):
                eases.setdefault(time, "in-out")
        for time, way in list(zip(run.track.times.tolist(), run.track.eases, strict=True))[1:]:
            # Joints between two keys turn without stopping where the goal does not stop.
            eases[time] = way if way != "hold" else "in-out"
    ends = sorted(eases)
    times = [(ends[0], False)]
    for start, end in itertools.pairwise(ends):
        count = _between((*points, *joints), body, size, start, end)
        times += [(start + (end - start) * k / (count + 1), True) for k in range(1, count + 1)]
        times.append((end, False))
        if count:
            eases[end] = "spline"
    count = len(points)
    weights = weights_of((*points, *joints), np.array([time for time, _ in times]))
    for (time, is_between), w in zip(times, weights, strict=True):
        most = w[:count].max(initial=0.0)
        whole = w >= FULL_WEIGHT
        whole[:count] = w[:count] >= FULL_WEIGHT * most
        taken = tuple((whole & (most > 0.0)).tolist())
        yield Knot(time, taken, eases.get(time, "spline"), is_between)


def _between(
    asked: Sequence[PointRun | JointRun],
    body: Sequence[BlendedTrack],
    size: float,
    start: float,
    end: float,
) -> int:
    """Return the number of knots that the way from one time to another needs between them."""
    times = start + (end - start) * CHECKED

    def length(track: Track) -> float:
        return float(np.abs(np.diff(track(times), axis=0)).sum(axis=0).max())

    ways = [length(run.track) / size for run in body]
    for one in asked:
        unit = size if isinstance(one, PointRun) and one.goal == "reach" else 1.0
        ways.append(length(one.run.track) / unit)
    return min(int(max(ways) / KNOT_SPACING), MOST_BETWEEN)
