"""Mode shapes of ideal bodies: bar, plate, membrane, bell and shell.

Points run from 0 to 1 along the body's longest axis and across it.

Source: van den Doel and Pai 1998; Fletcher and Rossing 1998 for bar, membrane and bell. The
ratios of plate and shell are chosen by ear, denser and inharmonic.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from audio.dsp import Signal

Displacement = Callable[[float, float], Signal]
"""Point along (0 to 1) and across (0 to 1) -> (M,) displacement of the modes, at most 1."""


@dataclass(frozen=True, slots=True)
class ModeShape:
    """Modes of an ideal body.

    Attributes:
        ratios: of the modes' frequencies to the lowest.
        displacement: of each mode at a point.
    """

    ratios: tuple[float, ...]
    displacement: Displacement


# Roots of cos β cosh β = 1: a bar free at both ends.
_BAR_ROOTS = np.array([4.730041, 7.853205, 10.995608, 14.137165, 17.278760, 20.420352])
# (diameters, zero of the Bessel function of that order) of a membrane held at its rim.
_MEMBRANE_MODES = (
    *((0, 2.4048), (1, 3.8317), (2, 5.1356), (0, 5.5201)),
    *((3, 6.3802), (1, 7.0156), (4, 7.5883), (2, 8.4172)),
)
# Half waves (along, across) of a plate free at its edges.
_PLATE_MODES = ((1, 1), (2, 0), (0, 2), (2, 1), (1, 2), (3, 0), (2, 2), (3, 1), (0, 3), (1, 3))
# (nodal meridians, nodal circles) of hum, prime, tierce, quint, nominal and higher modes.
_BELL_MODES = (
    *((2, 0), (2, 1), (3, 0), (3, 1), (4, 0), (4, 1)),
    *((5, 1), (5, 0), (6, 0), (7, 0), (8, 0), (9, 0)),
)
# Half waves (around, along).
_SHELL_MODES = ((0, 1), (1, 1), (2, 1), (2, 2), (3, 1), (1, 2), (3, 2), (0, 2), (4, 1), (4, 2))

# The same by columns.
_MEMBRANE, _PLATE, _BELL, _SHELL = (
    np.array(modes).T for modes in (_MEMBRANE_MODES, _PLATE_MODES, _BELL_MODES, _SHELL_MODES)
)


def _bar(along: float, across: float) -> Signal:
    # About the middle, modes are alternately even and odd; the ends move most.
    x = _BAR_ROOTS * (along - 0.5)
    even = np.cos(x) / np.cos(_BAR_ROOTS / 2) + np.cosh(x) / np.cosh(_BAR_ROOTS / 2)
    odd = np.sin(x) / np.sin(_BAR_ROOTS / 2) + np.sinh(x) / np.sinh(_BAR_ROOTS / 2)
    return np.asarray(np.where(np.arange(_BAR_ROOTS.size) % 2 == 0, even, odd) / 2)


def _plate(along: float, across: float) -> Signal:
    m, n = _PLATE
    return np.asarray(np.cos(np.pi * m * along) * np.cos(np.pi * n * across))


def _membrane(along: float, across: float) -> Signal:
    order, zero = _MEMBRANE
    # An impact on the very rim would excite nothing.
    radius = 0.9 * abs(2 * along - 1)
    bessel = _bessel(order, zero * radius)
    return np.asarray(bessel / _BESSEL_MAXIMA * np.cos(np.pi * order * across))


def _bessel(order: Signal, x: Signal) -> Signal:
    """Return J_n(x) by its integral; a mean over a period is exact but for rounding: (M,)."""
    t = 2 * np.pi * np.arange(64) / 64
    return np.asarray(np.cos(np.outer(order, t) - np.outer(x, np.sin(t))).mean(axis=1))


# Maxima of J_0 to J_4.
_BESSEL_MAXIMA = np.array(
    [(1.0, 0.58187, 0.48650, 0.43439, 0.39965)[n] for n, _ in _MEMBRANE_MODES]
)


def _bell(along: float, across: float) -> Signal:
    meridians, circles = _BELL
    # From the crown, which is held, to the rim, which is free.
    height = np.where(circles == 0, along**1.5, np.sin(1.5 * np.pi * along))
    return np.asarray(height * np.cos(np.pi * meridians * across))


def _shell(along: float, across: float) -> Signal:
    around, lengthwise = _SHELL
    return np.asarray(np.cos(np.pi * lengthwise * along) * np.cos(np.pi * around * across))


BAR = ModeShape((1.0, 2.756, 5.404, 8.933, 13.34, 18.64), _bar)
PLATE = ModeShape((1.0, 1.73, 2.33, 2.91, 4.10, 4.61, 5.99, 7.42, 8.90, 10.4), _plate)
BELL = ModeShape((0.5, 1.0, 1.2, 1.5, 2.0, 2.5, 2.67, 3.0, 4.0, 5.33, 6.67, 8.0), _bell)
MEMBRANE = ModeShape((1.0, 1.593, 2.136, 2.296, 2.653, 2.918, 3.156, 3.5), _membrane)
SHELL = ModeShape((1.0, 1.42, 2.09, 2.56, 3.39, 4.08, 5.20, 6.63, 8.37, 10.1), _shell)
