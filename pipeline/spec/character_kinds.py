"""Character kinds: what characters there are, and the parts of people."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

PEOPLE = ("child", "adult")
"""Kinds that act."""

WEARERS = (*PEOPLE, "ragdoll")
"""Kinds that wear clothes."""

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

KIND_TEXTS: Mapping[Kind, str] = {
    "child": "A child, 1.15 m tall, which follows orders, or acts by itself.",
    "adult": "An adult, 1.72 m tall, who follows orders, or acts by themselves.",
    "ragdoll": "A doll, 0.55 m tall, limp.",
    "ball": "A playground's ball, 0.24 m wide.",
    "merry-go-round": "A merry-go-round, 2.6 m wide, which can be pushed round.",
    "box": "A box, 0.5 m long, wide and high.",
    "bench": "A bench, 1.5 m long and 0.42 m high, to sit on.",
}
"""Descriptions of characters, at `scale: 1`."""
