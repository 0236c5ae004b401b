"""Choice of a gait: from what an author says of it to the phases of a figure's legs."""

from __future__ import annotations

from collections.abc import Sequence

from pipeline.errors import Problem, SceneError
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.locomotion.gaits import Gait, written
from pipeline.simulation.locomotion.gaits_legs import Rows
from pipeline.simulation.locomotion.gaits_named import NEEDS, gaits_of
from pipeline.spec.cast import Creature
from pipeline.spec.walk import GaitWords, Walk


def chosen(
    number: int, member: Creature, words: Walk, figure: Figure, forward: Sequence[float]
) -> Gait:
    """Return the gait that a creature was asked to have.

    Args:
        number: place in the cast.
        member: the creature.
        words: how it walks.
        figure: its figure.
        forward: how far to the front the hips of its legs are [m].

    Raises:
        SceneError: if its legs have no such gait.
    """
    path = f"cast[{number}].walk.gait"
    if isinstance(words.gait, GaitWords):
        gait = _written(path, member, words.gait, figure)
    else:
        rows = Rows.of([leg.side for leg in figure.skeleton.legs], forward)
        gaits = gaits_of(rows)
        if words.gait not in gaits:
            message = (
                f"a gait '{words.gait}' needs {NEEDS[words.gait]}, '{member.figure}' has {rows}; "
                f"take {listed(list(gaits))}"
            )
            raise SceneError([Problem(path, message)])
        gait = gaits[words.gait]
    return gait if words.duty is None else gait.with_duty(words.duty)


def _written(path: str, member: Creature, words: GaitWords, figure: Figure) -> Gait:
    names = [leg.name for leg in figure.skeleton.legs]
    wrong = sorted(set(words.up) ^ set(names))
    if wrong:
        message = (
            f"has to name every leg of '{member.figure}' and no other: "
            f"its legs are {', '.join(names)}; at fault: {', '.join(wrong)}"
        )
        raise SceneError([Problem(f"{path}.up", message)])
    return written(words, names)


def listed(names: Sequence[str]) -> str:
    """Return what there is to choose from, as words."""
    return " or ".join([", ".join(names[:-1]), names[-1]] if names[1:] else names)
