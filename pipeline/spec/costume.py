"""Costumes: names of what people wear."""

from __future__ import annotations

from typing import Literal, get_args

# fmt: off
Costume = Literal[
    "casual", "summer", "office", "hoodie", "coat", "dress", "skirt", "suit", "sport", "workwear",
]
# fmt: on

COSTUMES: tuple[Costume, ...] = get_args(Costume)
