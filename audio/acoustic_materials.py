"""Acoustic material families, looked up by the words of a material's name.

The numbers are chosen by ear and by measurement of the result. Internal friction tan φ damps a
mode of frequency f by d = π f tan φ.

Source: van den Doel and Pai 1998.
"""

from __future__ import annotations

from dataclasses import dataclass

from audio.mode_shapes import BAR, BELL, MEMBRANE, PLATE, SHELL, ModeShape
from audio.names import normalized_name


@dataclass(frozen=True, slots=True)
class MaterialFamily:
    """Acoustic properties of a family of materials, both as the striker and as the ground.

    Attributes:
        shape: body whose modes ring.
        pitch: frequency of the lowest mode of a piece of 0.1 m [Hz].
        friction: internal friction tan φ.
        damping: of all modes, from air and grip [1/s].
        tilt: exponent by which higher modes are weaker.
        softness: contact time of an impact at 1 m/s with the hardest partner [ms].
        level: loudness relative to a wooden block [dB].
        instrument: General MIDI instrument of its notes.
        ground: frequency of the lowest mode where the material is the ground [Hz].
        grain_level: level of the grain noise relative to the ring [dB]; None for no grains.
        grain_band: of the grain noise [Hz].
        grain_decay: time in which the grain noise falls by 60 dB [s].
        grain_rate: grains a second while they settle; 0 for a smooth rustle.
    """

    shape: ModeShape
    pitch: float
    friction: float
    damping: float
    tilt: float
    softness: float
    level: float
    instrument: str
    ground: float = 400.0
    grain_level: float | None = None
    grain_band: tuple[float, float] = (500.0, 6000.0)
    grain_decay: float = 0.08
    grain_rate: float = 0.0


DEFAULT_FAMILY = "wood"

FAMILIES: dict[str, MaterialFamily] = {
    "chitin": MaterialFamily(SHELL, 1150, 0.020, 24, 0.7, 0.09, 0, "kalimba", 700),
    "bone": MaterialFamily(BAR, 1000, 0.016, 18, 0.8, 0.08, 1, "xylophone", 600),
    "wood": MaterialFamily(BAR, 620, 0.020, 14, 0.8, 0.14, 0, "marimba", 170),
    "stone": MaterialFamily(PLATE, 1700, 0.006, 30, 0.5, 0.05, 2, "woodblock", 1300),
    "brick": MaterialFamily(PLATE, 1150, 0.014, 36, 0.7, 0.09, 1, "woodblock", 800),
    "metal": MaterialFamily(PLATE, 900, 0.0009, 3, 0.4, 0.04, 3, "vibraphone", 260),
    "glass": MaterialFamily(BELL, 1900, 0.0016, 5, 0.4, 0.04, 1, "celesta", 900),
    "ice": MaterialFamily(
        BELL, 1300, 0.008, 12, 0.6, 0.06, 0, "glockenspiel", 420, -14, (3e3, 12e3), 0.05
    ),
    "plastic": MaterialFamily(SHELL, 700, 0.045, 20, 0.9, 0.16, -2, "clavinet", 320),
    "rubber": MaterialFamily(MEMBRANE, 190, 0.22, 18, 1.1, 0.70, -3, "slap bass 2", 120),
    "flesh": MaterialFamily(MEMBRANE, 170, 0.30, 30, 1.2, 0.80, -4, "melodic tom", 110),
    "cloth": MaterialFamily(
        MEMBRANE, 210, 0.40, 45, 1.2, 0.85, -9, "muted guitar", 130, -4, (300, 4e3), 0.06
    ),
    "soil": MaterialFamily(
        *(MEMBRANE, 210, 0.16, 24, 1.0, 0.45, -3, "melodic tom", 105),
        *(-5, (350, 4200), 0.11, 420),
    ),
    "gravel": MaterialFamily(
        *(PLATE, 1500, 0.02, 60, 0.6, 0.10, 0, "woodblock", 230),
        *(1, (1400, 9000), 0.20, 260),
    ),
    "sand": MaterialFamily(
        *(MEMBRANE, 180, 0.25, 60, 1.2, 0.60, -5, "melodic tom", 90),
        *(2, (1500, 9500), 0.16, 1800),
    ),
    "grass": MaterialFamily(
        *(MEMBRANE, 190, 0.25, 60, 1.2, 0.70, -6, "melodic tom", 95),
        *(0, (2200, 11000), 0.18, 700),
    ),
    "snow": MaterialFamily(
        *(MEMBRANE, 170, 0.30, 80, 1.3, 0.75, -6, "melodic tom", 80),
        *(3, (700, 3600), 0.24, 520),
    ),
    "water": MaterialFamily(
        *(MEMBRANE, 330, 0.06, 25, 1.0, 0.60, -3, "synth drum", 240),
        *(2, (600, 7000), 0.30, 160),
    ),
}

_FAMILY_BY_WORD: dict[str, str] = {
    **{name: name for name in FAMILIES},
    **dict.fromkeys(("shell", "carapace", "claw", "nail", "hoof", "horn", "beetle"), "chitin"),
    **dict.fromkeys(("ivory", "tooth", "skeleton", "antler", "ceramic", "porcelain"), "bone"),
    **dict.fromkeys(("oak", "pine", "bark", "timber", "plank", "log", "bamboo", "cork"), "wood"),
    **dict.fromkeys(("walnut", "ebony", "parquet"), "wood"),
    **dict.fromkeys(("rock", "granite", "marble", "slate", "boulder", "basalt"), "stone"),
    **dict.fromkeys(
        ("concrete", "clay", "tile", "tiles", "terracotta", "plaster", "asphalt"), "brick"
    ),
    **dict.fromkeys(("steel", "iron", "copper", "brass", "gold", "silver", "aluminium"), "metal"),
    **dict.fromkeys(("aluminum", "chrome", "tin", "bronze", "lead", "rust"), "metal"),
    **dict.fromkeys(("crystal", "diamond", "bottle"), "glass"),
    **dict.fromkeys(("vinyl", "acrylic", "resin", "nylon"), "plastic"),
    **dict.fromkeys(("latex", "foam", "silicone"), "rubber"),
    **dict.fromkeys(("skin", "fur", "leather", "hide", "paw", "body", "lips", "iris"), "flesh"),
    **dict.fromkeys(("felt", "wool", "fabric", "velvet", "carpet", "silk"), "cloth"),
    **dict.fromkeys(("plush", "denim", "linen", "cotton"), "cloth"),
    **dict.fromkeys(("earth", "dirt", "mud", "ground", "loam", "peat", "dust"), "soil"),
    **dict.fromkeys(("pebble", "pebbles", "scree", "rubble", "shingle"), "gravel"),
    **dict.fromkeys(("dune", "beach", "salt", "ash"), "sand"),
    **dict.fromkeys(("meadow", "moss", "leaf", "leaves", "hay", "straw", "lawn"), "grass"),
    **dict.fromkeys(("puddle", "sea", "lake"), "water"),
}


def family_of(material: str) -> MaterialFamily:
    """Return the family of a material, see `family_name`."""
    return FAMILIES[family_name(material)]


def family_name(material: str) -> str:
    """Return the family of the last known word of a material's name, or wood.

    Args:
        material: name in the scene, such as "green chitin" or "stone dust"; may be empty.
    """
    words = normalized_name(material).split()
    known = [_FAMILY_BY_WORD[word] for word in words if word in _FAMILY_BY_WORD]
    return known[-1] if known else DEFAULT_FAMILY
