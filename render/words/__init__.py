"""The author's words for materials, light, camera and film.

They are part of the scene language and know nothing of Mitsuba: no word here is
one that the renderer would then ignore.
"""

from render.words.camera import Camera, Cuts, View, cuts
from render.words.film import Film, FullFilm
from render.words.lamp import Lamp, Spot
from render.words.light import LIGHTS, Hdr, Light, Moon, Studio, Sun, light
from render.words.material import MATERIALS, Material, material

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
