"""Configuration models of materials, light, camera and film, a part of the scene language.

They are independent of Mitsuba, and the renderer uses every key.
"""

from render.config.camera import Camera, Cuts, View, cuts
from render.config.film import Film, FullFilm
from render.config.light import LIGHTS, Clouds, Hdr, Lamp, Light, Moon, Spot, Studio, Sun, light
from render.config.look import Look
from render.config.material import MATERIALS, Material, material
from render.config.water import Water
from render.config.weather import Weather

__all__ = [
    "LIGHTS",
    "MATERIALS",
    "Camera",
    "Clouds",
    "Cuts",
    "Film",
    "FullFilm",
    "Hdr",
    "Lamp",
    "Light",
    "Look",
    "Material",
    "Moon",
    "Spot",
    "Studio",
    "Sun",
    "View",
    "Water",
    "Weather",
    "cuts",
    "light",
    "material",
]
