"""Colour: sRGB encoding, and AgX tone mapping of scene light.

AgX compresses scene light to the range of a screen much as film does: highlights roll off and
lose saturation instead of clipping to primaries.

Source: T. Sobotka, AgX, 2022; the polynomial fit and the matrices are those of
    B. Wrensch, Minimal AgX Implementation, 2023 (iolite-engine.com), which are
    for linear sRGB.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

LUMINANCE = (0.2126, 0.7152, 0.0722)

_INSET = (
    (0.842479062253094, 0.0784335999999992, 0.0792237451477643),
    (0.0423282422610123, 0.878468636469772, 0.0791661274605434),
    (0.0423756549057051, 0.0784336, 0.879142973793104),
)
_OUTSET = (
    (1.19687900512017, -0.0980208811401368, -0.0990297440797205),
    (-0.0528968517574562, 1.15190312990417, -0.0989611768448433),
    (-0.0529716355144438, -0.0980434501171241, 1.15107367264116),
)
_LOW_STOP, _HIGH_STOP = -12.47393, 4.026069
_MIDDLE_GREY = math.log2(0.18)
_SIGMOID = (15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.00232)

# Grading of the neutral curve: AgX's own "punchy" look is power 1.35, saturation 1.4; half way
# keeps skies and soil believable.
_POWER = 1.15
_SATURATION = 1.12

SHADOW_SHARE = 0.35
"""Share of added contrast that what is darker than middle grey has."""

CURVE_SAMPLES = 8192
"""Length of `curve`."""


def linear(srgb: ArrayLike) -> NDArray[np.float64]:
    """Return linear light of sRGB values, both 0 to 1 and of any shape (IEC 61966-2-1)."""
    s = np.asarray(srgb, np.float64)
    return np.where(s <= 0.04045, s / 12.92, ((np.maximum(s, 0.04045) + 0.055) / 1.055) ** 2.4)


def encoded(light: ArrayLike) -> NDArray[np.float64]:
    """Return sRGB values of linear light, both 0 to 1 and of any shape; inverse of `linear`."""
    x = np.clip(np.asarray(light, np.float64), 0.0, 1.0)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.maximum(x, 1e-9) ** (1 / 2.4) - 0.055)


def luminance(light: NDArray[np.floating]) -> NDArray[np.floating]:
    """Return the luminance of linear sRGB light, (..., 3) -> (...)."""
    r, g, b = LUMINANCE
    return np.asarray(r * light[..., 0] + g * light[..., 1] + b * light[..., 2])


def inset(channels: list[NDArray[np.float32]]) -> list[NDArray[np.float32]]:
    """Return the channels of light as the curve takes them: primaries moved inward."""
    return _mixed(channels, _INSET)


def outset(channels: list[NDArray[np.float32]]) -> list[NDArray[np.float32]]:
    """Return the channels that the curve gave as sRGB."""
    r, g, b = LUMINANCE
    grey = (r * channels[0] + g * channels[1] + b * channels[2]) * np.float32(1 - _SATURATION)
    return _mixed([grey + np.float32(_SATURATION) * c for c in channels], _OUTSET)


def curve_index(
    channel: NDArray[np.float32], stops: float, contrast: float = 1.0
) -> NDArray[np.intp]:
    """Return the samples of `curve` for the light of a channel.

    Args:
        channel: of `inset`.
        stops: of exposure.
        contrast: of the exposed light about middle grey, in stops per stop.
    """
    per_stop = np.float32((CURVE_SAMPLES - 1) / (_HIGH_STOP - _LOW_STOP))
    grey = np.float32((_MIDDLE_GREY - _LOW_STOP) * per_stop)
    found = np.log2(np.maximum(channel, np.float32(1e-12))) + np.float32(stops - _MIDDLE_GREY)
    # Shadows keep most of their light, or what the sun does not reach would be black.
    low = np.float32(1.0 + SHADOW_SHARE * (contrast - 1.0)) if contrast > 1.0 else contrast
    found *= np.where(found > 0.0, np.float32(contrast * per_stop), np.float32(low * per_stop))
    found += grey
    return (np.clip(found, 0, CURVE_SAMPLES - 1) + np.float32(0.5)).astype(np.intp)


def _mixed(
    channels: list[NDArray[np.float32]], matrix: tuple[tuple[float, ...], ...]
) -> list[NDArray[np.float32]]:
    # Sums written out, because a BLAS product may round by its number of threads.
    x, y, z = channels
    return [np.float32(a) * x + np.float32(b) * y + np.float32(c) * z for a, b, c in matrix]


@cache
def curve() -> NDArray[np.float32]:
    """Return the sigmoid with the power of the look, sampled over the range of stops."""
    bent = np.polyval(_SIGMOID, np.linspace(0.0, 1.0, CURVE_SAMPLES))
    return np.asarray(np.clip(bent, 0.0, 1.0) ** _POWER, np.float32)
