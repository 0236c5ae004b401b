"""An author's pose keys for a figure, sorted into runs of tracks, and the names of its parts.

Keys about the same part follow one another on one track, until a release ends it; a later key
starts a new run.

A joint is named after its node, with the unit of its value: elbow_r_deg where the node has one
joint, hip_l_pitch_deg where it has several.

Source: Sims 1987, 3.2.2.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from pipeline.errors import Problem, SceneError
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.ik_goals import LimbPoint
from pipeline.simulation.keyframe_track import BlendedTrack, Track
from pipeline.simulation.spatial import normalized
from pipeline.spec.keyframes import GOALS, Ease, Frame, PoseKey
from pipeline.spec.suggestions import hint

BODY = "body"

POINT_PRIORITY, JOINT_PRIORITY = 1, 2
"""Default priorities."""

INHERITED = ("priority", "weight", "avoid", "dexterity")
"""What a key that leaves it out takes from the keys before."""


class PartNames:
    """Names of limbs, nodes and joints of a figure.

    Attributes:
        figure: the figure.
        limbs: name -> number of the limb.
        nodes: name -> limb, and number of its link that ends there.
        joints: name -> limb, and number of the joint within it.
        body: names of the nodes of the body.
    """

    def __init__(self, figure: Figure) -> None:
        self.figure = figure
        skeleton, names = figure.skeleton, figure.drawing.names
        self.limbs = {limb.name: i for i, limb in enumerate(skeleton.limbs)}
        # The only limb of its side needs no number.
        for name, i in list(self.limbs.items()):
            short = name[:-1]
            if name.endswith("1") and len(short) > 1 and f"{short}2" not in self.limbs:
                self.limbs.setdefault(short, i)
        self.nodes: dict[str, tuple[int, int]] = {}
        self.joints: dict[str, tuple[int, int]] = {}
        for i, appendage in enumerate(figure.anatomy.appendages):
            for k, node in enumerate(appendage.nodes):
                if k:
                    self.nodes.setdefault(names[node], (i, k - 1))
                self._name_joints(i, k, names[node])
        self.body = {names[node] for node in figure.anatomy.body}

    def _name_joints(self, limb: int, k: int, node: str) -> None:
        """Name the joints of a limb at its node number `k`."""
        skeleton = self.figure.skeleton
        start = "base_" if k == 0 else f"joint{k}_"
        here = [
            (column, joint, skeleton.joint_names[joint].rpartition(".")[2])
            for column, joint in enumerate(skeleton.limbs[limb].joints)
        ]
        here = [joint for joint in here if joint[2].startswith(start)]
        for column, joint, name in here:
            unit = "" if skeleton.prismatic[joint] else "_deg"
            long = f"{node}_{name.removeprefix(start)}{unit}"
            self.joints.setdefault(long, (limb, column))
            if len(here) == 1:
                self.joints.setdefault(f"{node}{unit}", (limb, column))

    def point(self, limb: int, link: int) -> LimbPoint:
        """Return the node at the outer end of a limb's link."""
        skeleton = self.figure.skeleton
        own = skeleton.limbs[limb]
        there = skeleton.links[own.links[link]]
        column = own.joints.index(there.joint)
        return LimbPoint(column, there.ends[1], normalized(there.ends[1] - there.ends[0]))


@dataclass(frozen=True, eq=False)
class PoseRun:
    """A demand on a part of one limb.

    Attributes:
        name: of the limb, node or joint, as its author wrote it.
        limb: number of the limb.
        run: values over time.
        priority: 1 comes first.
        weight: among demands of that priority.
        avoid: names of what the limb keeps clear of; None for everything.
        dexterity: how much its redundancy goes towards dexterity.
    """

    name: str
    limb: int
    run: BlendedTrack
    priority: int
    weight: float
    avoid: tuple[str, ...] | None
    dexterity: float


@dataclass(frozen=True, eq=False)
class PointRun(PoseRun):
    """A demand on one node: a place [m], a direction, or angles [rad].

    Attributes:
        point: the node.
        goal: "reach", "aim" or "turn_deg".
        frame: of the values.
    """

    point: LimbPoint
    goal: str
    frame: Frame


@dataclass(frozen=True, eq=False)
class JointRun(PoseRun):
    """A demand on one joint: a value [rad or m].

    Attributes:
        column: number of the joint within the limb.
        joints: number of joints of the limb.
    """

    column: int
    joints: int


@dataclass(frozen=True, eq=False)
class PosePlan:
    """All demands on one figure.

    Attributes:
        points: on nodes.
        joints: on joints.
        body: runs of the body, (6,) values: displacement [m], angles [rad].
    """

    points: tuple[PointRun, ...]
    joints: tuple[JointRun, ...]
    body: tuple[BlendedTrack, ...]

    def limbs(self) -> list[int]:
        """Return the numbers of the limbs with demands."""
        return sorted({asked.limb for asked in (*self.points, *self.joints)})


def plan_poses(
    keys: Sequence[PoseKey], figure: Figure, path: str, known: Collection[str] = ()
) -> PosePlan:
    """Return the pose plan of a figure.

    Args:
        keys: in any order.
        figure: the figure.
        path: of the keys in the scene, for errors.
        known: names of what limbs can avoid.

    Raises:
        SceneError: a key names a part that the figure lacks, or demands the impossible.
    """
    plan = _Planner(PartNames(figure), path)
    # Authors write limb by limb; keys are taken in order of time.
    for number in sorted(range(len(keys)), key=lambda i: keys[i].at):
        plan.take(number, keys[number])
        plan.check_avoided(number, keys[number], known)
    if plan.problems:
        raise SceneError(plan.problems)
    return plan.finished()


class _TrackKey(NamedTuple):
    """The part of a track: a joint, one of the goals of a node, or the body."""

    kind: str
    limb: int
    number: int


@dataclass(slots=True)
class _OpenTrack:
    """The keys of one part so far."""

    name: str
    keys: list[tuple[float, Sequence[float], Ease]]
    first: PoseKey
    released: PoseKey | None = None

    def run(self) -> BlendedTrack:
        start = self.keys[0][0]
        let_go = (math.inf, math.inf)
        if self.released is not None:
            let_go = (self.released.at, self.released.at + self.released.blend)
        return BlendedTrack(
            Track.of(self.keys), (max(start - self.first.blend, 0.0), start), let_go
        )


@dataclass(slots=True)
class _Planner:
    """Sorts keys."""

    names: PartNames
    path: str
    problems: list[Problem] = field(default_factory=list)
    open: dict[_TrackKey, _OpenTrack] = field(default_factory=dict)
    ended: list[tuple[_TrackKey, _OpenTrack]] = field(default_factory=list)

    def take(self, number: int, key: PoseKey) -> None:
        """Add one key to its tracks."""
        path = f"{self.path}[{number}]"
        if key.limb is not None or key.node is not None:
            self._take_point(key, path)
        for name, value in (key.joints or {}).items():
            self._take_joint(key, name, value, f"{path}.joints.{name}")
        if key.body is not None:
            angles = [math.radians(angle) for angle in key.body.turn_deg]
            self._add(_TrackKey(BODY, -1, 0), BODY, key, (*key.body.move, *angles), path)
        if key.release is not None:
            self._release(key, key.release, f"{path}.release")

    def check_avoided(self, number: int, key: PoseKey, known: Collection[str]) -> None:
        """Refuse names that no limb can keep clear of."""
        for i, name in enumerate(key.avoid or ()):
            if name not in known:
                message = (
                    f"'{name}' is no prop that stands or moves by its keys, nor ground, "
                    f"{hint(name, known)}"
                )
                self.problems.append(Problem(f"{self.path}[{number}].avoid[{i}]", message))

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
                self._add(_TrackKey(goal, limb, link), name, key, value, path)

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
        angle = value if slides else math.radians(value)
        self._add(_TrackKey("joint", limb, column), name, key, (angle,), path)

    def _add(
        self, thing: _TrackKey, name: str, key: PoseKey, value: Sequence[float], path: str
    ) -> None:
        known = self.open.get(thing)
        if known is None:
            self.open[thing] = _OpenTrack(name, [(key.at, value, key.ease)], key)
            return
        for word in ("frame", *INHERITED):
            before = getattr(known.first, word)
            if word in INHERITED and word not in key.model_fields_set:
                continue
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

    def _is_about(self, thing: _TrackKey, name: str) -> bool:
        names = self.names
        if name == BODY or thing.kind == BODY:
            return thing.kind == name
        if name in names.limbs:
            return thing.limb == names.limbs[name]
        known = names.joints if thing.kind == "joint" else names.nodes
        return known.get(name) == (thing.limb, thing.number)

    def finished(self) -> PosePlan:
        """Return the plan."""
        runs = [*self.ended, *self.open.items()]
        return PosePlan(
            points=tuple(self._points(runs)),
            joints=tuple(self._joints(runs)),
            body=tuple(r.run() for (kind, _, _), r in runs if kind == BODY),
        )

    def _joints(self, runs: Iterable[tuple[_TrackKey, _OpenTrack]]) -> Iterator[JointRun]:
        for (kind, limb, column), run in runs:
            if kind == "joint":
                yield JointRun(
                    name=run.name,
                    limb=limb,
                    column=column,
                    joints=len(self.names.figure.skeleton.limbs[limb].joints),
                    run=run.run(),
                    priority=run.first.priority or JOINT_PRIORITY,
                    weight=run.first.weight,
                    avoid=run.first.avoid,
                    dexterity=run.first.dexterity,
                )

    def _points(self, runs: Iterable[tuple[_TrackKey, _OpenTrack]]) -> Iterator[PointRun]:
        for (goal, limb, link), run in runs:
            if goal not in GOALS:
                continue
            first = run.first
            yield PointRun(
                name=run.name,
                limb=limb,
                point=self.names.point(limb, link),
                goal=goal,
                run=run.run(),
                frame=first.frame,
                priority=first.priority or POINT_PRIORITY,
                weight=first.weight,
                avoid=first.avoid,
                dexterity=first.dexterity,
            )
