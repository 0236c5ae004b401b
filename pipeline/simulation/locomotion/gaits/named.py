"""Named gaits: those of animals with one, two, four or six legs, and who has which.

A gait of four legs is told by Hildebrand's numbers: for the symmetrical ones the part
of the cycle that a foot is down, and by which part of the cycle a forefoot comes down
after the hind foot of its side; for the asymmetrical ones when each foot comes down.
He gives ranges; these are values in their middle, as of horses, and of cheetahs for the
rotary gallop.

Source: Hildebrand 1965, 1977, 1989.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from pipeline.simulation.locomotion.gaits.automatic import ripple, trot, wave
from pipeline.simulation.locomotion.gaits.gait import Gait
from pipeline.simulation.locomotion.gaits.rows import Rows

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


def _symmetrical(name: str, rows: Rows) -> Gait:
    duty, fore = SYMMETRICAL[name]
    down = np.zeros(4)
    for first, row in enumerate(rows):
        down[list(row)] = 0.5 * first + np.array([fore, 0.0])
    return Gait.of(down, duty)


def _asymmetrical(name: str, rows: Rows) -> Gait:
    duty, (left_hind, right_hind, left_fore, right_fore) = ASYMMETRICAL[name]
    down = np.zeros(4)
    down[list(rows.left)] = left_fore, left_hind
    down[list(rows.right)] = right_fore, right_hind
    return Gait.of(down, duty)


def _bipedal(name: str, rows: Rows) -> Gait:
    duty, lag = BIPEDAL[name]
    down = np.zeros(2)
    down[list(rows.right)] = lag
    return Gait.of(down, duty)


def _hop_on_one(_name: str, _rows: Rows) -> Gait:
    return Gait.of(np.zeros(1), BIPEDAL["hop"][0])


def _special(rows: Rows) -> Mapping[str, Callable[[str, Rows], Gait]]:
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


def gaits_of(rows: Rows) -> dict[str, Gait]:
    """Return the gaits that exist for such legs, by name, the general ones first."""
    special = _special(rows)
    return {"trot": trot(rows), "wave": wave(rows)} | {
        name: make(name, rows) for name, make in special.items()
    }


NEEDS = {
    "tripod": "6 legs",
    "ripple": "more than 4 legs",
    "walk": "one pair of legs or two",
    "run": "one pair of legs",
    "skip": "one pair of legs",
    "hop": "one leg or one pair",
    **dict.fromkeys(("amble", "pace", *ASYMMETRICAL), "two pairs of legs"),
}
"""What legs a gait is for, in words."""
