"""Surroundings: all directions around the scene, its key light, and how they are exposed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from render.lights.environment_map import UP, Image, brightness, smooth, unit
from render.lights.key_light import Key

_TURNS = 0.1
"""Share of the key light for which the grey card turns to it whole."""


@dataclass(frozen=True, eq=False)
class Surroundings:
    """What surrounds the scene, in units of its own.

    Attributes:
        image: (H, W, 3) radiance of all directions.
        key: the light before it.
        card: irradiance of the grey card that is to be shown as middle grey.
        stops: how much brighter than that.
        points: (H', W', 3) or None, a finer map of points of light, shown as bright as it is.
    """

    image: Image
    key: Key
    card: float
    stops: float = 0.0
    points: Image | None = None


def turn_of(image: Image, key: Key) -> float:
    """Return how far a grey card is turned from the zenith to half way to the key light.

    The weaker the key light, the more the card faces the zenith.
    """
    if not key.lit:
        return 0.0
    normal = unit(key.toward + UP)
    own = key.brightness(normal)
    return float(smooth(np.array(own / (brightness(image, normal) + own) / _TURNS)))


def card_of(image: Image, key: Key, turn: float | None = None) -> float:
    """Return the light on a grey card.

    Args:
        image: all directions.
        key: the light before them.
        turn: how far the card is turned to the key light, as `turn_of` has it unless given.
    """
    turn = turn_of(image, key) if turn is None else turn
    level = brightness(image, UP) + key.brightness(UP)
    if turn == 0.0:
        return level
    normal = unit(key.toward + UP)
    return level + turn * (brightness(image, normal) + key.brightness(normal) - level)
