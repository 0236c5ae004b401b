"""Configuration models of materials, light, camera and film, a part of the scene language.

They are independent of Mitsuba, and the renderer uses every key.
"""

from render.config.camera import Camera, Cuts, View, cuts
from render.config.film import Film, FullFilm
from render.config.light import LIGHTS, Hdr, Lamp, Light, Moon, Spot, Studio, Sun, light
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
