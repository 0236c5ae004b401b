"""Shapes of bodies that ring: their modes, and how much of each a blow on one spot excites.

A blow excites a mode as much as the mode moves there: at a node it is silent. Spots run from 0 to
1 along a body's longest axis; across it, where nothing is known, chance has its say.

Source: Fletcher and Rossing 1998, for bar, membrane and bell. Ratios of plate and shell are
chosen by ear, denser and without harmony.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Signal = NDArray[np.float64]

Moves = Callable[[float, float], Signal]
"""Spot along (0 to 1) and across (0 to 1) -> (M,) how far modes move there, 1 at their most."""


@dataclass(frozen=True, slots=True)
class Shape:
    """A kind of body.

    Attributes:
        ratios: of the modes' frequencies to the lowest.
        moves: how far each mode moves at a spot.
    """

    ratios: tuple[float, ...]
    moves: Moves


# Roots of cos β cosh β = 1: a bar free at both ends.
_BETA = np.array([4.730041, 7.853205, 10.995608, 14.137165, 17.278760, 20.420352])
# (diameters, zero of the Bessel function of that order) of a membrane held at its rim.
_DRUM = (
    *((0, 2.4048), (1, 3.8317), (2, 5.1356), (0, 5.5201)),
    *((3, 6.3802), (1, 7.0156), (4, 7.5883), (2, 8.4172)),
)
# Half waves (along, across) of a plate free at its edges.
_PLATE = ((1, 1), (2, 0), (0, 2), (2, 1), (1, 2), (3, 0), (2, 2), (3, 1), (0, 3), (1, 3))
# (nodal meridians, nodal circles) of hum, prime, tierce, quint, nominal and on.
_BELL = (
    *((2, 0), (2, 1), (3, 0), (3, 1), (4, 0), (4, 1)),
    *((5, 1), (5, 0), (6, 0), (7, 0), (8, 0), (9, 0)),
)
_SHELL = ((0, 1), (1, 1), (2, 1), (2, 2), (3, 1), (1, 2), (3, 2), (0, 2), (4, 1), (4, 2))


def _bar(along: float, across: float) -> Signal:
    # About the middle every second mode is even, the others odd; the ends move most.
    x = _BETA * (along - 0.5)
    even = np.cos(x) / np.cos(_BETA / 2) + np.cosh(x) / np.cosh(_BETA / 2)
    odd = np.sin(x) / np.sin(_BETA / 2) + np.sinh(x) / np.sinh(_BETA / 2)
    return np.asarray(np.where(np.arange(_BETA.size) % 2 == 0, even, odd) / 2)


def _plate(along: float, across: float) -> Signal:
    m, n = np.array(_PLATE).T
    return np.asarray(np.cos(np.pi * m * along) * np.cos(np.pi * n * across))


def _membrane(along: float, across: float) -> Signal:
    order, zero = np.array(_DRUM).T
    # A blow on the very rim would be none: what lies on the ground is struck within it.
    radius = 0.9 * abs(2 * along - 1)
    return np.asarray(_bessel(order, zero * radius) / _MOST * np.cos(np.pi * order * across))


def _bessel(order: Signal, x: Signal) -> Signal:
    """Return J_n(x) by its integral; a mean over a period is exact but for rounding: (M,)."""
    t = 2 * np.pi * np.arange(64) / 64
    return np.asarray(np.cos(np.outer(order, t) - np.outer(x, np.sin(t))).mean(axis=1))


# The greatest value of J_0 to J_4 each.
_MOST = np.array([(1.0, 0.58187, 0.48650, 0.43439, 0.39965)[n] for n, _ in _DRUM])


def _bell(along: float, across: float) -> Signal:
    meridians, circles = np.array(_BELL).T
    # From the crown, which is held, to the rim, which is free.
    height = np.where(circles == 0, along**1.5, np.sin(1.5 * np.pi * along))
    return np.asarray(height * np.cos(np.pi * meridians * across))


def _shell(along: float, across: float) -> Signal:
    around, lengthwise = np.array(_SHELL).T
    return np.asarray(np.cos(np.pi * lengthwise * along) * np.cos(np.pi * around * across))


BAR = Shape((1.0, 2.756, 5.404, 8.933, 13.34, 18.64), _bar)
PLATE = Shape((1.0, 1.73, 2.33, 2.91, 4.10, 4.61, 5.99, 7.42, 8.90, 10.4), _plate)
BELL = Shape((0.5, 1.0, 1.2, 1.5, 2.0, 2.5, 2.67, 3.0, 4.0, 5.33, 6.67, 8.0), _bell)
MEMBRANE = Shape((1.0, 1.593, 2.136, 2.296, 2.653, 2.918, 3.156, 3.5), _membrane)
SHELL = Shape((1.0, 1.42, 2.09, 2.56, 3.39, 4.08, 5.20, 6.63, 8.37, 10.1), _shell)
