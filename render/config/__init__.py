"""The author's words for materials, light, camera and film.

They are part of the scene language and know nothing of Mitsuba: no word here is
one that the renderer would then ignore.
"""

from render.config.camera import Camera, Cuts, View, cuts
from render.config.film import Film, FullFilm
from render.config.lamp import Lamp, Spot
from render.config.light import LIGHTS, Hdr, Light, Moon, Studio, Sun, light
from render.config.material import MATERIALS, Material, material

__all__ = [
    "LIGHTS",
    "MATERIALS",
    "Camera",
    "Cuts",
    "Film",
    "FullFilm",
    "Hdr",
    "Lamp",
    "Light",
    "Material",
    "Moon",
    "Spot",
    "Studio",
    "Sun",
    "View",
    "cuts",
    "light",
    "material",
]
