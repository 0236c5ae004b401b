"""Character: a body of nodes and links, of which some walk, reach and hug (Horswill 2008)."""

from __future__ import annotations

from typing import Literal

PEOPLE = ("child", "adult")
"""Those who act."""

JOINTED = (*PEOPLE, "ragdoll")
"""Those who have the joints of people."""

PARTS = (
    *("pelvis", "spine", "shoulders", "head"),
    *(f"{joint}_{side}" for joint in ("shoulder", "elbow", "hand") for side in "lr"),
    *(f"{joint}_{side}" for joint in ("hip", "knee", "foot") for side in "lr"),
)
"""Of these, what can be taken."""

Kind = Literal["child", "adult", "ragdoll", "ball", "merry-go-round", "box", "bench"]
"""What there is."""
