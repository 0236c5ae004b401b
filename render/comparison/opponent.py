"""Opponent colours: the spaces that FLIP filters and measures in.

Source: Andersson et al. 2020, sections 4.1 and 4.1.2; Hunt's effect as in its equation 4.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

Plane = NDArray[np.float64]

# From linear sRGB to XYZ by the primaries and the white point of IEC 61966-2-1, written as the
# exact quotients that follow from their chromaticities.
_D: Final = 24577794.0
_TO_XYZ: Final = (
    (10135552 / _D, 8788810 / _D, 4435075 / _D),
    (2613072 / 12288897, 8788810 / 12288897, 887015 / 12288897),
    (1425312 / 73733382, 8788810 / 73733382, 70074185 / 73733382),
)
_WHITE: Final = tuple(sum(row) for row in _TO_XYZ)
_FROM_XYZ: Final = tuple(map(tuple, np.linalg.inv(np.array(_TO_XYZ)).tolist()))
_KNEE: Final = 6.0 / 29.0


def opponent(rgb: Plane) -> Plane:
    """Return YCxCz (..., 3) of linear sRGB (..., 3): luminance, red to green, blue to yellow."""
    x, y, z = _relative(rgb)
    return np.stack([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)], axis=-1)


def rgb_of(ycxcz: Plane) -> Plane:
    """Return linear sRGB (..., 3), 0 to 1, of YCxCz; what no screen can show is clipped."""
    y = (ycxcz[..., 0] + 16.0) / 116.0
    x = ycxcz[..., 1] / 500.0 + y
    z = y - ycxcz[..., 2] / 200.0
    xyz = [value * white for value, white in zip((x, y, z), _WHITE, strict=True)]
    return np.clip(np.stack(_mixed(xyz, _FROM_XYZ), axis=-1), 0.0, 1.0)


def hunt_lab(ycxcz: Plane) -> Plane:
    """Return L*a*b* (..., 3) with a* and b* scaled by lightness, as colours fade in the dark."""
    x, y, z = (_cube_root(value) for value in _relative(rgb_of(ycxcz)))
    lightness = 116.0 * y - 16.0
    faded = 0.01 * lightness
    return np.stack([lightness, faded * 500.0 * (x - y), faded * 200.0 * (y - z)], axis=-1)


def hyab(one: Plane, two: Plane) -> Plane:
    """Return the distance (...) of colours (..., 3): of lightness, plus that of the rest."""
    apart = one - two
    return np.asarray(np.abs(apart[..., 0]) + np.hypot(apart[..., 1], apart[..., 2]))


def _relative(rgb: Plane) -> list[Plane]:
    """Return X, Y and Z of linear sRGB (..., 3), each beside that of white."""
    xyz = _mixed([rgb[..., i] for i in range(3)], _TO_XYZ)
    return [value / white for value, white in zip(xyz, _WHITE, strict=True)]


def _mixed(channels: list[Plane], matrix: tuple[tuple[float, ...], ...]) -> list[Plane]:
    # Sums written out, because a BLAS product may round by its number of threads.
    a, b, c = channels
    return [row[0] * a + row[1] * b + row[2] * c for row in matrix]


def _cube_root(t: Plane) -> Plane:
    """Return f(t) of CIE L*a*b*, whose foot is straight."""
    straight = t / (3.0 * _KNEE**2) + 4.0 / 29.0
    return np.where(t > _KNEE**3, np.cbrt(np.maximum(t, 0.0)), straight)
