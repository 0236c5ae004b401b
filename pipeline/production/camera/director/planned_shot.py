"""Planned shot: what a shot shows, when and how large, before its view is chosen."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

ShotSize = Literal["wide", "medium", "close"]

LARGER: dict[ShotSize, ShotSize] = {"close": "medium", "medium": "wide"}
"""The size that shows more."""


@dataclass(frozen=True, slots=True)
class SizeRule:
    """How a shot of a size is taken.

    Attributes:
        room: distance, relative to the one at which the followed just fit into the frame.
        fov_deg: vertical field of view [degrees]; a long lens keeps a close camera out of the way.
        elevation_deg: of the camera over its target [degrees].
        blur: greatest blur of the depth of the followed, relative to the height of the frame; 0
            for a lens with which all is sharp.
        least_stop: least f-number; what is around stays to be recognised.
    """

    room: float
    fov_deg: float
    elevation_deg: float
    blur: float
    least_stop: float


SIZES: dict[ShotSize, SizeRule] = {
    "wide": SizeRule(1.1, 36.0, 12.0, 0.0, 16.0),
    "medium": SizeRule(1.5, 27.0, 8.0, 0.004, 2.8),
    "close": SizeRule(1.0, 20.0, 6.0, 0.008, 1.4),
}
"""Rules of all sizes."""

WIDE_ROOM = 2.2
"""Least room of a wide shot, relative to the distance at which one performer just fits."""

F_STOPS = (1.4, 2.0, 2.8, 4.0, 5.6, 8.0, 11.0, 16.0)
"""F-numbers that lenses have."""


@dataclass(frozen=True, slots=True)
class PlannedShot:
    """A shot before its view is chosen.

    Attributes:
        first: its first frame, from 0.
        end: the first frame after it.
        size: how much it shows.
        follow: performers that it follows; None for all.
        line: who act together in it, two; or one that travels; or nobody.
        reason: why it is there.
        is_event: whether it is made for an event.
        is_opening: whether it is the establishing shot, which shows all who act.
    """

    first: int
    end: int
    size: ShotSize
    follow: tuple[str, ...] | None
    line: tuple[str, ...]
    reason: str
    is_event: bool = False
    is_opening: bool = False

    def larger(self) -> PlannedShot | None:
        """Return the shot of the next size that shows more, None of a wide one."""
        return replace(self, size=LARGER[self.size]) if self.size in LARGER else None


def f_number(size: ShotSize, distance: float, depth: float) -> float | None:
    """Return the f-number with which the followed are sharp and what is behind them is not.

    A point at a distance d is shown by a lens of diameter A, focused at D, as a disc of the
    diameter A |d - D| / d in the plane of focus. The f-number is that of a sensor 24 mm high.

    Args:
        size: of the shot.
        distance: of the camera [m].
        depth: of the followed behind the plane of focus [m].
    """
    rule = SIZES[size]
    if rule.blur == 0.0:
        return None
    tangent = math.tan(math.radians(rule.fov_deg) / 2.0)
    diameter = rule.blur * 2.0 * distance * tangent * (distance + depth) / max(depth, 1e-6)
    wanted = 0.012 / tangent / diameter
    fitting = [stop for stop in F_STOPS if stop >= max(wanted, rule.least_stop)]
    return fitting[0] if fitting else F_STOPS[-1]
