"""Character: a body of nodes and links, of which some walk, reach and hug (Horswill 2008)."""

from __future__ import annotations

from typing import Literal

PEOPLE = ("child", "adult")
"""Those who act."""

Kind = Literal["child", "adult", "ragdoll", "ball", "merry-go-round", "box", "bench"]
"""What there is."""
