"""Named gaits: those of animals with one, two, four or six legs, and who has which.

A gait of four legs is told by Hildebrand's numbers: for the symmetrical ones the part
of the cycle that a foot is down, and by which part of the cycle a forefoot comes down
after the hind foot of its side; for the asymmetrical ones when each foot comes down.
He gives ranges; these are values in their middle, as of horses, and of cheetahs for the
rotary gallop.

Source: Hildebrand 1965, 1977, 1989.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.errors import Problem, SceneError
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.locomotion.gaits.gait import Gait, written
from pipeline.spec.suggestions import hint
from pipeline.spec.walk import GaitPhases, Manner


@dataclass(frozen=True, slots=True)
class LegRows:
    """The legs of one creature.

    Attributes:
        left, right: numbers of the legs, front to back.
    """

    left: tuple[int, ...]
    right: tuple[int, ...]

    @staticmethod
    def of(sides: Sequence[str], forward: Sequence[float]) -> LegRows:
        """Sort legs into rows.

        A leg in the middle joins the shorter row, so that it has a neighbour to take
        turns with; the left one if they are even.

        Args:
            sides: "l", "r" or "m" of each leg.
            forward: how far to the front each one stands [m].
        """
        rows: dict[str, list[int]] = {side: [] for side in "lrm"}
        for leg in sorted(range(len(sides)), key=lambda leg: -forward[leg]):
            rows[sides[leg]].append(leg)
        left, right = rows["l"], rows["r"]
        for leg in rows["m"]:
            shorter = left if len(left) <= len(right) else right
            shorter.append(leg)
        return LegRows(
            *(tuple(sorted(row, key=lambda leg: -forward[leg])) for row in (left, right))
        )

    @property
    def count(self) -> int:
        """How many legs there are."""
        return len(self.left) + len(self.right)

    def __iter__(self) -> Iterator[tuple[int, ...]]:
        """Give the left row, then the right one."""
        return iter((self.left, self.right))

    def __str__(self) -> str:
        """Return how many legs stand where."""
        number = f"{self.count} leg" + ("s" if self.count != 1 else "")
        return f"{number} ({len(self.left)} left, {len(self.right)} right)"


FIRM = 0.84
"""Part of its turn for which a foot is in the air: feet that come down are firm before
the next ones leave."""

TROT_SWING = FIRM * 0.5

LEGS_A_WAVE = 5
"""About how many legs of a row share one wave. Long rows, a centipede's, carry several
waves at once, otherwise the feet would have to fly (Manton 1952)."""


def trot(rows: LegRows) -> Gait:
    """Return the gait in which neighbours along a row and across the body take turns.

    A walk for two legs, a trot for four, a tripod gait for six.
    """
    up = np.zeros(rows.count)
    for first, row in enumerate(rows):
        for rank, leg in enumerate(row):
            up[leg] = 0.5 * ((rank + first) % 2)
    return Gait(up, np.mod(up + TROT_SWING, 1.0))


def wave(rows: LegRows) -> Gait:
    """Return the gait in which each row lifts its feet in turn, from back to front.

    Both rows move together: a bound for four legs, a hop for two.
    """
    return _waves(rows, 0.0)


def ripple(rows: LegRows) -> Gait:
    """Return the wave whose right row goes half a cycle after the left, an insect's.

    Source: Wilson 1966.
    """
    return _waves(rows, 0.5)


def _waves(rows: LegRows, lag: float) -> Gait:
    up, swing = np.zeros(rows.count), np.zeros(rows.count)
    for first, row in enumerate(rows):
        n = len(row)
        turn = max(1, round(n / LEGS_A_WAVE)) / max(n, 1)
        for rank, leg in enumerate(row):
            up[leg] = (n - 1 - rank) * turn + first * lag
            swing[leg] = FIRM * min(turn, 0.5)
    return Gait(np.mod(up, 1.0), np.mod(up + swing, 1.0))


SYMMETRICAL = {"walk": (0.64, 0.22), "amble": (0.42, 0.22), "pace": (0.42, 0.0)}
"""Duty, and by how much a forefoot follows the hind foot of its side. The left and the
right of a pair come down half a cycle apart."""

ASYMMETRICAL = {
    "canter": (0.40, (0.0, 0.28, 0.28, 0.54)),
    "transverse gallop": (0.26, (0.0, 0.14, 0.34, 0.51)),
    "rotary gallop": (0.22, (0.0, 0.11, 0.54, 0.43)),
    "bound": (0.28, (0.0, 0.0, 0.42, 0.42)),
}
"""Duty, and when left hind, right hind, left fore and right fore come down. The right
hind foot leads. The leading forefoot is on the same side in a transverse gallop and in
a canter, on the other in a rotary gallop."""

BIPEDAL = {
    "walk": (0.62, 0.5),
    "run": (0.36, 0.5),
    "hop": (0.40, 0.0),
    "skip": (0.42, 0.28),
}
"""Duty, and by how much the right foot follows the left (Alexander 1989; Minetti 1998 for
the skip, whose one foot always leads: a gallop on two legs)."""


def _symmetrical(name: str, rows: LegRows) -> Gait:
    duty, fore = SYMMETRICAL[name]
    down = np.zeros(4)
    for first, row in enumerate(rows):
        down[list(row)] = 0.5 * first + np.array([fore, 0.0])
    return Gait.of(down, duty)


def _asymmetrical(name: str, rows: LegRows) -> Gait:
    duty, (left_hind, right_hind, left_fore, right_fore) = ASYMMETRICAL[name]
    down = np.zeros(4)
    down[list(rows.left)] = left_fore, left_hind
    down[list(rows.right)] = right_fore, right_hind
    return Gait.of(down, duty)


def _bipedal(name: str, rows: LegRows) -> Gait:
    duty, lag = BIPEDAL[name]
    down = np.zeros(2)
    down[list(rows.right)] = lag
    return Gait.of(down, duty)


def _hop_on_one(_name: str, _rows: LegRows) -> Gait:
    return Gait.of(np.zeros(1), BIPEDAL["hop"][0])


def _special(rows: LegRows) -> Mapping[str, Callable[[str, LegRows], Gait]]:
    """Return the gaits that only such legs have."""
    pairs = len(rows.left) == len(rows.right)
    if rows.count == 1:
        return {"hop": _hop_on_one}
    if rows.count == 2 and pairs:
        return dict.fromkeys(BIPEDAL, _bipedal)
    if rows.count == 4 and pairs:
        return dict.fromkeys(SYMMETRICAL, _symmetrical) | dict.fromkeys(ASYMMETRICAL, _asymmetrical)
    if rows.count == 6:
        return {"tripod": lambda _, rows: trot(rows), "ripple": lambda _, rows: ripple(rows)}
    return {"ripple": lambda _, rows: ripple(rows)} if rows.count > 4 else {}


def available_gaits(rows: LegRows) -> dict[str, Gait]:
    """Return the gaits that exist for such legs, by name, the general ones first."""
    special = _special(rows)
    return {"trot": trot(rows), "wave": wave(rows)} | {
        name: make(name, rows) for name, make in special.items()
    }


LEG_REQUIREMENTS = {
    "tripod": "6 legs",
    "ripple": "more than 4 legs",
    "walk": "one pair of legs or two",
    "run": "one pair of legs",
    "skip": "one pair of legs",
    "hop": "one leg or one pair",
    **dict.fromkeys(("amble", "pace", *ASYMMETRICAL), "two pairs of legs"),
}
"""What legs a gait is for, in words."""


def walking_legs(where: str, words: Manner, figure: Figure) -> list[int]:
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


def choose_gait(
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
    if isinstance(words.gait, GaitPhases):
        gait = _written(f"{where}.gait", words.gait, figure.name, [leg.name for leg in of])
    else:
        rows = LegRows.of([leg.side for leg in of], forward)
        gaits = available_gaits(rows)
        if words.gait not in gaits:
            verb = "has" if words.legs is None else "walks on"
            message = (
                f"a gait '{words.gait}' needs {LEG_REQUIREMENTS[words.gait]}, "
                f"'{figure.name}' {verb} {rows}; "
                f"take {join_choices(list(gaits))}"
            )
            raise SceneError([Problem(f"{where}.gait", message)])
        gait = gaits[words.gait]
    return gait if words.duty is None else gait.with_duty(words.duty)


def _written(path: str, words: GaitPhases, figure: str, names: Sequence[str]) -> Gait:
    wrong = sorted(set(words.up) ^ set(names))
    if wrong:
        message = (
            f"has to name every leg that '{figure}' walks on and no other: "
            f"these are {', '.join(names)}; at fault: {', '.join(wrong)}"
        )
        raise SceneError([Problem(f"{path}.up", message)])
    return written(words, names)


def join_choices(names: Sequence[str]) -> str:
    """Return what there is to choose from, as words."""
    return " or ".join([", ".join(names[:-1]), names[-1]] if names[1:] else names)
