"""Colors of the plots: paper and ink, limbs, and causes of sounds."""

from __future__ import annotations

from collections.abc import Sequence
from hashlib import blake2b

BODY_COLOR = "#64748b"
INK = "#1f2933"
FAINT = "#8a94a0"
PAPER = "#fbfaf7"
PANEL = "#f1efe9"
GRID = "#d7d3c8"
WARNING = "#b4442f"

LEG_COLORS = ("#e07a3f", "#2f8f9d", "#d9a514", "#7a6cc4", "#5f9e4c", "#c2577f")
LIMB_COLORS = {
    "head": "#c8403c",
    "tail": "#8b5a9f",
    "arm": "#2d6fb4",
    "feeler": "#8f8440",
    "horn": "#7a5c3e",
    "wing": "#3f9c86",
}

CAUSE_COLORS = {
    "footfall": "#2d6fb4",
    "scuff": "#7fb0dc",
    "collision": "#c8403c",
    "roll": "#d9a514",
    "slide": "#a8842c",
    "squeak": "#5f9e4c",
    "squawk": "#3b6b34",
    "swoosh": "#2f8f9d",
    "whistle": "#74c4c9",
    "wings": "#5b7f95",
    "rustle": "#b08d9e",
    "boing": "#e07a3f",
    "breath": "#c2577f",
    "cry": "#d64ba0",
    "hug": "#8e6bd1",
    "laugh": "#e8a33d",
    "gasp": "#7a9cc6",
    "call": "#3f9c86",
    "growl": "#8b3a2e",
    "whine": "#9fb84a",
}
OTHER_CAUSES = ("#7a6cc4", "#8b5a9f", "#64748b", "#b5651d", "#4b8f8c")


def limb_colors(limbs: Sequence[tuple[str, str]]) -> list[str]:
    """Return a color for each limb, given as kind and side; left and right twins share one."""
    counts: dict[tuple[str, str], int] = {}
    colors = []
    for limb in limbs:
        number = counts.get(limb, 0)
        counts[limb] = number + 1
        colors.append(LIMB_COLORS.get(limb[0]) or LEG_COLORS[number % len(LEG_COLORS)])
    return colors


def cause_color(cause: str) -> str:
    """Return the color of a cause; an unknown one always gets the same of a few."""
    if cause in CAUSE_COLORS:
        return CAUSE_COLORS[cause]
    number = blake2b(cause.encode("utf-8", "replace"), digest_size=2).digest()
    return OTHER_CAUSES[int.from_bytes(number) % len(OTHER_CAUSES)]


def rgb(color: str) -> tuple[float, float, float]:
    """Return red, green and blue, 0 to 1, of `#rrggbb`."""
    red, green, blue = (int(color[k : k + 2], 16) / 255.0 for k in (1, 3, 5))
    return red, green, blue
