"""Costumes: names of what people wear."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

# fmt: off
Costume = Literal[
    "casual", "summer", "office", "hoodie", "coat", "dress", "skirt", "suit", "sport", "workwear",
]
# fmt: on

COSTUME_TEXTS: Mapping[Costume, str] = {
    "casual": "a shirt with short sleeves over jeans",
    "summer": "a shirt with short sleeves over shorts",
    "office": "a shirt tucked into trousers",
    "hoodie": "a top with a hood",
    "coat": "a coat down to above the knees",
    "dress": "a dress of one colour",
    "skirt": "a blouse and a skirt",
    "suit": "a jacket over a shirt with a tie",
    "sport": "a tracksuit with stripes",
    "workwear": "dungarees over a shirt",
}
"""All costumes, with what they are."""

COSTUMES: tuple[Costume, ...] = tuple(COSTUME_TEXTS)
