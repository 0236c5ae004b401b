"""Named gaits: the gaits that legs can have, and the choice of one from its config.

Gaits of four legs follow Hildebrand's numbers: a symmetrical gait has a duty factor and a lag of
the forefoot behind the hind foot of its side; an asymmetrical one lists all foot-down phases. He
gives ranges; these are values in their middle, as of horses, and of cheetahs for the rotary gallop.

The automatic gaits (trot, wave, ripple) fit any number of legs and any imbalance between left and
right: the rows are timed independently, each by the legs it has, which makes up for a missing limb.

Source: Sims 1987, 10.3; Hildebrand 1965, 1977, 1989.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.errors import Problem, SceneError
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.locomotion.gaits.gait import Gait, gait_from_config
from pipeline.spec.suggestions import hint
from pipeline.spec.walk import AUTO, LEG_REQUIREMENTS, GaitPhases, Manner

# Fraction of its turn for which a foot is in the air: feet that come down are firm before the next
# ones leave.
SWING_OF_TURN = 0.84
TROT_SWING = SWING_OF_TURN * 0.5

# Legs of a row that share one wave. Long rows, a centipede's, carry several waves at once;
# otherwise the feet would have to fly (Manton 1952).
LEGS_PER_WAVE = 5

# Duty factor, and lag of a forefoot behind the hind foot of its side. Left and right feet of a pair
# come down half a cycle apart.
SYMMETRICAL = {"walk": (0.64, 0.22), "amble": (0.42, 0.22), "pace": (0.42, 0.0)}

# Duty factor, and foot-down phases of left hind, right hind, left fore and right fore. The right
# hind foot leads. The leading forefoot is on the same side in a transverse gallop and in a canter,
# on the other in a rotary gallop.
ASYMMETRICAL = {
    "canter": (0.40, (0.0, 0.28, 0.28, 0.54)),
    "transverse gallop": (0.26, (0.0, 0.14, 0.34, 0.51)),
    "rotary gallop": (0.22, (0.0, 0.11, 0.54, 0.43)),
    "bound": (0.28, (0.0, 0.0, 0.42, 0.42)),
}

# Duty factor, and lag of the right foot behind the left (Alexander 1989; Minetti 1998 for the skip,
# whose one foot always leads: a gallop on two legs).
BIPEDAL = {
    "walk": (0.62, 0.5),
    "run": (0.36, 0.5),
    "hop": (0.40, 0.0),
    "skip": (0.42, 0.28),
}


@dataclass(frozen=True, slots=True)
class LegRows:
    """The legs of one creature as a left and a right row.

    Attributes:
        left, right: numbers of the legs, front to back.
    """

    left: tuple[int, ...]
    right: tuple[int, ...]

    @staticmethod
    def of(sides: Sequence[str], forward: Sequence[float]) -> LegRows:
        """Sort legs into rows.

        A leg in the middle joins the shorter row, so that it has a neighbour to take turns with;
        the left one if both are even.

        Args:
            sides: "l", "r" or "m" of each leg.
            forward: position of each leg along the body [m].
        """
        rows: dict[str, list[int]] = {side: [] for side in "lrm"}
        for leg in sorted(range(len(sides)), key=lambda leg: -forward[leg]):
            rows[sides[leg]].append(leg)
        left, right = rows["l"], rows["r"]
        for leg in rows["m"]:
            shorter = left if len(left) <= len(right) else right
            shorter.append(leg)
        ordered = (tuple(sorted(row, key=lambda leg: -forward[leg])) for row in (left, right))
        return LegRows(*ordered)

    @property
    def count(self) -> int:
        """Number of legs."""
        return len(self.left) + len(self.right)

    def __iter__(self) -> Iterator[tuple[int, ...]]:
        """Yield the left row, then the right one."""
        return iter((self.left, self.right))

    def __str__(self) -> str:
        """Return the numbers of legs as text."""
        number = f"{self.count} leg" + ("s" if self.count != 1 else "")
        return f"{number} ({len(self.left)} left, {len(self.right)} right)"


# --- automatic gaits ----------------------------------------------------------------


def trot(rows: LegRows) -> Gait:
    """Return the gait in which neighbours along a row and across the body take turns.

    A walk for two legs, a trot for four, a tripod gait for six.
    """
    up = np.zeros(rows.count)
    for first, row in enumerate(rows):
        for rank, leg in enumerate(row):
            up[leg] = 0.5 * ((rank + first) % 2)
    return Gait(up, np.mod(up + TROT_SWING, 1.0))


def wave(rows: LegRows, lag: float = 0.0) -> Gait:
    """Return the gait in which each row lifts its feet in turn, from back to front.

    Without a lag of the right row both move together: a bound for four legs, a hop for two.
    """
    up, swing = np.zeros(rows.count), np.zeros(rows.count)
    for first, row in enumerate(rows):
        n = len(row)
        turn = max(1, round(n / LEGS_PER_WAVE)) / max(n, 1)
        for rank, leg in enumerate(row):
            up[leg] = (n - 1 - rank) * turn + first * lag
            swing[leg] = SWING_OF_TURN * min(turn, 0.5)
    return Gait(np.mod(up, 1.0), np.mod(up + swing, 1.0))


def ripple(rows: LegRows) -> Gait:
    """Return the wave whose right row lags half a cycle, an insect's (Wilson 1966)."""
    return wave(rows, 0.5)


# --- gaits of one, two and four legs ------------------------------------------------


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


def _special(rows: LegRows) -> Mapping[str, Callable[[str, LegRows], Gait]]:
    """Return the gaits that only such legs have."""
    is_paired = len(rows.left) == len(rows.right)
    if rows.count == 1:
        return {"hop": lambda name, _: Gait.of(np.zeros(1), BIPEDAL[name][0])}
    if rows.count == 2 and is_paired:
        return dict.fromkeys(BIPEDAL, _bipedal)
    if rows.count == 4 and is_paired:
        return dict.fromkeys(SYMMETRICAL, _symmetrical) | dict.fromkeys(ASYMMETRICAL, _asymmetrical)
    if rows.count == 6:
        return {"tripod": lambda _, rows: trot(rows), "ripple": lambda _, rows: ripple(rows)}
    return {"ripple": lambda _, rows: ripple(rows)} if rows.count > 4 else {}


def available_gaits(rows: LegRows) -> dict[str, Gait]:
    """Return all gaits of such legs by name, the general ones first."""
    special = {name: make(name, rows) for name, make in _special(rows).items()}
    return {"trot": trot(rows), "wave": wave(rows)} | special


# --- choice from a config -----------------------------------------------------------


def walking_legs(where: str, walk: Manner, figure: Figure) -> list[int]:
    """Return the numbers of the legs that a creature walks on.

    Args:
        where: path of `walk` in the scene.
        walk: its config.
        figure: its figure.

    Raises:
        SceneError: if it has no such legs.
    """
    names = [leg.name for leg in figure.skeleton.legs]
    if walk.legs is None:
        return list(range(len(names)))
    problems = [
        Problem(f"{where}.legs[{i}]", f"'{figure.name}' has no leg '{leg}', {hint(leg, names)}")
        for i, leg in enumerate(walk.legs)
        if leg not in names
    ]
    if problems:
        raise SceneError(problems)
    return [i for i, name in enumerate(names) if name in walk.legs]


def choose_gait(
    where: str,
    walk: Manner,
    figure: Figure,
    legs: Sequence[int],
    forward: Sequence[float],
    automatic: Callable[[Container[str]], str],
) -> tuple[str, Gait]:
    """Return name and phases of the gait that a creature is configured to have.

    Args:
        where: path of `walk` in the scene.
        walk: its config.
        figure: its figure.
        legs: numbers of the legs that it walks on.
        forward: positions of their hips along the body [m].
        automatic: returns the name of an automatic gait, of those that its legs can have.

    Returns:
        The name, empty if the phases are written out; and the gait.

    Raises:
        SceneError: if its legs have no such gait.
    """
    limbs = [figure.skeleton.legs[leg] for leg in legs]
    if isinstance(walk.gait, GaitPhases):
        name = ""
        gait = _gait_from_phases(where, walk.gait, figure.name, [limb.name for limb in limbs])
    else:
        rows = LegRows.of([limb.side for limb in limbs], forward)
        gaits = available_gaits(rows)
        name = automatic(gaits) if walk.gait == AUTO else walk.gait
        if name not in gaits:
            verb = "has" if walk.legs is None else "walks on"
            message = (
                f"a gait '{name}' needs {LEG_REQUIREMENTS[name]}, "
                f"'{figure.name}' {verb} {rows}; take {join_choices([AUTO, *gaits])}"
            )
            raise SceneError([Problem(f"{where}.gait", message)])
        gait = gaits[name]
    return name, gait if walk.duty is None else gait.with_duty(walk.duty)


def _gait_from_phases(where: str, config: GaitPhases, figure: str, names: Sequence[str]) -> Gait:
    wrong = sorted(set(config.up) ^ set(names))
    if wrong:
        message = (
            f"must name every leg that '{figure}' walks on and no other: "
            f"these are {', '.join(names)}; at fault: {', '.join(wrong)}"
        )
        raise SceneError([Problem(f"{where}.gait.up", message)])
    return gait_from_config(config, names)


def join_choices(names: Sequence[str]) -> str:
    """Return the choices as text: "a, b or c"."""
    return " or ".join([", ".join(names[:-1]), names[-1]] if names[1:] else names)
