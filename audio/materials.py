"""Families of materials that sound alike, found by the words in a material's name.

The numbers are chosen by ear and by measurement of the result. Internal friction follows
Source: van den Doel and Pai 1998 (a material is heard by tan φ, d = π f tan φ).
"""

from __future__ import annotations

from dataclasses import dataclass

from audio.names import folded
from audio.shapes import BAR, BELL, MEMBRANE, PLATE, SHELL, Shape


@dataclass(frozen=True, slots=True)
class Family:
    """How a family of materials sounds, as what strikes and as what is struck.

    Attributes:
        shape: of a piece of it, whose modes ring.
        pitch: frequency of the lowest mode of a piece of 0.1 m [Hz].
        friction: tan φ, internal friction.
        damping: of all modes, from air and grip [1/s].
        tilt: exponent by which higher modes are weaker.
        softness: contact time of a blow at 1 m/s with the hardest partner [ms].
        level: loudness beside a wooden block [dB].
        noise: level of the grains under a blow, beside the ring [dB]; None for no grains.
        band: of the grains [Hz].
        settle: time in which the grains die away by 60 dB [s].
        grains: grains a second while they settle; 0 for a smooth rustle.
        ground: frequency of the lowest mode where the material is the ground [Hz].
        instrument: of General MIDI that plays its notes.
    """

    shape: Shape
    pitch: float
    friction: float
    damping: float
    tilt: float
    softness: float
    level: float
    instrument: str
    ground: float = 400.0
    noise: float | None = None
    band: tuple[float, float] = (500.0, 6000.0)
    settle: float = 0.08
    grains: float = 0.0


FAMILIES: dict[str, Family] = {
    "chitin": Family(SHELL, 1150, 0.020, 24, 0.7, 0.09, 0, "kalimba", 700),
    "bone": Family(BAR, 1000, 0.016, 18, 0.8, 0.08, 1, "xylophone", 600),
    "wood": Family(BAR, 620, 0.020, 14, 0.8, 0.14, 0, "marimba", 170),
    "stone": Family(PLATE, 1700, 0.006, 30, 0.5, 0.05, 2, "woodblock", 1300),
    "brick": Family(PLATE, 1150, 0.014, 36, 0.7, 0.09, 1, "woodblock", 800),
    "metal": Family(PLATE, 900, 0.0009, 3, 0.4, 0.04, 3, "vibraphone", 260),
    "glass": Family(BELL, 1900, 0.0016, 5, 0.4, 0.04, 1, "celesta", 900),
    "ice": Family(BELL, 1300, 0.008, 12, 0.6, 0.06, 0, "glockenspiel", 420, -14, (3e3, 12e3), 0.05),
    "plastic": Family(SHELL, 700, 0.045, 20, 0.9, 0.16, -2, "clavinet", 320),
    "rubber": Family(MEMBRANE, 190, 0.22, 18, 1.1, 0.70, -3, "slap bass 2", 120),
    "flesh": Family(MEMBRANE, 170, 0.30, 30, 1.2, 0.80, -4, "melodic tom", 110),
    "cloth": Family(
        MEMBRANE, 210, 0.40, 45, 1.2, 0.85, -9, "muted guitar", 130, -4, (300, 4e3), 0.06
    ),
    "soil": Family(
        *(MEMBRANE, 210, 0.16, 24, 1.0, 0.45, -3, "melodic tom", 105),
        *(-5, (350, 4200), 0.11, 420),
    ),
    "gravel": Family(
        *(PLATE, 1500, 0.02, 60, 0.6, 0.10, 0, "woodblock", 230),
        *(1, (1400, 9000), 0.20, 260),
    ),
    "sand": Family(
        *(MEMBRANE, 180, 0.25, 60, 1.2, 0.60, -5, "melodic tom", 90),
        *(2, (1500, 9500), 0.16, 1800),
    ),
    "grass": Family(
        *(MEMBRANE, 190, 0.25, 60, 1.2, 0.70, -6, "melodic tom", 95),
        *(0, (2200, 11000), 0.18, 700),
    ),
    "snow": Family(
        *(MEMBRANE, 170, 0.30, 80, 1.3, 0.75, -6, "melodic tom", 80),
        *(3, (700, 3600), 0.24, 520),
    ),
    "water": Family(
        *(MEMBRANE, 330, 0.06, 25, 1.0, 0.60, -3, "synth drum", 240),
        *(2, (600, 7000), 0.30, 160),
    ),
}

_WORDS: dict[str, str] = {
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
    **dict.fromkeys(("skin", "fur", "leather", "hide", "paw", "body", "lips"), "flesh"),
    **dict.fromkeys(("felt", "wool", "fabric", "velvet", "carpet", "silk"), "cloth"),
    **dict.fromkeys(("plush", "denim", "linen", "cotton"), "cloth"),
    **dict.fromkeys(("earth", "dirt", "mud", "ground", "loam", "peat", "dust"), "soil"),
    **dict.fromkeys(("pebble", "pebbles", "scree", "rubble", "shingle"), "gravel"),
    **dict.fromkeys(("dune", "beach", "salt", "ash"), "sand"),
    **dict.fromkeys(("meadow", "moss", "leaf", "leaves", "hay", "straw", "lawn"), "grass"),
    **dict.fromkeys(("puddle", "sea", "lake"), "water"),
}


def family_of(material: str, otherwise: str) -> Family:
    """Return the family of a material, see `family_name`."""
    return FAMILIES[family_name(material, otherwise)]


def family_name(material: str, otherwise: str) -> str:
    """Return the name of a material's family; its last known word counts ("stone dust" is dust).

    Args:
        material: an author's name, such as "green chitin"; may be empty.
        otherwise: the family of a material that has no known word.
    """
    known = [_WORDS[word] for word in folded(material).split() if word in _WORDS]
    return known[-1] if known else otherwise
