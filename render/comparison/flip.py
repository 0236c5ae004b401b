"""FLIP: how visible the difference of two pictures is, pixel by pixel.

Source: P. Andersson, J. Nilsson, T. Akenine-Möller, M. Oskarsson, K. Åström, M. D. Fairchild,
    FLIP: A Difference Evaluator for Alternating Images, Proc. ACM Comput. Graph. Interact.
    Tech. 3(2), 2020. The letters are the paper's.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from render.color import linear
from render.comparison.contrast import contrast_filtered
from render.comparison.features import feature_difference
from render.comparison.opponent import Plane, hunt_lab, hyab, opponent

PIXELS_PER_DEGREE: Final = 0.7 * 3840 / 0.7 * np.pi / 180
"""Of a picture on a screen 0.7 m wide of 3840 pixels, seen from 0.7 m; the paper's choice."""

_Q_C, _P_C, _P_T = 0.7, 0.4, 0.95
_Q_F = 0.5

Map = NDArray[np.float32]


def flip(reference: NDArray[np.uint8], test: NDArray[np.uint8]) -> Map:
    """Return how visible the difference of two sRGB pictures (H, W, 3) is, by the judge at hand.

    Returns:
        (H, W), 0 for what nobody sees to 1.

    Raises:
        ValueError: the pictures differ in size.
    """
    if reference.shape != test.shape:
        raise ValueError(f"pictures of {reference.shape[:2]} and {test.shape[:2]} pixels")
    return JUDGES[judge()](reference, test)


@cache
def judge() -> str:
    """Return the name of what computes FLIP here: the authors' own program where it is."""
    try:
        import flip_evaluator  # noqa: F401 (only whether it is there)
    except ImportError:
        return "pronk"
    return "flip-evaluator"


def by_pronk(reference: NDArray[np.uint8], test: NDArray[np.uint8]) -> Map:
    """Return FLIP by the formulas of the paper."""
    one, two = (opponent(linear(picture / 255.0)) for picture in (reference, test))
    color = _color_difference(one, two)
    feature = feature_difference(one[..., 0], two[..., 0], PIXELS_PER_DEGREE) ** _Q_F
    return np.asarray(color ** (1.0 - feature), np.float32)


def _color_difference(one: Plane, two: Plane) -> Plane:
    """Return ΔE_c (H, W) of two pictures in YCxCz (H, W, 3): equations 5 to 8 of the paper."""
    labs = (hunt_lab(contrast_filtered(picture, PIXELS_PER_DEGREE)) for picture in (one, two))
    power = hyab(*labs) ** _Q_C
    most = _largest() ** _Q_C
    # The first part of the range is where most differences lie; large ones share the rest.
    bend = _P_C * most
    low = power * (_P_T / bend)
    high = _P_T + (power - bend) / (most - bend) * (1.0 - _P_T)
    return np.asarray(np.where(power < bend, low, high))


@cache
def _largest() -> float:
    """Return the largest distance of two colours of sRGB, which is that of green and blue."""
    green, blue = np.eye(3)[1:]
    return float(hyab(hunt_lab(opponent(green)), hunt_lab(opponent(blue))))


def _by_evaluator(reference: NDArray[np.uint8], test: NDArray[np.uint8]) -> Map:
    import flip_evaluator

    one, two = ((picture / np.float32(255)).astype(np.float32) for picture in (reference, test))
    values = flip_evaluator.evaluate(
        one, two, "LDR", applyMagma=False, parameters={"ppd": float(PIXELS_PER_DEGREE)}
    )[0]
    return np.asarray(values, np.float32).reshape(reference.shape[:2])


JUDGES: Final[dict[str, Callable[[NDArray[np.uint8], NDArray[np.uint8]], Map]]] = {
    "flip-evaluator": _by_evaluator,
    "pronk": by_pronk,
}
"""What computes FLIP, by name; measured to agree within a thousandth."""
