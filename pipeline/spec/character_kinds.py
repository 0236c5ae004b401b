"""Character kinds: what characters there are, and the parts of people."""

from __future__ import annotations

from typing import Literal

PEOPLE = ("child", "adult")
"""Kinds that act."""

PARTS = (
    *("pelvis", "spine", "shoulders", "head"),
    *(f"{joint}_{side}" for joint in ("shoulder", "elbow", "hand") for side in "lr"),
    *(f"{joint}_{side}" for joint in ("hip", "knee", "foot") for side in "lr"),
)
"""Nodes that can be grabbed."""

HANDS = {"arm_l": 0, "arm_r": 1, "hand_l": 0, "hand_r": 1}
"""Limbs and nodes of people that are posed, and their side."""

Kind = Literal["child", "adult", "ragdoll", "ball", "merry-go-round", "box", "bench"]
"""Kinds of characters."""
