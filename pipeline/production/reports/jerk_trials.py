"""Jerk trials: one dance by both controllers, at durations of 1998 and at equal ones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.errors import UsageError
from pipeline.simulation.dancers.figure_three import COLUMNS, SUBTASKS
from pipeline.simulation.dancers.jerk import rank_correlation
from pipeline.simulation.dancers.measuring import (
    Danced,
    Measured,
    dance_through,
    first_of_each,
    measure,
    same_way,
)
from pipeline.simulation.dancers.same_way import Timed
from pipeline.spec import Dance, Dancer, Scene
from pipeline.spec.dance import Controller

EQUAL = 1.0
"""Duration of every subtask in the trial of equal ones [s]."""

BY: dict[str, Controller] = {"torque": "joint-torque", "force": "force-field"}
"""Our columns."""


@dataclass(frozen=True, eq=False)
class Column:
    """One dance by one controller.

    Attributes:
        by: "torque" or "force".
        danced: what happened.
        found: by the number of the subtask.
        best: the same ways at the speeds of least jerk, by the number of the subtask.
    """

    by: str
    danced: Danced
    found: dict[int, Measured]
    best: dict[int, Timed]


@dataclass(frozen=True, eq=False)
class Trial:
    """One choice of durations.

    Attributes:
        name: what it is told under.
        columns: "torque" and "force".
    """

    name: str
    columns: dict[str, Column]


@dataclass(frozen=True, slots=True)
class Agreement:
    """How far one of our columns agrees in its order with one of figure 3.

    Attributes:
        ours: "torque" or "force".
        theirs: "human", "torque" or "force".
        rank: correlation of ranks.
        subtasks: numbers of those that both have.
        own: ranks of ours among them, from 1.
        other: ranks of theirs.
    """

    ours: str
    theirs: str
    rank: float
    subtasks: tuple[int, ...]
    own: tuple[int, ...]
    other: tuple[int, ...]


def dancer_of(scene: Scene) -> tuple[int, Dancer, Dance]:
    """Return the first dancer of a scene.

    Raises:
        UsageError: nobody dances in it.
    """
    for i, member in scene.dancers:
        return i, member, scene.dances[member.dance]
    raise UsageError("nobody dances in this scene; give a dancer: dancer: torso")


def trials_of(scene: Scene) -> list[Trial]:
    """Let the first dancer of a scene dance by both controllers, at several durations.

    Raises:
        UsageError: nobody dances.
        SceneError: it cannot dance so.
    """
    i, member, dance = dancer_of(scene)
    path, rate = f"cast[{i}]", float(scene.rate * scene.steps)
    trials = list[Trial]()
    if {"torque", "force"} <= dance.durations.keys():
        trials.append(_trial("figure 3's durations", member, dance, path, rate, None))
    if "human" in dance.durations:
        trials.append(_trial("human durations", member, dance, path, rate, "human"))
    trials.append(_trial(f"equal durations, {EQUAL:g} s", member, dance, path, rate, EQUAL))
    return trials


def is_figure_three(dance: Dance) -> bool:
    """Tell whether a dance has the subtasks of figure 3."""
    return len(dance.subtasks) == SUBTASKS and {"human", "torque", "force"} <= set(dance.durations)


def agreements(trial: Trial) -> list[Agreement]:
    """Compare the order of our columns with that of figure 3's."""
    found = list[Agreement]()
    for ours, column in trial.columns.items():
        for theirs, printed in COLUMNS.items():
            both = [
                k
                for k in sorted(column.found)
                if printed[k] is not None and not (ours == "force" and COLUMNS["force"][k] is None)
            ]
            own = np.array([column.found[k].jerk.integral for k in both])
            other = np.array([float(printed[k] or 0) for k in both])
            rank = rank_correlation(own, other)
            ranks = [tuple((np.argsort(np.argsort(v)) + 1).tolist()) for v in (own, other)]
            found.append(Agreement(ours, theirs, rank, tuple(both), *ranks))
    return found


def _trial(
    name: str,
    member: Dancer,
    dance: Dance,
    path: str,
    rate: float,
    durations: str | float | None,
) -> Trial:
    columns = {}
    for by, controller in BY.items():
        changed = {
            "controller": controller,
            "durations": by if durations is None else durations,
            "tempo_bpm": None,
            "bars": 1,
            "start": 0.5,
            "sway_deg": 0.0,
            "combine": "sum",
        }
        plain = tuple(one.model_copy(update={"controller": None}) for one in dance.subtasks)
        alone = dance.model_copy(update={"subtasks": plain})
        danced = dance_through(member.model_copy(update=changed), alone, path, rate, 1e6)
        found = first_of_each(measure(danced))
        if by == "force":
            # What turns a hand is not for a field; it stands still then.
            found = {k: m for k, m in found.items() if _is_for_fields(dance, k)}
        best = {k: same_way(danced, one) for k, one in found.items()}
        columns[by] = Column(by, danced, found, best)
    return Trial(name, columns)


def _is_for_fields(dance: Dance, k: int) -> bool:
    one = dance.subtasks[k]
    moving = ("shoulder_", "elbow_")
    return not one.is_of_joints or any(joint.startswith(moving) for joint in one.joints)
