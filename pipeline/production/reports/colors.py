"""Colors that tell the parts of a figure apart; a left limb and its right twin share one."""

from __future__ import annotations

from collections.abc import Sequence

from pipeline.simulation.figures.network import ARM, FEELER, HEAD, LEG, TAIL
from pipeline.simulation.figures.skeleton import Limb

BODY_COLOR = "#64748b"
INK = "#1f2933"
FAINT = "#8a94a0"
PAPER = "#fbfaf7"
PANEL = "#f1efe9"
WARNING = "#b4442f"

LEG_COLORS = ("#e07a3f", "#2f8f9d", "#d9a514", "#7a6cc4", "#5f9e4c", "#c2577f")
COLORS = {HEAD: "#c8403c", TAIL: "#8b5a9f", ARM: "#2d6fb4", FEELER: "#8f8440"}


def limb_colors(limbs: Sequence[Limb]) -> list[str]:
    """Return a color for each limb."""
    counts: dict[tuple[str, str], int] = {}
    colors = []
    for limb in limbs:
        key = limb.kind, limb.side
        number = counts.get(key, 0)
        counts[key] = number + 1
        colors.append(
            LEG_COLORS[number % len(LEG_COLORS)] if limb.kind == LEG else COLORS[limb.kind]
        )
    return colors


def rgb(color: str) -> tuple[float, float, float]:
    """Return red, green and blue, 0 to 1, of `#rrggbb`."""
    red, green, blue = (int(color[k : k + 2], 16) / 255.0 for k in (1, 3, 5))
    return red, green, blue
