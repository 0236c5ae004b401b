"""Kinds: which appendages of a drawing are legs, and which its head and its tail.

The front-most base on the midline may carry a head and the rear-most a tail; where
several appendages have that base, or none has it to itself, their direction decides:
a head points to the front and a tail to the back, both along the midline.

Source: Sims 1987, 4.2: "depending on the position of their base nodes".
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from pipeline.simulation.figures.drawing import Drawing

LEG, ARM, HEAD, TAIL, FEELER = "leg", "arm", "head", "tail", "feeler"
BODY = "body"
ORDER = (LEG, ARM, HEAD, TAIL, FEELER)

Chain = tuple[int, ...]

ASTRAY = 0.3
"""How far to the side of the midline a head or tail may point, as a part of its length."""


def kinds_of(
    drawing: Drawing, chains: Sequence[Chain], told: Mapping[int, str], branches: bool = True
) -> dict[Chain, str]:
    """Return the kind of each appendage.

    Args:
        drawing: the flat network.
        chains: the appendages but feelers, from base to tip.
        told: kinds by tip, where the author knows better.
        branches: False for a single chain, whose ends are head and tail wherever they point.
    """
    kinds = {chain: told.get(chain[-1], "") for chain in chains}
    guessed = [chain for chain in chains if not kinds[chain]]
    kinds |= dict.fromkeys(guessed, LEG)
    if not chains:
        return kinds
    x, y = drawing.places.T
    if not branches:
        ends = sorted(guessed, key=lambda c: (y[c[-1]], x[c[-1]]))
        free = [kind for kind in (HEAD, TAIL) if kind not in kinds.values()]
        # An end that is alone is what it points to.
        if len(ends) == 1 and len(free) == 2 and y[ends[0][-1]] > y[ends[0][0]]:
            free.reverse()
        kinds |= dict(zip(ends, free, strict=False))
        return kinds
    rows = [float(y[chain[0]]) for chain in chains]
    waist = (min(rows) + max(rows)) / 2
    middle = midline(drawing)
    lengthwise = [chain for chain in guessed if _is_lengthwise(drawing, chain, middle)]
    if HEAD not in kinds.values():
        front = [c for c in lengthwise if y[c[-1]] < waist and y[c[-1]] < y[c[0]]]
        if front:
            kinds[min(front, key=lambda c: (y[c[0]], y[c[-1]], abs(x[c[-1]] - middle)))] = HEAD
    if TAIL not in kinds.values():
        back = [
            c for c in lengthwise if y[c[-1]] > waist and y[c[-1]] > y[c[0]] and kinds[c] == LEG
        ]
        if back:
            kinds[min(back, key=lambda c: (-y[c[0]], -y[c[-1]], abs(x[c[-1]] - middle)))] = TAIL
    return kinds


def in_order(drawing: Drawing, kinds: Mapping[Chain, str]) -> list[Chain]:
    """Return the appendages by kind, the left before the right, front to back."""

    def rank(chain: Chain) -> tuple[int, str, float, float]:
        y = drawing.places[list(chain), 1]
        return ORDER.index(kinds[chain]), side_of(drawing, chain), float(y[0]), float(y.mean())

    return sorted(kinds, key=rank)


def side_of(drawing: Drawing, chain: Chain) -> str:
    """Return the side that an appendage is on: "l", "r", or "m" in the middle."""
    lateral = float(drawing.places[list(chain), 0].mean()) - midline(drawing)
    extent = float(np.ptp(drawing.places, axis=0).max())
    if abs(lateral) <= 1e-6 * extent:
        return "m"
    return "l" if lateral < 0 else "r"


def midline(drawing: Drawing) -> float:
    """Return x of the midline: 0, or the middle of a drawing that lies on one side of it [m]."""
    low, high = float(drawing.places[:, 0].min()), float(drawing.places[:, 0].max())
    return 0.0 if low <= 0.0 <= high else (low + high) / 2


def _is_lengthwise(drawing: Drawing, chain: Chain, middle: float) -> bool:
    """Tell whether an appendage lies along the midline."""
    base, tip = drawing.places[chain[0]], drawing.places[chain[-1]]
    length = math.dist(base, tip)
    return bool(
        abs(tip[0] - base[0]) <= ASTRAY * length and abs(tip[0] - middle) <= ASTRAY * length
    )
