"""Pose plan: an author's keys for a figure -> runs of tracks, each about one thing.

Keys about the same thing follow one another on one track, until a release ends it; a key
after that begins a run of its own.

Source: Sims 1987, 3.2.2.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from pipeline.errors import Problem, SceneError
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.part_names import PartNames
from pipeline.simulation.figures.point_goals import LimbPoint
from pipeline.simulation.tracks import Run, Track
from pipeline.spec.keyframes import GOALS, Ease, Frame, PoseKey
from pipeline.spec.suggestions import hint

BODY = "body"

POINTS_FIRST, JOINTS_FIRST = 1, 2
"""Priorities that are taken if none is given."""


@dataclass(frozen=True, eq=False)
class Asked:
    """What is asked of a part of one limb.

    Attributes:
        limb: number of the limb.
        run: the values over time.
        priority: 1 comes first.
        weight: among what has that priority.
    """

    limb: int
    run: Run
    priority: int
    weight: float


@dataclass(frozen=True, eq=False)
class PointRun(Asked):
    """What is asked of one node: a place [m], a direction, or angles [rad].

    Attributes:
        point: the node.
        goal: "reach", "aim" or "turn_deg".
        frame: what the values are relative to.
    """

    point: LimbPoint
    goal: str
    frame: Frame


@dataclass(frozen=True, eq=False)
class JointRun(Asked):
    """What is asked of one joint: a value [rad or m].

    Attributes:
        column: which of the limb's joints.
        joints: how many the limb has.
    """

    column: int
    joints: int


@dataclass(frozen=True, eq=False)
class PosePlan:
    """All that is asked of one figure.

    Attributes:
        points: of nodes.
        joints: of joints.
        body: runs of the body, (6,) values: how far it is moved [m], angles [rad].
    """

    points: tuple[PointRun, ...]
    joints: tuple[JointRun, ...]
    body: tuple[Run, ...]

    def limbs(self) -> list[int]:
        """Return the numbers of the limbs that something is asked of."""
        return sorted({asked.limb for asked in (*self.points, *self.joints)})


def plan_poses(keys: Sequence[PoseKey], figure: Figure, path: str) -> PosePlan:
    """Sort the keys of a figure into runs.

    Args:
        keys: in any order.
        figure: whose they are.
        path: of the keys in the scene, for errors.

    Raises:
        SceneError: if a key names what the figure has not, or asks of it what it cannot do.
    """
    plan = _Planner(PartNames(figure), path)
    # Authors write limb after limb; what comes first in time is taken first.
    for number in sorted(range(len(keys)), key=lambda i: keys[i].at):
        plan.take(number, keys[number])
    if plan.problems:
        raise SceneError(plan.problems)
    return plan.finished()


class _Thing(NamedTuple):
    """What a track is about: a joint, one of the goals of a node, or the body."""

    kind: str
    limb: int
    number: int


@dataclass(slots=True)
class _Open:
    """Keys about one thing so far."""

    keys: list[tuple[float, Sequence[float], Ease]]
    first: PoseKey
    released: PoseKey | None = None

    def run(self) -> Run:
        start = self.keys[0][0]
        let_go = (math.inf, math.inf)
        if self.released is not None:
            let_go = (self.released.at, self.released.at + self.released.blend)
        return Run(Track.of(self.keys), (max(start - self.first.blend, 0.0), start), let_go)


@dataclass(slots=True)
class _Planner:
    """Sorts keys."""

    names: PartNames
    path: str
    problems: list[Problem] = field(default_factory=list)
    open: dict[_Thing, _Open] = field(default_factory=dict)
    ended: list[tuple[_Thing, _Open]] = field(default_factory=list)

    def take(self, number: int, key: PoseKey) -> None:
        """Put one key where it belongs."""
        path = f"{self.path}[{number}]"
        if key.limb is not None or key.node is not None:
            self._take_point(key, path)
        for name, value in (key.joints or {}).items():
            self._take_joint(key, name, value, f"{path}.joints.{name}")
        if key.body is not None:
            angles = [math.radians(angle) for angle in key.body.turn_deg]
            self._add(_Thing(BODY, -1, 0), key, (*key.body.move, *angles), path)
        if key.release is not None:
            self._release(key, key.release, f"{path}.release")

    def _take_point(self, key: PoseKey, path: str) -> None:
        word = "limb" if key.limb is not None else "node"
        name = key.limb if key.limb is not None else key.node
        assert name is not None
        found = self._point(word, name, f"{path}.{word}")
        if found is None:
            return
        limb, link = found
        for goal in GOALS:
            value = getattr(key, goal)
            if value is not None:
                if goal == "turn_deg":
                    value = [math.radians(angle) for angle in value]
                self._add(_Thing(goal, limb, link), key, value, path)

    def _point(self, word: str, name: str, path: str) -> tuple[int, int] | None:
        names = self.names
        if word == "limb" and name in names.limbs:
            limb = names.limbs[name]
            return limb, len(names.figure.skeleton.limbs[limb].links) - 1
        if word == "node" and name in names.nodes:
            return names.nodes[name]
        if word == "node" and name in names.body:
            message = f"'{name}' is part of the body, which the word body moves"
        else:
            known = names.limbs if word == "limb" else names.nodes
            message = f"'{names.figure.name}' has no {word} '{name}', {hint(name, known)}"
        self.problems.append(Problem(path, message))
        return None

    def _take_joint(self, key: PoseKey, name: str, value: float, path: str) -> None:
        joints, skeleton = self.names.joints, self.names.figure.skeleton
        if name not in joints:
            message = f"'{self.names.figure.name}' has no joint '{name}', {hint(name, joints)}"
            self.problems.append(Problem(path, message))
            return
        limb, column = joints[name]
        joint = skeleton.limbs[limb].joints[column]
        slides = bool(skeleton.prismatic[joint])
        low, high = float(skeleton.lower[joint]), float(skeleton.upper[joint])
        if not slides:
            low, high = math.degrees(low), math.degrees(high)
        if not low - 1e-9 <= value <= high + 1e-9:
            unit = "m" if slides else "degrees"
            message = f"goes from {low:.3g} to {high:.3g} {unit}, not to {value:g}"
            self.problems.append(Problem(path, message))
            return
        self._add(
            _Thing("joint", limb, column), key, (value if slides else math.radians(value),), path
        )

    def _add(self, thing: _Thing, key: PoseKey, value: Sequence[float], path: str) -> None:
        known = self.open.get(thing)
        if known is None:
            self.open[thing] = _Open([(key.at, value, key.ease)], key)
            return
        for word in ("frame", "priority", "weight"):
            before = getattr(known.first, word)
            if getattr(key, word) != before and thing.kind != BODY:
                message = f"is {before} for the keys before; release it first to change that"
                self.problems.append(Problem(f"{path}.{word}", message))
        if key.at == known.keys[-1][0]:
            self.problems.append(Problem(path, f"this is asked for twice at {key.at:g}"))
        known.keys.append((key.at, value, key.ease))

    def _release(self, key: PoseKey, name: str, path: str) -> None:
        things = [thing for thing in self.open if self._is_about(thing, name)]
        if not things:
            message = f"nothing is asked of '{name}' at {key.at:g} that it could be released from"
            self.problems.append(Problem(path, message))
        for thing in things:
            run = self.open.pop(thing)
            run.released = key
            self.ended.append((thing, run))

    def _is_about(self, thing: _Thing, name: str) -> bool:
        names = self.names
        if name == BODY or thing.kind == BODY:
            return thing.kind == name
        if name in names.limbs:
            return thing.limb == names.limbs[name]
        known = names.joints if thing.kind == "joint" else names.nodes
        return known.get(name) == (thing.limb, thing.number)

    def finished(self) -> PosePlan:
        """Return what the keys come to."""
        runs = [*self.ended, *self.open.items()]
        return PosePlan(
            points=tuple(self._points(runs)),
            joints=tuple(self._joints(runs)),
            body=tuple(r.run() for (kind, _, _), r in runs if kind == BODY),
        )

    def _joints(self, runs: Iterable[tuple[_Thing, _Open]]) -> Iterator[JointRun]:
        for (kind, limb, column), run in runs:
            if kind == "joint":
                yield JointRun(
                    limb=limb,
                    column=column,
                    joints=len(self.names.figure.skeleton.limbs[limb].joints),
                    run=run.run(),
                    priority=run.first.priority or JOINTS_FIRST,
                    weight=run.first.weight,
                )

    def _points(self, runs: Iterable[tuple[_Thing, _Open]]) -> Iterator[PointRun]:
        for (goal, limb, link), run in runs:
            if goal not in GOALS:
                continue
            first = run.first
            yield PointRun(
                limb=limb,
                point=self.names.point(limb, link),
                goal=goal,
                run=run.run(),
                frame=first.frame,
                priority=first.priority or POINTS_FIRST,
                weight=first.weight,
            )
