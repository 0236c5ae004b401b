"""Jerk trials: one dance by both controllers, at the durations of 1998 and at equal ones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.errors import UsageError
from pipeline.simulation.dance_trials import (
    PAPER_JERK,
    PAPER_SUBTASK_COUNT,
    DanceRecord,
    MeasuredMove,
    RetimedPath,
    first_of_each_subtask,
    measure_moves,
    minimum_jerk_timing,
    rank_correlation,
    record_dance,
)
from pipeline.spec import Dance, Dancer, Scene
from pipeline.spec.dance import Controller

EQUAL_DURATION = 1.0
"""Duration of every subtask in the trial of equal ones [s]."""

RESTING_DISTANCE = 0.05
"""Distance between the ends of a movement below which it has no dimensionless jerk [m]."""

NO_END = 1e6
"""Later than the start of any movement [s]."""

CONTROLLERS: dict[str, Controller] = {"torque": "joint-torque", "force": "force-field"}
"""Controller of each column."""


@dataclass(frozen=True, eq=False)
class Column:
    """One dance by one controller.

    Attributes:
        name: "torque" or "force".
        danced: motion of the dancer.
        movements: by the number of the subtask.
        smoothest: the timing of least jerk on each path, by the number of the subtask.
    """

    name: str
    danced: DanceRecord
    movements: dict[int, MeasuredMove]
    smoothest: dict[int, RetimedPath]


@dataclass(frozen=True, eq=False)
class Trial:
    """One choice of durations.

    Attributes:
        name: of the choice.
        columns: "torque" and "force".
    """

    name: str
    columns: dict[str, Column]


@dataclass(frozen=True, slots=True)
class Agreement:
    """Rank correlation of one of our columns with one of figure 3.

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
    """Return trials of the first dancer of a scene at several durations.

    Raises:
        UsageError: the scene has no dancer.
        SceneError: the dance cannot be danced so.
    """
    i, member, dance = dancer_of(scene)
    path, rate = f"cast[{i}]", float(scene.rate * scene.steps)
    choices: dict[str, str | float | None] = {}
    if {"torque", "force"} <= dance.durations.keys():
        choices["figure 3's durations"] = None
    if "human" in dance.durations:
        choices["human durations"] = "human"
    choices[f"equal durations, {EQUAL_DURATION:g} s"] = EQUAL_DURATION
    return [
        _trial(name, member, dance, path, rate, durations) for name, durations in choices.items()
    ]


def is_figure_three(dance: Dance) -> bool:
    """Return whether a dance has the subtasks of figure 3."""
    return len(dance.subtasks) == PAPER_SUBTASK_COUNT and {"human", "torque", "force"} <= set(
        dance.durations
    )


def agreements(trial: Trial) -> list[Agreement]:
    """Return the rank correlations of our columns with those of figure 3."""
    found = list[Agreement]()
    for ours, column in trial.columns.items():
        for theirs, printed in PAPER_JERK.items():
            both = [
                k
                for k in sorted(column.movements)
                if printed[k] is not None
                and not (ours == "force" and PAPER_JERK["force"][k] is None)
            ]
            own = np.array([column.movements[k].jerk.integral for k in both])
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
    for column, controller in CONTROLLERS.items():
        changed = {
            "controller": controller,
            "durations": column if durations is None else durations,
            "tempo_bpm": None,
            "bars": 1,
            "start": 0.5,
            "sway_deg": 0.0,
            "combine": "sum",
        }
        plain = tuple(task.model_copy(update={"controller": None}) for task in dance.subtasks)
        alone = dance.model_copy(update={"subtasks": plain})
        danced = record_dance(member.model_copy(update=changed), alone, path, rate, NO_END)
        movements = first_of_each_subtask(measure_moves(danced))
        if column == "force":
            # A force field cannot turn a hand, which then stands still.
            movements = {k: m for k, m in movements.items() if _suits_fields(dance, k)}
        smoothest = {k: minimum_jerk_timing(danced, movement) for k, movement in movements.items()}
        columns[column] = Column(column, danced, movements, smoothest)
    return Trial(name, columns)


def _suits_fields(dance: Dance, k: int) -> bool:
    subtask = dance.subtasks[k]
    moving = ("shoulder_", "elbow_")
    return not subtask.is_of_joints or any(joint.startswith(moving) for joint in subtask.joints)
