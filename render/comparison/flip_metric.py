"""FLIP: how visible the difference of two images is, pixel by pixel.

Source: P. Andersson, J. Nilsson, T. Akenine-Möller, M. Oskarsson, K. Åström, M. D. Fairchild,
    FLIP: A Difference Evaluator for Alternating Images, Proc. ACM Comput. Graph. Interact.
    Tech. 3(2), 2020. The letters are the paper's.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from render.color import linear

Plane = NDArray[np.float64]
Map = NDArray[np.float32]

PIXELS_PER_DEGREE: Final = 0.7 * 3840 / 0.7 * np.pi / 180
"""Of a screen 0.7 m and 3840 pixels wide, viewed from 0.7 m; the paper's choice."""

_Q_C, _P_C, _P_T = 0.7, 0.4, 0.95
_Q_F = 0.5

# Table 1: a and b of each Gaussian in its Fourier transform, for luminance, red to green and
# blue to yellow.
_CONTRAST_SENSITIVITY: Final = (
    ((1.0, 0.0047),),
    ((1.0, 0.0053),),
    ((34.1, 0.04), (13.5, 0.025)),
)

_FEATURE_WIDTH: Final = 0.082
"""Width of an edge or a point that the eye detects [degrees]; section 4.2."""

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


def flip(reference: NDArray[np.uint8], test: NDArray[np.uint8]) -> Map:
    """Return the visibility (H, W) of the difference of two sRGB images (H, W, 3), 0 to 1.

    Raises:
        ValueError: the images differ in size.
    """
    if reference.shape != test.shape:
        raise ValueError(f"images of {reference.shape[:2]} and {test.shape[:2]} pixels")
    return JUDGES[judge()](reference, test)


@cache
def judge() -> str:
    """Return the name of the implementation in use: the authors' program if it is installed."""
    try:
        import flip_evaluator  # noqa: F401 (tests whether it is installed)
    except ImportError:
        return "pronk"
    return "flip-evaluator"


def _by_pronk(reference: NDArray[np.uint8], test: NDArray[np.uint8]) -> Map:
    """Return FLIP by the formulas of the paper."""
    one, two = (_ycxcz(linear(image / 255.0)) for image in (reference, test))
    color = _color_difference(one, two)
    feature = _feature_difference(one[..., 0], two[..., 0], PIXELS_PER_DEGREE) ** _Q_F
    return np.asarray(color ** (1.0 - feature), np.float32)


def _by_evaluator(reference: NDArray[np.uint8], test: NDArray[np.uint8]) -> Map:
    import flip_evaluator

    one, two = ((image / np.float32(255)).astype(np.float32) for image in (reference, test))
    values = flip_evaluator.evaluate(
        one, two, "LDR", applyMagma=False, parameters={"ppd": float(PIXELS_PER_DEGREE)}
    )[0]
    return np.asarray(values, np.float32).reshape(reference.shape[:2])


JUDGES: Final[dict[str, Callable[[NDArray[np.uint8], NDArray[np.uint8]], Map]]] = {
    "flip-evaluator": _by_evaluator,
    "pronk": _by_pronk,
}
"""Implementations of FLIP by name; measured to agree within a thousandth."""


def _color_difference(one: Plane, two: Plane) -> Plane:
    """Return ΔE_c (H, W) of two images in YCxCz (H, W, 3); equations 5 to 8."""
    labs = (_hunt_lab(_contrast_filtered(image, PIXELS_PER_DEGREE)) for image in (one, two))
    power = _hyab(*labs) ** _Q_C
    largest = _largest_distance() ** _Q_C
    # Most differences lie in the first part of the range; large ones share the rest.
    bend = _P_C * largest
    low = power * (_P_T / bend)
    high = _P_T + (power - bend) / (largest - bend) * (1.0 - _P_T)
    return np.asarray(np.where(power < bend, low, high))


@cache
def _largest_distance() -> float:
    """Return the largest distance of two sRGB colours, which is that of green and blue."""
    green, blue = np.eye(3)[1:]
    return float(_hyab(_hunt_lab(_ycxcz(green)), _hunt_lab(_ycxcz(blue))))


def _contrast_filtered(ycxcz: Plane, ppd: float) -> Plane:
    """Return an image in YCxCz (H, W, 3) filtered by contrast sensitivity at `ppd` pixels a degree.

    Source: section 4.1.1.
    """
    widest = max(b for terms in _CONTRAST_SENSITIVITY for _, b in terms)
    radius = math.ceil(3.0 * math.sqrt(widest / (2.0 * math.pi**2)) * ppd)
    degrees = np.arange(-radius, radius + 1) / ppd
    channels = []
    for i, terms in enumerate(_CONTRAST_SENSITIVITY):
        weights, kernels = [], []
        for a, b in terms:
            kernel = np.exp(-(math.pi**2) * degrees**2 / b)
            # a·√(π/b) is of the transform in one dimension; the paper uses it in two as well.
            weights.append(a * math.sqrt(math.pi / b) * kernel.sum() ** 2)
            kernels.append(kernel / kernel.sum())
        whole = sum(weights)
        filtered = (
            weight / whole * _separable_filter(ycxcz[..., i], kernel, kernel)
            for weight, kernel in zip(weights, kernels, strict=True)
        )
        channels.append(np.asarray(sum(filtered)))
    return np.stack(channels, axis=-1)


def _feature_difference(one: Plane, two: Plane, ppd: float) -> Plane:
    """Return the difference (H, W) of edges and points of two luminances (H, W), 0 to 1.

    Source: section 4.2.
    """
    edges, points = zip(_features(one, ppd), _features(two, ppd), strict=True)
    difference = np.maximum(np.abs(edges[0] - edges[1]), np.abs(points[0] - points[1]))
    return np.asarray(difference / math.sqrt(2.0))


def _features(luminance: Plane, ppd: float) -> tuple[Plane, Plane]:
    """Return the strength of edges and of points, each (H, W)."""
    grey = (luminance + 16.0) / 116.0
    sigma = 0.5 * _FEATURE_WIDTH * ppd
    radius = math.ceil(3.0 * sigma)
    x = np.arange(-radius, radius + 1.0)
    bell = np.exp(-(x**2) / (2.0 * sigma**2))
    bell /= bell.sum()
    first = _balanced(-x * bell)
    second = _balanced((x**2 / sigma**2 - 1.0) * bell)
    edge, point = (
        np.hypot(_separable_filter(grey, kernel, bell), _separable_filter(grey, bell, kernel))
        for kernel in (first, second)
    )
    return edge, point


def _balanced(kernel: Plane) -> Plane:
    """Return a kernel with its positive weights scaled to sum 1, its negative ones to -1."""
    above, below = kernel[kernel > 0].sum(), -kernel[kernel < 0].sum()
    return np.asarray(np.where(kernel > 0, kernel / above, kernel / below))


def _separable_filter(values: Plane, along_x: Plane, along_y: Plane) -> Plane:
    """Return values (H, W) filtered by two kernels of one odd length, with repeated borders."""
    return _filter_columns(_filter_columns(values, along_y).T, along_x).T


def _filter_columns(values: Plane, kernel: Plane) -> Plane:
    radius = len(kernel) // 2
    padded = np.pad(values, ((radius, radius), (0, 0)), mode="edge")
    result = np.zeros_like(values)
    for k, weight in enumerate(kernel.tolist()):
        result += weight * padded[k : k + len(values)]
    return result


def _ycxcz(rgb: Plane) -> Plane:
    """Return YCxCz (..., 3) of linear sRGB (..., 3): luminance, red to green, blue to yellow.

    Source: section 4.1.
    """
    x, y, z = _relative_xyz(rgb)
    return np.stack([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)], axis=-1)


def _rgb_from_ycxcz(ycxcz: Plane) -> Plane:
    """Return linear sRGB (..., 3) of YCxCz, clipped to 0..1."""
    y = (ycxcz[..., 0] + 16.0) / 116.0
    x = ycxcz[..., 1] / 500.0 + y
    z = y - ycxcz[..., 2] / 200.0
    xyz = [value * white for value, white in zip((x, y, z), _WHITE, strict=True)]
    return np.clip(np.stack(_mixed(xyz, _FROM_XYZ), axis=-1), 0.0, 1.0)


def _hunt_lab(ycxcz: Plane) -> Plane:
    """Return L*a*b* (..., 3) with a* and b* scaled by lightness (Hunt effect); equation 4."""
    x, y, z = (_cube_root(value) for value in _relative_xyz(_rgb_from_ycxcz(ycxcz)))
    lightness = 116.0 * y - 16.0
    faded = 0.01 * lightness
    return np.stack([lightness, faded * 500.0 * (x - y), faded * 200.0 * (y - z)], axis=-1)


def _hyab(one: Plane, two: Plane) -> Plane:
    """Return the HyAB distance (...) of colours (..., 3): of lightness, plus that of a* and b*."""
    difference = one - two
    chroma = np.hypot(difference[..., 1], difference[..., 2])
    return np.asarray(np.abs(difference[..., 0]) + chroma)


def _relative_xyz(rgb: Plane) -> list[Plane]:
    """Return X, Y and Z of linear sRGB (..., 3), relative to white."""
    xyz = _mixed([rgb[..., i] for i in range(3)], _TO_XYZ)
    return [value / white for value, white in zip(xyz, _WHITE, strict=True)]


def _mixed(channels: list[Plane], matrix: tuple[tuple[float, ...], ...]) -> list[Plane]:
    # Sums written out, because a BLAS product may round by its number of threads.
    a, b, c = channels
    return [row[0] * a + row[1] * b + row[2] * c for row in matrix]


def _cube_root(t: Plane) -> Plane:
    """Return f(t) of CIE L*a*b*, which is linear near 0."""
    straight = t / (3.0 * _KNEE**2) + 4.0 / 29.0
    return np.where(t > _KNEE**3, np.cbrt(np.maximum(t, 0.0)), straight)
