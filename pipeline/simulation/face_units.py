"""Face units: the muscles of a face as numbers, after the action units of the FACS, and hands.

A unit is 0 at rest and 1 at its full action. Gaze has two more: turns of the eyes against the head.
The shapes of hands follow them.

Source: Ekman, Friesen and Hager 2002.
"""

from __future__ import annotations

UNITS = (
    "brow_inner_up",  # AU 1
    "brow_outer_up",  # AU 2
    "brow_down",  # AU 4
    "lids_wide",  # AU 5
    "lids_tight",  # AU 7
    "cheek_up",  # AU 6
    "lip_up",  # AU 9 and 10
    "smile",  # AU 12
    "corner_down",  # AU 15
    "stretch",  # AU 20
    "press",  # AU 24
    "jaw",  # AU 25 and 26
    "blink",  # AU 45
)
"""Names of the units, in the order of their numbers."""

GAZE = ("gaze_left", "gaze_up")
"""Turns of the eyes against the head [rad], behind the units."""

HAND_SHAPES = ("grip", "fist", "flat")
"""Shapes that a hand takes in place of being at ease."""

HANDS = tuple(f"{shape}_{side}" for shape in HAND_SHAPES for side in "lr")
"""Units of both hands, behind the gaze."""

COLUMNS = (*UNITS, *GAZE, *HANDS)
"""All numbers of a face and of hands."""

EYE_TURN = len(UNITS)
"""Target of vertices that turn with an eye; their offsets are from its middle."""


def hand_unit(shape: str, side: str) -> int:
    """Return the number of a hand's unit; `side` is "l" or "r"."""
    return COLUMNS.index(f"{shape}_{side}")
