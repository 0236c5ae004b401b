"""Glazing: how the windows of a house are divided, framed, and dressed from within."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

BAR = 0.062
"""Thickness of frames and bars [m]."""


class Box(NamedTuple):
    """A box in an opening.

    Attributes:
        material: as `Facade.add` takes it.
        at: its middle: along from the middle of the opening, over its lower edge, and before the
            facade [m].
        size: along, up and outward [m].
    """

    material: str
    at: tuple[float, float, float]
    size: tuple[float, float, float]


@dataclass(frozen=True)
class Glazing:
    """How the windows of one house are made.

    Attributes:
        pane: width of a pane, about [m].
        transoms: heights of the bars across, in the height of the window.
        frame: material of frame and bars; none: that of the shutters.
        has_surround: whether hewn stone frames the opening.
    """

    pane: float
    transoms: tuple[float, ...]
    frame: str | None = "window frame"
    has_surround: bool = True

    def bars(self, wide: float, tall: float, wood: str) -> list[Box]:
        """Return frame and bars of a window `wide` and `tall` [m], in a house of a `wood`."""
        frame = self.frame or wood
        count = max(round(wide / self.pane), 1)
        # Between casements a bar is as thick as the frame, within them it is slender.
        found = []
        for k in range(count + 1):
            is_slender = 0 < k < count and 2 * k != count
            across = (k / count - 0.5) * (wide - BAR)
            found.append(
                Box(
                    frame,
                    (across, 0.5 * tall, -0.22),
                    (BAR * (0.42 if is_slender else 1), tall, 0.06),
                )
            )
        for t in (0.0, *self.transoms, 1.0):
            thick = BAR * (0.5 if 0.0 < t < 1.0 else 1.0)
            up = 0.5 * BAR + t * (tall - BAR)
            found.append(Box(frame, (0.0, up, -0.22), (wide, thick, 0.055)))
        return found


GLAZINGS = (
    Glazing(0.55, (0.68,)),
    Glazing(0.55, (0.34, 0.67), None),
    Glazing(0.28, (0.25, 0.5, 0.75)),
    Glazing(0.55, (), "shutter brown"),
    Glazing(0.55, (0.5,), has_surround=False),
    Glazing(0.36, (0.7, 0.85), has_surround=False),
)
"""Casements with a light over them, of six panes, of small ones, whole; sashes; leaded lights."""

SHOP_GLAZING = Glazing(0.9, (0.68,), None)

CURTAINS, BLIND, NETS = 0.42, 0.54, 0.7
"""Shares of the windows, one upon the other, with curtains drawn aside, a blind let down in part,
and nets across their lower half; the others are bare."""


def dressing(chance: float, rng: np.random.Generator, wide: float, tall: float) -> list[Box]:
    """Return what hangs behind the panes of a window.

    Args:
        chance: number from 0 to 1 by which it is chosen.
        rng: of its size.
        wide: of the window [m].
        tall: of the window [m].
    """
    if chance >= NETS:
        return []
    share = float(rng.uniform(0.2, 0.38))
    if chance < CURTAINS:
        drawn = share * wide
        aside = 0.5 * (wide - drawn)
        size = (drawn, tall, 0.01)
        return [Box("curtain", (side * aside, 0.5 * tall, -0.255), size) for side in (-1.0, 1.0)]
    if chance < BLIND:
        down = (2.2 * share - 0.2) * tall
        return [Box("blind", (0.0, tall - 0.5 * down, -0.255), (wide, down, 0.01))]
    return [Box("net", (0.0, 0.25 * tall, -0.255), (wide, 0.5 * tall, 0.01))]
