"""Editing pace: how long the shots of a film are.

Source: Bordwell 2006 (average shot lengths). Murch 2001 (a cut comes before its event).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from render.config.camera import Pace

LEAST_SHOT_S = 1.5
"""Duration below which no shot can be read [s]."""

LEAST_CUT_FILM_S = 4.0
"""Duration below which a film is one shot [s]."""


@dataclass(frozen=True, slots=True)
class EditingPace:
    """Durations of the shots of a film [s].

    Attributes:
        opening: of the establishing shot.
        least: of any other.
        usual: of one that is made for no event.
        before: from the cut to the event that it is made for.
        after: from that event to the next cut, at least.
        longest: of a shot that is made for an event.
    """

    opening: float
    least: float
    usual: float
    before: float
    after: float
    longest: float


PACES: Mapping[Pace, EditingPace] = {
    "calm": EditingPace(3.5, 2.5, 5.5, 0.6, 1.6, 5.0),
    "natural": EditingPace(2.6, 1.8, 3.6, 0.5, 1.2, 3.5),
    "quick": EditingPace(1.8, 1.5, 2.2, 0.4, 1.0, 2.5),
}
"""The paces by name."""
