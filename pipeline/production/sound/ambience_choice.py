"""Ambience choice: the ambient sound of a scene, by its ground, its hour and its weather."""

from __future__ import annotations

from audio.ambience import AMBIENCES, Ambience
from pipeline.production.scenery.scatter_choice import is_drowned
from pipeline.production.surroundings.choice import Choice
from pipeline.spec.group import Group
from pipeline.spec.scene import Scene
from render.lights.sun_position import light_elevation_deg

STILL, STORM = 1.0, 16.0
"""Speeds of the wind at which it is not heard, and at which it is loudest [m/s]."""

LEAVES = {"forest": 0.7, "hills": 0.3, "plain": 0.25, "mountains": 0.2}
"""How much of what the wind moves is leaves, by surroundings."""

BIRDS = {"forest": 0.9, "hills": 0.6, "plain": 0.5, "mountains": 0.35, "sea": 0.2}

DRY = frozenset({"sand", "soil", "rock", "gravel"})
"""Textures of ground on which little lives."""

LOW_SUN, DARK = 6.0, -5.0
"""Heights of the sun between which birds sing most, and below which they sleep [degrees]."""


def ambience_of(scene: Scene) -> Ambience | None:
    """Return the ambience of a scene, by its author's word or its looks; None for silence."""
    word = scene.sound.ambience
    if word == "none":
        return None
    if word != "auto":
        return AMBIENCES[word]
    if is_drowned(scene):
        return AMBIENCES["underwater"]
    around = Choice.of(scene)
    light = scene.light
    if scene.terrain.edging == "room" or (around.kind == "none" and light.studio is not None):
        return AMBIENCES["room"]
    weather = light.weather
    wind = min(max((weather.wind - STILL) / (STORM - STILL), 0.15), 1.0)
    texture = scene.material(scene.terrain.material).texture
    height = light_elevation_deg(light)
    height = 90.0 if height is None else height
    life = 0.3 if texture in DRY else 1.0
    if scene.terrain.edging == "houses":
        life *= 0.5
    if weather.snow > 0.0 or texture in ("snow", "ice"):
        life = 0.0
    if weather.rain > 0.1:
        life *= 0.15
    birds = BIRDS.get(around.kind, 0.15) * life
    birds *= 1.0 if height > LOW_SUN else 1.3 if height > DARK else 0.0
    warm = 0.8 if height < DARK else 0.35 if height < LOW_SUN else 0.25 * (texture in DRY)
    is_sea = around.kind == "sea"
    has_stream = scene.terrain.water is not None and not is_sea
    return Ambience(
        wind=wind,
        leaves=LEAVES.get(around.kind, 0.0) * min(2.0 * wind, 1.0),
        birds=min(birds, 1.0),
        crickets=warm * (life > 0.2 or texture in DRY) * (weather.rain <= 0.1) * (life > 0.0),
        rain=weather.rain**0.5,
        surf=0.9 * is_sea,
        stream=0.5 * has_stream,
        fire=0.8 * _burns(scene),
    )


def _burns(scene: Scene) -> bool:
    """Return whether there is a fire in a scene, not its smoke alone."""
    groups = (member for member in scene.cast if isinstance(member, Group))
    return any(member.group.rule == "fire" and member.material != "smoke" for member in groups)
