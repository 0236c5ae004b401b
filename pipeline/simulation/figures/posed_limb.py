"""Posed limbs: joint values of one limb, as a function of time and of where its figure is.

The pose of every key is found first, from any other if need be, so that a limb does not stick in
the branch that led away from its goal. Between keys the joint values go from pose to pose, and all
rows at once are led from there to the goals of their own times. No row starts from the row before
it: what a limb does follows from the time and the place of its figure alone.

The poses of keys in the frames of feet or world change with the place of the body. They are looked
up anew in regular intervals, and the change comes in smoothly over the next one.

Source: Sims 1987, 3.2.2, 6.2 and B.3.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.curves import ease
from pipeline.simulation.figures.ball_joint_ik import ball_joint_branches, base_ball_joint
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.ik_goals import TipPlacement
from pipeline.simulation.figures.inverse_kinematics import closest_pose
from pipeline.simulation.figures.kinematics import LimbBatch, LimbPose
from pipeline.simulation.figures.limb_goals import CLEARANCE, Clearance, LimbGoals, pursue
from pipeline.simulation.figures.pose_plan import PointRun, PosePlan
from pipeline.simulation.figures.skeleton import BODY, Limb
from pipeline.simulation.figures.surroundings import LimbSamples, Surroundings
from pipeline.simulation.keyframe_track import (
    SAME_TIME,
    BlendedTrack,
    Key,
    Lift,
    LiftedTrack,
    Track,
    lift_share,
    rotation_from_angles,
)
from pipeline.simulation.spatial import Array, normalized, turn, turn_inverse
from pipeline.spec.keyframes import Frame, SmoothEase

MAX_JOINT_RATE = 14.0
"""Greatest rate of a joint [rad/s or m/s]."""

FULL_WEIGHT = 1.0 - 1e-9
"""Weight from which a run has taken over completely."""

KEY_STEPS, ROW_STEPS = 60, 10
"""Bounds on the steps to the pose of a key, and of a row."""

KEY_TOLERANCE = 1e-4
"""Error of a key's pose for which no other one is looked for, in lengths of the limb or radians."""

CANDIDATES, DRAWS = 12, 256
"""Poses that the search for a key's pose starts from, out of so many random ones and of those that
geometry gives."""

TRAVEL_COST = 0.05
"""Error that a start may have more for joints one radian nearer to the pose of the key before."""

CHECKED = np.linspace(0.0, 1.0, 9)
"""Where the way from key to key is checked, in fractions of its time."""

JUMP_RATIO, JUMP_ANGLE, CALM = 1.5, 0.35, 0.6
"""Joints jump that go farther between checks than this ratio of the direct way, unless it is no
more than this angle [rad] farther and at no more than this fraction of their greatest rate."""

DETOUR_END = 0.25
"""Fraction of a detour's time at each of its ends in which the goals are joined again."""

KNOT_SPACING, MOST_BETWEEN = 0.15, 12
"""Movement of goals, in lengths of the limb or radians, and greatest number, of knots between."""

SAMPLED = (1 / 3, 2 / 3, 1.0)
"""Fractions of links whose points keep clear of obstacles."""

RENEWAL = 0.25
"""Interval in which the poses of keys follow the place of the body [s]."""

MOVED_TARGET = 0.02
"""Movement of a target relative to the limb that needs a new pose, in lengths of the limb or
radians."""

DEPTH, DEPTH_COST = 0.02, 20.0
"""Depth in obstacles, in lengths of the limb, for which another pose is looked for, and joint
movement [rad] that a length less is worth."""

WAY = np.linspace(0.0, 1.0, 25)
"""Where the way of a place is searched for obstacles, in fractions of its time."""

LIFTS = np.arange(1, 25) * 0.05
"""Tried lifts of a way over obstacles, in lengths of the limb."""

MAX_LIFT_REACH = 0.97
"""Greatest distance of such a way from the base of the limb, in its length."""

MISS_FRACTION, MISS_ANGLE = 1e-2, 1e-2
"""Misses that are worth a note: of places, in lengths of the limb, and of angles [rad]."""


@dataclass(frozen=True, eq=False)
class FigureFrames:
    """The place of a figure in n rows, and the frames of its author's values.

    Attributes:
        times: (n,) [s].
        dt: between two rows [s].
        R_WB, p_WB: (n, 3, 3) and (n, 3) pose of its body [m].
        R_WG, p_WG: (n, 3, 3) and (n, 3) of the ground below it, x along its heading [m].
    """

    times: Array
    dt: float
    R_WB: Array
    p_WB: Array
    R_WG: Array
    p_WG: Array

    def frame(self, name: Frame) -> tuple[Array, Array]:
        """Return the pose in the world of a frame named by the author."""
        if name == "body":
            return self.R_WB, self.p_WB
        if name == "feet":
            return self.R_WG, self.p_WG
        return np.broadcast_to(np.eye(3), self.R_WB.shape), np.zeros_like(self.p_WB)


@dataclass(frozen=True, eq=False)
class LimbParent:
    """What a limb hangs on, relative to the body, in n rows; the body itself is the identity.

    Attributes:
        R_BP: (n, 3, 3) turned from how it was drawn.
        p_BP: (n, 3) [m].
    """

    R_BP: Array
    p_BP: Array

    @staticmethod
    def body(rows: int) -> LimbParent:
        """Return the body."""
        return LimbParent(np.broadcast_to(np.eye(3), (rows, 3, 3)), np.zeros((rows, 3)))

    def repeated(self, row: int, count: int) -> LimbParent:
        """Return one row `count` times."""
        return LimbParent(
            np.broadcast_to(self.R_BP[row], (count, 3, 3)),
            np.broadcast_to(self.p_BP[row], (count, 3)),
        )


Foresight = Callable[[int, Array], FigureFrames]
"""Frames of the figure at times (k,), as they are foreseen in a row."""


def point_targets(point_run: PointRun, frames: FigureFrames, parent: LimbParent) -> Array:
    """Return the targets of a node in n rows, relative to what its limb hangs on.

    Returns:
        Places (n, 3) [m], directions (n, 3), or rotations (n, 3, 3).
    """
    values = point_run.run.track(frames.times)
    R_WG, p_WG = frames.frame(point_run.frame)
    R_WP = frames.R_WB @ parent.R_BP
    if point_run.goal == "reach":
        p_WP = frames.p_WB + turn(frames.R_WB, parent.p_BP)
        return turn_inverse(R_WP, p_WG + turn(R_WG, values) - p_WP)
    if point_run.goal == "aim":
        return normalized(turn_inverse(R_WP, turn(R_WG, values)))
    return R_WP.transpose(0, 2, 1) @ R_WG @ rotation_from_angles(values)


@dataclass(frozen=True, slots=True)
class GoalMiss:
    """A goal that a limb misses.

    Attributes:
        row: of the miss.
        limb: name of the limb.
        part: the node or joint, as its author named it.
        at: time of the key [s]; None where a goal is lost that was held.
        gap: [m], or [rad] of directions and joints that turn.
        is_place: whether it is a distance.
        is_slow: whether the joints turn too slowly; else it is out of reach.
    """

    row: int
    limb: str
    part: str
    at: float | None
    gap: float
    is_place: bool
    is_slow: bool

    @property
    def text(self) -> str:
        """A sentence for the author."""
        distance = f"{self.gap:.2g} m" if self.is_place else f"{math.degrees(self.gap):.2g} degrees"
        reason = "its joints would have to turn faster" if self.is_slow else "it is out of reach"
        if self.at is None:
            return f"{self.part} no longer keeps its goal, by {distance}: {reason}"
        return f"{self.part} misses its key at {self.at:g} s by {distance}: {reason}"


@dataclass(slots=True, eq=False)
class _Knot:
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


def samples_of(figure: Figure, limb: Limb, points: Sequence[PointRun]) -> LimbSamples:
    """Return points along the links of a limb, but not those that its author places."""
    columns, places, radii = list[int](), list[Array](), list[float]()
    placed = [run.point.place for run in points if run.goal == "reach"]
    for number in limb.links:
        link = figure.skeleton.links[number]
        if link.joint not in limb.joints:
            continue
        for part in SAMPLED:
            place = link.ends[0] + part * (link.ends[1] - link.ends[0])
            if any(float(np.abs(place - other).max()) < 1e-9 for other in placed):
                continue
            columns.append(limb.joints.index(link.joint))
            places.append(place)
            radii.append(link.radii[0] + part * (link.radii[1] - link.radii[0]))
    return LimbSamples(np.array(columns), np.array(places), np.array(radii))


class PosedLimb:
    """One posed limb of a figure."""

    def __init__(
        self,
        figure: Figure,
        number: int,
        plan: PosePlan,
        rng: np.random.Generator,
        surroundings: Surroundings,
    ) -> None:
        skeleton = figure.skeleton
        self.figure = figure
        self.limb = skeleton.limbs[number]
        self.batch = LimbBatch.of([(skeleton, self.limb)])
        self.above = int(skeleton.parents[self.limb.joints[0]])
        self.points = [run for run in plan.points if run.limb == number]
        self.joints = [run for run in plan.joints if run.limb == number]
        runs = [*self.points, *self.joints]
        self.dexterity = max(run.dexterity for run in runs)
        self.surroundings = surroundings
        if all(run.avoid is not None for run in runs):
            self.surroundings = surroundings.only({n for run in runs for n in run.avoid or ()})
        self._samples = samples_of(figure, self.limb, self.points)
        shape = DRAWS, self.batch.lower.shape[1]
        self._draws = self.batch.lower + rng.random(shape) * (self.batch.upper - self.batch.lower)
        self._body = plan.body
        self._knots = list[_Knot]()
        self._renewed = -math.inf
        self._last: Array | None = None
        self._lags = False
        self._missing = np.zeros(len(self.points) + len(self.joints), dtype=bool)

    def weights(self, times: Array) -> Array:
        """Return the weights (n, m) of each point, then of each joint."""
        runs = [asked.run for asked in (*self.points, *self.joints)]
        return np.stack([run.weight(times) for run in runs], axis=-1)

    def weight(self, times: Array) -> Array:
        """Return the weight (n,) of the demands against the limb's own motion."""
        return self.weights(times).max(axis=-1)

    def follow(
        self, q: Array, frames: FigureFrames, parent: LimbParent, foresight: Foresight
    ) -> tuple[Array, list[GoalMiss]]:
        """Return posed joint values (n, k), and misses.

        Args:
            q: (n, k) the limb's own values [rad or m].
            frames: of the figure.
            parent: of the limb.
            foresight: of the frames.
        """
        weights = self.weights(frames.times)
        goals = self._goals(frames, parent, q)
        result, count = q.copy(), len(self.points)
        for i, run in enumerate(self.joints):
            own = result[:, run.column]
            result[:, run.column] = own + weights[:, count + i] * (goals.values[:, i] - own)
        most = weights[:, :count].max(axis=-1, initial=0.0)
        if most.any():
            shares = weights.copy()
            shares[:, :count] /= np.where(most > 0.0, most, 1.0)[:, None]
            if not self._knots:
                self._clear_ways(int(np.flatnonzero(most)[0]), parent, foresight)
                self._knots = list(self._find_knots(self._body))
                goals = self._goals(frames, parent, q)
            seeds = self._seeds(result, frames, parent, foresight, most > 0.0)
            kept, adherence = self._detours(frames.times)
            asked = goals
            if (kept != frames.times).any():
                shares[:, :count] *= adherence[:, None]
                asked = self._goals(replace(frames, times=kept), parent, q)
                asked = replace(asked, values=goals.values)
            found = self._rows(asked, shares, seeds, np.flatnonzero(most > 0.0))
            result += most[:, None] * (found - result)
        result, slow = self._limited(result, most > 0.0, frames.dt)
        return result, list(self._misses(goals, result, weights, slow, frames))

    def _goals(self, frames: FigureFrames, parent: LimbParent, pull: Array) -> LimbGoals:
        times = frames.times
        values = [run.run.track(times)[:, 0] for run in self.joints]
        return LimbGoals(
            self.points,
            self.joints,
            [point_targets(run, frames, parent) for run in self.points],
            np.stack(values, axis=-1) if values else np.zeros((len(times), 0)),
            pull,
            self.dexterity,
            self._clearance(frames, parent),
        )

    def _clearance(self, frames: FigureFrames, parent: LimbParent) -> Clearance | None:
        R_WP = frames.R_WB @ parent.R_BP
        p_WP = frames.p_WB + turn(frames.R_WB, parent.p_BP)
        base = p_WP + turn(R_WP, self.batch.places[0, 0])
        reach = float(self.batch.lengths[0])
        near = self.surroundings.near(frames.times, base, reach * (1.0 + 2.0 * CLEARANCE))
        if near.is_empty:
            return None
        return Clearance(near, self._samples, frames.times, R_WP, p_WP)

    # --- rows -----------------------------------------------------------------------

    def _rows(
        self, goals: LimbGoals, shares: Array, seeds: Array, rows: NDArray[np.int64]
    ) -> Array:
        """Return joint values (n, k) that meet goals with `shares` (n, m), from those of knots."""
        result = seeds.copy()
        kinds = (shares[rows] > 0.0).astype(int) + (shares[rows] > FULL_WEIGHT)
        for kind in np.unique(kinds, axis=0):
            chosen = rows[(kinds == kind).all(axis=1)]
            start = seeds[chosen]
            # The poses of knots keep clear of obstacles; what lies between follows them.
            there = replace(goals.rows(chosen), pull=start, clearance=None, dexterity=0.0)
            pose = self.batch.pose(start)
            if (kind == 2).any():
                whole = there.only((kind == 2).tolist())
                pose = pursue(self.batch, start, whole, ROW_STEPS)
            if (kind == 1).any():
                # Goals that are still taking over ask for a fraction of their way.
                partial = there.partly(shares[chosen], self.batch, pose)
                part = partial.only((kind > 0).tolist())
                pose = pursue(self.batch, pose.q, part, ROW_STEPS)
            result[chosen] = pose.q
        return result

    def _limited(
        self, q: Array, is_active: NDArray[np.bool_], dt: float
    ) -> tuple[Array, NDArray[np.bool_]]:
        """Return joint values (n, k), none faster than joints can be, and rows that lag (n,).

        A limb that lags catches up, even after its release.
        """
        most = MAX_JOINT_RATE * dt
        slow = np.zeros(len(q), dtype=bool)
        before = q[0] if self._last is None else self._last
        steps = np.abs(np.diff(q, axis=0, prepend=before[None])).max(axis=1, initial=0.0)
        if (steps > most).any():
            q = q.copy()
            for row in range(len(q)):
                step = q[row] - before
                fastest = float(np.abs(step).max())
                if is_active[row] or self._lags:
                    slow[row] = self._lags = fastest > most
                    q[row] = before + step * (most / max(fastest, most))
                before = q[row]
        self._last = q[-1].copy()
        return q, slow

    # --- ways -----------------------------------------------------------------------

    def _clear_ways(self, row: int, parent: LimbParent, foresight: Foresight) -> None:
        """Lead the ways between places around what is in them, as far as is foreseen in `row`."""
        for i, asked in enumerate(self.points):
            track = asked.run.track
            if asked.goal != "reach" or self.surroundings.is_empty:
                continue
            lifts = []
            for first, last in itertools.pairwise(track.times.tolist()):
                times = first + (last - first) * WAY
                moved = float(np.abs(np.ptp(track(times), axis=0)).max())
                if last - first > SAME_TIME and moved > CLEARANCE * float(self.batch.lengths[0]):
                    frames = foresight(row, times)
                    lift = self._lift(asked, frames, parent.repeated(row, len(times)))
                    if lift is not None:
                        lifts.append(Lift(first, last, lift))
            if lifts:
                around = LiftedTrack(track.times, track.values, track.eases, None, tuple(lifts))
                self.points[i] = replace(asked, run=replace(asked.run, track=around))

    def _lift(self, asked: PointRun, frames: FigureFrames, parent: LimbParent) -> Array | None:
        """Return by how much (3,) a way leads aside, in the frame of its places; None for none.

        The least of several: upward, to the sides, or towards the base of the limb [m].
        """
        size = float(self.batch.lengths[0])
        R_WG, p_WG = frames.frame(asked.frame)
        way = p_WG + turn(R_WG, asked.run.track(frames.times))
        base = frames.p_WB + turn(frames.R_WB, parent.p_BP)
        base = base + turn(frames.R_WB @ parent.R_BP, self.batch.places[0, 0])
        radius = float(self._radius_at(asked))
        keep = 2.0 * CLEARANCE * size

        def gaps(points: Array) -> Array:
            gap: Array = self.surroundings.gaps(frames.times, points[:, None])[0].min(axis=(1, 2))
            return gap - radius

        rise = lift_share(WAY)
        own = gaps(way)
        # Places that touch something are met as they are.
        needed = rise * keep + (1.0 - rise) * np.minimum(np.where(WAY < 0.5, own[0], own[-1]), keep)
        if (own >= needed - 1e-9).all():
            return None
        ahead = way[-1] - way[0]
        side = normalized(np.array([-ahead[2], 0.0, ahead[0]]) + 1e-12)
        back = normalized(base.mean(axis=0) - way.mean(axis=0))
        for amount in LIFTS * size:
            for aside in (np.array([0.0, 1.0, 0.0]), side, -side, back):
                there = way + amount * rise[:, None] * aside
                far = np.linalg.norm(there - base, axis=-1)
                if far.max() < MAX_LIFT_REACH * size and (gaps(there) >= needed - 1e-9).all():
                    return turn_inverse(R_WG[0], amount * aside)
        return None

    def _radius_at(self, asked: PointRun) -> float:
        links = (self.figure.skeleton.links[number] for number in self.limb.links)
        near = [link for link in links if np.abs(link.ends[1] - asked.point.place).max() < 1e-9]
        return near[0].radii[1] if near else 0.0

    # --- knots ----------------------------------------------------------------------

    def _find_knots(self, body: Sequence[BlendedTrack]) -> Iterator[_Knot]:
        """Return the knots in the order of time.

        Args:
            body: what the author asks of the body, which carries the limb.
        """
        eases: dict[float, SmoothEase] = {}
        for run in [asked.run for asked in (*self.points, *self.joints)]:
            for time in (*run.taken, *run.let_go):
                if math.isfinite(time):
                    eases.setdefault(time, "in-out")
            for time, way in list(zip(run.track.times.tolist(), run.track.eases, strict=True))[1:]:
                # Joints between two keys turn without stopping where the goal does not stop.
                eases[time] = way if way != "hold" else "in-out"
        ends = sorted(eases)
        times = [(ends[0], False)]
        for start, end in itertools.pairwise(ends):
            count = self._between(start, end, body)
            times += [(start + (end - start) * k / (count + 1), True) for k in range(1, count + 1)]
            times.append((end, False))
            if count:
                eases[end] = "spline"
        count = len(self.points)
        weights = self.weights(np.array([time for time, _ in times]))
        for (time, is_between), w in zip(times, weights, strict=True):
            most = w[:count].max(initial=0.0)
            whole = w >= FULL_WEIGHT
            whole[:count] = w[:count] >= FULL_WEIGHT * most
            taken = tuple((whole & (most > 0.0)).tolist())
            yield _Knot(time, taken, eases.get(time, "spline"), is_between)

    def _between(self, start: float, end: float, body: Sequence[BlendedTrack]) -> int:
        """Return the number of knots that the way from one time to another needs between them."""
        size, times = float(self.batch.lengths[0]), start + (end - start) * CHECKED

        def length(track: Track) -> float:
            return float(np.abs(np.diff(track(times), axis=0)).sum(axis=0).max())

        ways = [length(run.track) / size for run in body]
        for asked in (*self.points, *self.joints):
            unit = size if isinstance(asked, PointRun) and asked.goal == "reach" else 1.0
            ways.append(length(asked.run.track) / unit)
        return min(int(max(ways) / KNOT_SPACING), MOST_BETWEEN)

    def _seeds(
        self,
        own: Array,
        frames: FigureFrames,
        parent: LimbParent,
        foresight: Foresight,
        is_active: NDArray[np.bool_],
    ) -> Array:
        """Return joint values (n, k) on the way from knot to knot; `own` (n, k) elsewhere."""
        result, times = own.copy(), frames.times
        # By the clock, so that rows do not depend on how many are worked out together.
        periods = np.floor(times / RENEWAL + SAME_TIME)
        for period in np.unique(periods[is_active]):
            rows = np.flatnonzero((periods == period) & is_active)
            near = self._near_knots(period * RENEWAL)
            if period != self._renewed:
                self._renew(near, int(rows[0]), own, parent, foresight)
                self._renewed = period
            near = self._complete(near, int(rows[0]), own, parent, foresight)
            part = (times[rows] / RENEWAL - period)[:, None]
            before, after = (
                self._way(near, [getattr(knot, name) for knot in near], times[rows])
                for name in ("before", "after")
            )
            result[rows] = before + part * (after - before)
        return result

    def _near_knots(self, start: float) -> list[_Knot]:
        """Return the knots that rows of a period need, and one more on each side for a spline.

        They are those of whole ways from key to key.
        """
        knots, times = self._knots, [knot.time for knot in self._knots]
        first = max(int(np.searchsorted(times, start, side="right")) - 2, 0)
        last = min(int(np.searchsorted(times, start + RENEWAL, side="right")) + 1, len(knots) - 1)
        while knots[first].is_between:
            first -= 1
        while knots[last].is_between:
            last += 1
        return knots[first : last + 1]

    def _way(self, knots: list[_Knot], poses: list[Array | None], times: Array) -> Array:
        """Return joint values (n, k) on the way through the poses of knots."""
        keys = list[Key]()
        for i, knot in enumerate(knots):
            pose, way = poses[i], knot.ease
            if pose is None:
                # Nothing is asked of the limb here: it holds the pose that it leaves or awaits.
                sides = [p for p in (*poses[max(i - 1, 0) : i], *poses[i + 1 : i + 2])]
                pose, way = next((p for p in sides if p is not None), None), "in-out"
            if pose is not None:
                keys.append((knot.time, pose.tolist(), way))
        return np.clip(Track.of(keys)(times), self.batch.lower, self.batch.upper)

    def _renew(
        self, knots: list[_Knot], row: int, own: Array, parent: LimbParent, foresight: Foresight
    ) -> None:
        """Let the poses of knots follow what has become of their targets."""
        for knot in knots:
            knot.before = knot.after
        if self.above == BODY and all(run.frame == "body" for run in self.points):
            return
        for knot, goals in self._goals_of(knots, row, own, parent, foresight):
            if knot.after is None or knot.targets is None:
                continue
            if self._has_moved(knot.targets, goals):
                found = pursue(self.batch, knot.after[None], goals, ROW_STEPS)
                if knot.is_between or self._cost(goals, found)[0] < KEY_TOLERANCE:
                    knot.after = found.q[0]
                else:
                    knot.after = self._pose_of(goals, own[row], knot.after)
                knot.targets = goals

    def _complete(
        self, knots: list[_Knot], row: int, own: Array, parent: LimbParent, foresight: Foresight
    ) -> list[_Knot]:
        """Find the poses of knots that have none; return the knots that are left."""
        if all(knot.after is not None or not any(knot.taken) for knot in knots):
            return knots
        way = list[tuple[_Knot, LimbGoals]]()
        for knot, goals in list(self._goals_of(knots, row, own, parent, foresight)):
            way.append((knot, goals))
            if knot.is_between:
                continue
            if knot.after is None and any(knot.taken) and not self._track(way):
                first, inner = way[0][0], [there for there, _ in way[1:-1]]
                knots = [k for k in knots if k not in inner]
                self._knots = [k for k in self._knots if k not in inner]
                start = own[row] if first.after is None else first.after
                knot.before = knot.after = self._pose_of(goals, own[row], start)
                left = self._cost(goals, self.batch.pose(knot.after[None]))[0]
                knot.is_met = bool(left < KEY_TOLERANCE)
                knot.targets = goals
                taken = tuple(a and b for a, b in zip(first.taken, knot.taken, strict=True))
                if first is not knot and any(taken[: len(self.points)]):
                    times = first.time + (knot.time - first.time) * CHECKED
                    there = parent.repeated(row, len(times))
                    direct = self._way(knots, [k.after for k in knots], times)
                    asked = self._goals(foresight(row, times), there, direct).only(taken)
                    knot.detours = not self._leads_through(asked, direct, times[1] - times[0])
            way = [(knot, goals)]
        return knots

    def _track(self, way: list[tuple[_Knot, LimbGoals]]) -> bool:
        """Follow goals from the first knot of a way to the last; return whether they were met."""
        first = way[0][0]
        if len(way) == 1 or first.after is None:
            return False
        q = first.after[None]
        for knot, goals in way[1:]:
            most = KEY_STEPS if knot is way[-1][0] else ROW_STEPS
            least = 1 if goals.clearance is None else ROW_STEPS
            q = pursue(self.batch, q, goals, most, least).q
            if self._cost(goals, self.batch.pose(q))[0] > KEY_TOLERANCE:
                return False
            knot.before = knot.after = q[0]
            knot.targets = goals
        return True

    def _leads_through(self, goals: LimbGoals, way: Array, dt: float) -> bool:
        """Return whether the goals of n rows can be met without jumps, near a `way` (n, k)."""
        inner = goals.rows(np.arange(1, len(way) - 1))
        found = pursue(self.batch, way[1:-1], inner, ROW_STEPS)
        q = np.concatenate([way[:1], found.q, way[-1:]])
        ends = self._cost(goals, self.batch.pose(way))[[0, -1]].max()
        largest, least = (float(np.abs(np.diff(rows, axis=0)).max()) for rows in (q, way))
        most = max(JUMP_RATIO * least, min(least + JUMP_ANGLE, CALM * MAX_JOINT_RATE * dt))
        missed = float(self._cost(inner, found).max())
        return bool(largest < most and missed < ends + KEY_TOLERANCE)

    def _detours(self, times: Array) -> tuple[Array, Array]:
        """Return whose times' goals rows keep (n,) [s], and how far (n,).

        Those of their own times, fully; but on a detour those of the key that was, less and less,
        and then of the key that is to be.
        """
        knots = self._knots
        ends = np.array([knot.time for knot in knots])
        detours = np.array([bool(knot.detours) for knot in knots])
        met = np.array([knot.is_met for knot in knots])
        right = np.clip(np.searchsorted(ends, times, side="right"), 1, len(ends) - 1)
        away = detours[right] & (times > ends[right - 1]) & (times < ends[right])
        if not away.any():
            return times, np.ones(len(times))
        s = (times - ends[right - 1]) / np.maximum(ends[right] - ends[right - 1], SAME_TIME)
        near = np.where(s < 0.5, right - 1, right)
        share = 1.0 - ease(np.clip(np.minimum(s, 1.0 - s) / DETOUR_END, 0.0, 1.0))
        return np.where(away, ends[near], times), np.where(away, share * met[near], 1.0)

    def _goals_of(
        self, knots: list[_Knot], row: int, own: Array, parent: LimbParent, foresight: Foresight
    ) -> Iterator[tuple[_Knot, LimbGoals]]:
        """Return the goals (one row) of knots, as foreseen in `row`."""
        times = np.array([knot.time for knot in knots])
        if not len(times):
            return
        pull = np.broadcast_to(own[row], (len(times), own.shape[1]))
        goals = self._goals(foresight(row, times), parent.repeated(row, len(times)), pull)
        for i, knot in enumerate(knots):
            yield knot, goals.only(knot.taken).rows(np.array([i]))

    def _has_moved(self, before: LimbGoals, now: LimbGoals) -> bool:
        size = float(self.batch.lengths[0])
        moves = [
            float(np.abs(a - b).max()) / (size if run.goal == "reach" else 1.0)
            for run, a, b in zip(now.points, before.targets, now.targets, strict=True)
        ]
        return max(moves, default=0.0) > MOVED_TARGET

    # --- the pose of a key ----------------------------------------------------------

    def _pose_of(self, goals: LimbGoals, own: Array, start: Array) -> Array:
        """Return joint values (k,) for goals (one row), as near to `start` (k,) as there are any.

        Args:
            goals: of one row.
            own: (k,) the limb's own values.
            start: (k,) of the key before.
        """
        near = self._pursued(goals, np.stack([start, own]))
        own_cost = self._cost(goals.repeated(2), near)[0]
        if own_cost < KEY_TOLERANCE and self._depth(goals.repeated(2), near)[0] < DEPTH:
            return near.q[0]
        starts = np.concatenate([near.q, self._candidates(goals, start)])
        found = self._pursued(goals, starts)
        cost = self._cost(goals.repeated(len(starts)), found)
        depth = self._depth(goals.repeated(len(starts)), found)
        travel = np.abs(found.q - start).max(axis=1) + DEPTH_COST * depth
        reached = cost < KEY_TOLERANCE
        if reached.any():
            return found.q[np.where(reached, travel, np.inf).argmin()]
        return self._closest(goals, found.rows(np.array([cost.argmin()])))

    def _depth(self, goals: LimbGoals, pose: LimbPose) -> Array:
        """Return how deep (n,) links are in obstacles, in lengths of the limb."""
        if goals.clearance is None:
            return np.zeros(len(pose.q))
        gap = goals.clearance.least_gap(pose, self.batch)
        result: Array = np.maximum(-gap / self.batch.lengths[0], 0.0)
        return result

    def _pursued(self, goals: LimbGoals, starts: Array) -> LimbPose:
        same = goals.repeated(len(starts))
        return pursue(self.batch, starts, same, KEY_STEPS, min_steps=KEY_STEPS // 4)

    def _cost(self, goals: LimbGoals, pose: LimbPose) -> Array:
        """Return the errors (n,) of poses, those of lower priority counting little.

        Gaps from obstacles are left out.
        """
        return self._whole_cost(replace(goals, clearance=None), pose)

    def _whole_cost(self, goals: LimbGoals, pose: LimbPose) -> Array:
        """Return the errors (n,) with missing gaps, which count less than any goal."""
        return np.linalg.norm(goals.task(self.batch, pose).velocity, axis=-1)

    def _candidates(self, goals: LimbGoals, start: Array) -> Array:
        """Return joint values (c, k) to search from."""
        batch = self.batch
        draws = [self._draws, batch.preferred, 0.5 * (batch.lower + batch.upper)]
        last = batch.lower.shape[1] - 1
        for run, target in zip(goals.points, goals.targets, strict=True):
            if run.goal == "reach" and run.point.column == last and base_ball_joint(batch).any():
                draws.append(ball_joint_branches(batch, target)[:, 0])
        q = np.concatenate(draws)
        cost = self._whole_cost(goals.repeated(len(q)), batch.pose(q))
        cost += TRAVEL_COST * np.abs(q - start).max(axis=1)
        return q[np.argsort(cost, kind="stable")[:CANDIDATES]]

    def _closest(self, goals: LimbGoals, pose: LimbPose) -> Array:
        """Return joint values (k,) from which no small movement leads nearer to the goals."""
        last = self.batch.lower.shape[1] - 1
        runs = goals.points
        if self._cost(goals, pose)[0] < KEY_TOLERANCE:
            return pose.q[0]
        if len(runs) == 1 and runs[0].goal == "reach" and runs[0].point.column == last:
            pose = closest_pose(self.batch, pose, TipPlacement(goals.targets[0]))
        return pose.q[0]

    # --- misses ---------------------------------------------------------------------

    def _misses(
        self,
        goals: LimbGoals,
        q: Array,
        weights: Array,
        slow: NDArray[np.bool_],
        frames: FigureFrames,
    ) -> Iterator[GoalMiss]:
        """Return keys that are missed, and goals that are lost while they are to be held."""
        runs = [*self.points, *self.joints]
        whole = weights > FULL_WEIGHT
        rows = np.flatnonzero(whole.any(axis=1))
        if not len(rows):
            self._missing[:] = False
            return
        gaps = np.zeros(weights.shape)
        gaps[rows] = goals.rows(rows).misses(self.batch, self.batch.pose(q[rows]))
        size = float(self.batch.lengths[0])
        for i, asked in enumerate(runs):
            is_place = isinstance(asked, PointRun) and asked.goal == "reach"
            most = MISS_FRACTION * size if is_place else MISS_ANGLE
            missed = (gaps[:, i] > most) & whole[:, i]
            before = np.logical_or.accumulate(np.append(self._missing[i], missed[:-1]))
            before &= whole[:, i]
            # A goal that is held is lost once, however a body sways.
            self._missing[i] = (before[-1] or missed[-1]) and whole[-1, i]
            if not missed.any():
                continue
            keys = asked.run.track.times
            passed = np.searchsorted(keys, frames.times + SAME_TIME, side="right")
            earlier = np.searchsorted(keys, frames.times - frames.dt + SAME_TIME, side="right")
            is_held = (passed == len(keys)) & (earlier == passed)
            for row in np.flatnonzero(missed & ((passed > earlier) | (is_held & ~before))):
                at = float(keys[passed[row] - 1]) if passed[row] > earlier[row] else None
                yield GoalMiss(
                    row=int(row),
                    limb=self.limb.name,
                    part=asked.name,
                    at=at,
                    gap=float(gaps[row, i]),
                    is_place=is_place,
                    is_slow=bool(slow[row]),
                )
