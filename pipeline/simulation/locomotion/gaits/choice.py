"""Choice of a gait: from what an author says of it to the phases of a figure's legs."""

from __future__ import annotations

from collections.abc import Sequence

from pipeline.errors import Problem, SceneError
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.locomotion.gaits.gait import Gait, written
from pipeline.simulation.locomotion.gaits.named import NEEDS, gaits_of
from pipeline.simulation.locomotion.gaits.rows import Rows
from pipeline.spec.suggestions import hint
from pipeline.spec.walk import GaitWords, Manner


def carrying(where: str, words: Manner, figure: Figure) -> list[int]:
    """Return the legs that a creature was asked to walk on.

    Args:
        where: path of the words in the scene.
        words: how it walks.
        figure: its figure.

    Raises:
        SceneError: if it has no such legs.
    """
    names = [leg.name for leg in figure.skeleton.legs]
    if words.legs is None:
        return list(range(len(names)))
    problems = [
        Problem(f"{where}.legs[{i}]", f"'{figure.name}' has no leg '{leg}', {hint(leg, names)}")
        for i, leg in enumerate(words.legs)
        if leg not in names
    ]
    if problems:
        raise SceneError(problems)
    return [i for i, name in enumerate(names) if name in words.legs]


def chosen(
    where: str, words: Manner, figure: Figure, legs: Sequence[int], forward: Sequence[float]
) -> Gait:
    """Return the gait that a creature was asked to have.

    Args:
        where: path of the words in the scene.
        words: how it walks.
        figure: its figure.
        legs: those that it walks on.
        forward: how far to the front their hips are [m].

    Raises:
        SceneError: if its legs have no such gait.
    """
    of = [figure.skeleton.legs[leg] for leg in legs]
    if isinstance(words.gait, GaitWords):
        gait = _written(f"{where}.gait", words.gait, figure.name, [leg.name for leg in of])
    else:
        rows = Rows.of([leg.side for leg in of], forward)
        gaits = gaits_of(rows)
        if words.gait not in gaits:
            has = "has" if words.legs is None else "walks on"
            message = (
                f"a gait '{words.gait}' needs {NEEDS[words.gait]}, '{figure.name}' {has} {rows}; "
                f"take {listed(list(gaits))}"
            )
            raise SceneError([Problem(f"{where}.gait", message)])
        gait = gaits[words.gait]
    return gait if words.duty is None else gait.with_duty(words.duty)


def _written(path: str, words: GaitWords, figure: str, names: Sequence[str]) -> Gait:
    wrong = sorted(set(words.up) ^ set(names))
    if wrong:
        message = (
            f"has to name every leg that '{figure}' walks on and no other: "
            f"these are {', '.join(names)}; at fault: {', '.join(wrong)}"
        )
        raise SceneError([Problem(f"{path}.up", message)])
    return written(words, names)


def listed(names: Sequence[str]) -> str:
    """Return what there is to choose from, as words."""
    return " or ".join([", ".join(names[:-1]), names[-1]] if names[1:] else names)
