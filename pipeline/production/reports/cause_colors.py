"""Colors of causes, the same in every plot."""

from __future__ import annotations

from hashlib import blake2b

CAUSES = {
    "footfall": "#2d6fb4",
    "scuff": "#7fb0dc",
    "collision": "#c8403c",
    "roll": "#d9a514",
    "slide": "#a8842c",
    "squeak": "#5f9e4c",
    "squawk": "#3b6b34",
    "swoosh": "#2f8f9d",
    "whistle": "#74c4c9",
    "boing": "#e07a3f",
    "breath": "#c2577f",
    "cry": "#d64ba0",
    "hug": "#8e6bd1",
}
OTHERS = ("#7a6cc4", "#8b5a9f", "#64748b", "#b5651d", "#4b8f8c")


def color_of(cause: str) -> str:
    """Return the color of a cause; one that is new always gets the same of a few."""
    if cause in CAUSES:
        return CAUSES[cause]
    number = blake2b(cause.encode("utf-8", "replace"), digest_size=2).digest()
    return OTHERS[int.from_bytes(number) % len(OTHERS)]
