"""Natural ground: whether a terrain may be drawn otherwise than it was walked on."""

from __future__ import annotations

from pipeline.production.surroundings.choice import NATURAL
from pipeline.simulation.take import TerrainRecord
from pipeline.spec.scene import Scene
from pipeline.spec.terrain.kinds import StonesTerrain


def is_natural_ground(terrain: TerrainRecord, scene: Scene) -> bool:
    """Return whether a terrain is of soil, rock, grass and the like, and shown as a place.

    Forbidden zones are shown on the true ground.
    """
    texture = scene.material(terrain.material).texture
    return texture in NATURAL and not scene.terrain.show_forbidden


def natural_pit(terrain: TerrainRecord, scene: Scene) -> StonesTerrain | None:
    """Return the author's terrain if it is a pit of stones in water, of natural ground."""
    author = scene.terrain
    if not isinstance(author, StonesTerrain) or author.water is None:
        return None
    return author if is_natural_ground(terrain, scene) else None
