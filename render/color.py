"""Colour: sRGB encoding, and AgX tone mapping of scene light.

AgX compresses scene light to the range of a screen much as film does: highlights roll off and
lose saturation instead of clipping to primaries.

Source: T. Sobotka, AgX, 2022; the polynomial fit and the matrices are those of
    B. Wrensch, Minimal AgX Implementation, 2023 (iolite-engine.com), which are
    for linear sRGB.
"""

from __future__ import annotations

from functools import cache
from typing import TypeVar

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
_SIGMOID = (15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.00232)

# Grading of the neutral curve: AgX's own "punchy" look is power 1.35, saturation 1.4; half way
# keeps skies and soil believable.
_POWER = 1.15
_SATURATION = 1.12

_CURVE_SAMPLES = 8192


Integer = TypeVar("Integer", np.uint8, np.uint16)

BAND_ROWS = 128
"""Rows of an image that are developed together, so that they stay in the cache."""


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


def developed(light: NDArray[np.float32], stops: float) -> NDArray[np.uint8]:
    """Return scene light as an 8-bit sRGB image.

    Args:
        light: (H, W, 3) linear sRGB, 0 or more; 0.18 is middle grey.
        stops: exposure compensation.

    Returns:
        (H, W, 3) sRGB, ready to show.
    """
    return _quantized(light, stops, np.uint8)


def developed16(light: NDArray[np.float32], stops: float) -> NDArray[np.uint16]:
    """Return scene light as a 16-bit sRGB image; see `developed`."""
    return _quantized(light, stops, np.uint16)


def _quantized(light: NDArray[np.float32], stops: float, kind: type[Integer]) -> NDArray[Integer]:
    top = np.iinfo(kind).max
    out = np.empty(light.shape, kind)
    for band in range(0, len(light), BAND_ROWS):
        rows = slice(band, band + BAND_ROWS)
        for i, c in enumerate(_tone_mapped(light[rows], stops)):
            out[rows, ..., i] = np.clip(c * top + 0.5, 0, top)
    return out


def _tone_mapped(light: NDArray[np.float32], stops: float) -> list[NDArray[np.float32]]:
    """Return the channels of the tone-mapped image, about 0 to 1."""
    curve = _curve()
    low, per_stop = np.float32(_LOW_STOP - stops), (_CURVE_SAMPLES - 1) / (_HIGH_STOP - _LOW_STOP)
    channels = [light[..., i] for i in range(3)]
    inset = _mixed(channels, _INSET)
    index = [
        np.clip((np.log2(np.maximum(c, 1e-12)) - low) * per_stop, 0, _CURVE_SAMPLES - 1)
        for c in inset
    ]
    bent = [curve[(i + 0.5).astype(np.intp)] for i in index]
    r, g, b = LUMINANCE
    grey = (r * bent[0] + g * bent[1] + b * bent[2]) * np.float32(1 - _SATURATION)
    graded = [grey + np.float32(_SATURATION) * c for c in bent]
    return _mixed(graded, _OUTSET)


def _mixed(
    channels: list[NDArray[np.float32]], matrix: tuple[tuple[float, ...], ...]
) -> list[NDArray[np.float32]]:
    # Sums written out, because a BLAS product may round by its number of threads.
    x, y, z = channels
    return [np.float32(a) * x + np.float32(b) * y + np.float32(c) * z for a, b, c in matrix]


@cache
def _curve() -> NDArray[np.float32]:
    """Return the sigmoid with the power of the look, sampled over the range of stops."""
    bent = np.polyval(_SIGMOID, np.linspace(0.0, 1.0, _CURVE_SAMPLES))
    return np.asarray(np.clip(bent, 0.0, 1.0) ** _POWER, np.float32)
