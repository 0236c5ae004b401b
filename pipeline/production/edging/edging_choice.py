"""Edging choice: how a floor ends and what stands along it, by its material and surroundings."""

from __future__ import annotations

from dataclasses import dataclass

from pipeline.production.surroundings.choice import Choice
from pipeline.spec.scene import Scene

PIECES = {"plaster": 4, "tiles": 6, "checker": 6}
"""Number of pieces along a tile of the pattern, by the texture of paving."""

SLAB_FACTOR = 1.8
"""Factor on the scale of plaster that is laid in slabs."""

BY_SURROUNDINGS = {
    "paving": {"forest": "hedge", "plain": "hedge", "sea": "wall", "dunes": "wall"},
    "deck": {"sea": "railing", "forest": "planters", "plain": "planters", "dunes": "railing"},
}
"""What stands along paving and along decks, by surroundings."""

HOUSES = ("houses", "house", "school")

ON_GROUND = ("fence", "wall", *HOUSES)
"""What is built on natural ground, too."""

OTHERWISE = {"paving": "wall", "deck": "planters"}


@dataclass(frozen=True)
class EdgingChoice:
    """How a floor ends.

    Attributes:
        floor: `paving` of slabs that breaks up at its border, a `deck` of boards, or natural
            `ground`.
        along: what stands along it, a word of `pipeline.spec.terrain.base.Edging`.
        piece: side of a slab [m].
    """

    floor: str
    along: str
    piece: float

    @staticmethod
    def of(scene: Scene, around: Choice) -> EdgingChoice | None:
        """Return the choice of a scene's author, or what suits the scene; None for no edging."""
        word: str = scene.terrain.edging
        if word in ON_GROUND and around.joins != "platform" and around.kind != "none":
            return EdgingChoice("ground", word, 1.0)
        if around.joins != "platform" or word == "none" or scene.terrain.show_forbidden:
            return None
        material = scene.material(scene.terrain.material)
        floor = "paving" if material.texture in PIECES else "deck"
        if word == "auto":
            word = BY_SURROUNDINGS[floor].get(around.kind, OTHERWISE[floor])
        factor = SLAB_FACTOR if material.texture == "plaster" else 1.0
        piece = factor * material.texture_scale / PIECES.get(material.texture, 4)
        return EdgingChoice(floor, word, piece)
