"""Layers: how the patterns of ground lie on one another, so that no tile is seen to repeat."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Layer:
    """How a layer lies relative to the first one.

    Attributes:
        scale: factor on the size of a tile.
        turn_deg: rotation [degrees].
    """

    scale: float
    turn_deg: float


FIRST_LAYER = Layer(1.0, 0.0)
SECOND_LAYER = Layer(1.37, 37.0)
ROCK_LAYER = Layer(1.13, 11.0)
SOIL_LAYER = Layer(1.0, 31.0)
DETAIL_LAYER = Layer(0.141, 67.0)
PATCHES = Layer(9.0, 19.0)
LARGE_PATCHES = Layer(61.0, 52.0)
BODY_PATCHES = Layer(1.7, 19.0)

PATCH_CONTRAST = 0.8
"""Weight of patches of each size."""

RIPPLED = frozenset({"sand"})
"""Patterns of ripples, which are strong in patches of the second colour and faint between them."""

CALM, RIPPLED_MOST = 0.2, 1.5
"""Strength of ripples between those patches, and by how much they are stronger in the middle."""

DETAILED = frozenset({"soil", "rock", "grass", "moss", "gravel"})
"""Patterns that are alike at all sizes: close to the camera, where their texels are wider than
pixels, a small copy lies on them."""

DETAIL = 0.6
"""Strength of that copy."""
