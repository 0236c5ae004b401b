"""Tints: colours of parts of a person that are not of their material's colour."""

from __future__ import annotations

import numpy as np

from pipeline.simulation.spatial import Array
from render.color import linear
from render.config import MATERIALS

LIP, HOLLOW, BLUSH, IRIS, LIMBUS, PUPIL, TOOTH, SOLE, LASH, SHEEN, PALE, BEARD, SOCK = range(1, 14)
"""Tints of vertices, the rows of `tint_colors`; 0 is the colour of the material."""

LIPS = {
    "fair skin": "lips",
    "skin": "lips",
    "tan skin": "lips",
    "brown skin": "dark lips",
    "dark skin": "dark lips",
}
"""Skin material -> lip material."""

BLUSH_SHADE = np.array([1.02, 0.76, 0.72])
"""Colour of cheeks in that of the skin."""

PALE_SHADE = np.array([1.14, 1.10, 1.06])
"""Colour of the thin skin below eyes in that of the skin."""

BEARD_SHADE = 0.8
"""Colour of a beard in that of the hair: hair of a face is darker."""

HOLLOW_COLOR, PUPIL_COLOR = (0.035, 0.008, 0.007), (0.002, 0.002, 0.002)
TOOTH_COLOR, LASH_COLOR = (0.66, 0.62, 0.53), (0.012, 0.008, 0.006)
"""Colours of the inside of a mouth, of pupils, teeth and lashes, linear."""

SHEEN_COLOR = (0.36, 0.32, 0.28)
"""Colour of the gloss of hair, linear: that of the sky, whatever the hair's is."""

LIMBUS_SHADE = 0.3
"""Colour of the rim of an iris, in that of the iris."""

RUBBER, GUM, HEEL = (0.52, 0.50, 0.46), (0.24, 0.13, 0.06), (0.022, 0.015, 0.011)
"""Colours of soles and laces, linear: pale rubber, brown rubber, and leather."""

PALE_SOCK, GREY_SOCK, DARK_SOCK = (0.56, 0.55, 0.52), (0.10, 0.11, 0.13), (0.03, 0.032, 0.038)
"""Colours of socks, linear."""

SHOE_TRIMS = {
    "leather": (HEEL, DARK_SOCK),
    "black leather": (HEEL, DARK_SOCK),
    "white cloth": (GUM, GREY_SOCK),
}
"""Colours of the sole and laces, and of socks, by the material of shoes; none is that of the shoe.
"""


def tint_colors(skin: str, iris: str, shoes: str, hair: str) -> Array:
    """Return the linear colours (14, 3) of the tints of a person.

    Args:
        skin: material.
        iris: material.
        shoes: material.
        hair: material.
    """
    own, lip, eye = (linear(MATERIALS[name].color) for name in (skin, LIPS.get(skin, "lips"), iris))
    mouth = (lip, HOLLOW_COLOR, BLUSH_SHADE * own)
    eyes = (eye, LIMBUS_SHADE * eye, PUPIL_COLOR)
    sole, sock = SHOE_TRIMS.get(shoes, (RUBBER, PALE_SOCK))
    face = (PALE_SHADE * own, BEARD_SHADE * linear(MATERIALS[hair].color))
    return np.array((own, *mouth, *eyes, TOOTH_COLOR, sole, LASH_COLOR, SHEEN_COLOR, *face, sock))
