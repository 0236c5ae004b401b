"""Acoustic material families, looked up by the words of a material's name.

`SOLIDS` holds what physics asks for: stiffness, density and loss. A loss factor η damps a mode of
frequency f by d = π f η. The rest of a family (instrument, ground, grains) is chosen by ear.

Source: van den Doel and Pai 1998; Cremer, Heckl and Petersson 2005, table 4.3, and Ashby 2011 for
stiffness, density and loss; Forest Products Laboratory 2010 for woods along the grain; Currey 2002
for bone and horn; Schulson and Duval 2009 for ice; Das 2011 for soils under small strain; Fung
1993 for soft tissue. Loss in soft and loose matter is an order of magnitude.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

from audio.body_shape import BodyShape, ShapeKind
from audio.mode_shapes import BAR, BELL, MEMBRANE, PLATE, SHELL, ModeShape
from audio.names import normalized_name


@dataclass(frozen=True, slots=True)
class Solid:
    """Elastic properties of a material.

    Attributes:
        young: Young's modulus [Pa]; of a stretched skin its stress.
        density: [kg/m³].
        poisson: Poisson's ratio.
        loss: loss factor η.
    """

    young: float
    density: float
    poisson: float
    loss: float


SOLIDS: dict[str, Solid] = {
    "chitin": Solid(6e9, 1300, 0.30, 0.02),
    "bone": Solid(17e9, 1900, 0.30, 0.012),
    "horn": Solid(4e9, 1300, 0.35, 0.03),
    "wood": Solid(11e9, 650, 0.35, 0.010),
    "oak": Solid(12.3e9, 700, 0.35, 0.010),
    "pine": Solid(9e9, 450, 0.35, 0.009),
    "walnut": Solid(11.6e9, 600, 0.35, 0.008),
    "ebony": Solid(17e9, 1100, 0.35, 0.007),
    "bamboo": Solid(15e9, 700, 0.35, 0.010),
    "cork": Solid(20e6, 180, 0.10, 0.15),
    "stone": Solid(50e9, 2700, 0.25, 0.004),
    "granite": Solid(55e9, 2700, 0.25, 0.004),
    "marble": Solid(60e9, 2700, 0.25, 0.003),
    "slate": Solid(70e9, 2750, 0.25, 0.003),
    "brick": Solid(15e9, 1900, 0.20, 0.015),
    "concrete": Solid(28e9, 2400, 0.20, 0.006),
    "terracotta": Solid(18e9, 1900, 0.20, 0.008),
    "tiles": Solid(45e9, 2300, 0.22, 0.005),
    "plaster": Solid(5e9, 1200, 0.25, 0.006),
    "asphalt": Solid(3e9, 2300, 0.35, 0.15),
    "porcelain": Solid(70e9, 2400, 0.22, 0.002),
    "metal": Solid(200e9, 7850, 0.29, 0.0004),
    "iron": Solid(110e9, 7200, 0.26, 0.0015),
    "copper": Solid(120e9, 8900, 0.34, 0.002),
    "brass": Solid(104e9, 8500, 0.35, 0.0007),
    "bronze": Solid(105e9, 8700, 0.34, 0.0005),
    "gold": Solid(78e9, 19300, 0.42, 0.0005),
    "silver": Solid(76e9, 10500, 0.37, 0.0005),
    "aluminium": Solid(70e9, 2700, 0.34, 0.0003),
    "tin": Solid(45e9, 7300, 0.36, 0.004),
    "lead": Solid(16e9, 11300, 0.44, 0.02),
    "glass": Solid(70e9, 2500, 0.22, 0.0012),
    "crystal": Solid(60e9, 3000, 0.22, 0.0007),
    "ice": Solid(9.3e9, 917, 0.33, 0.008),
    "plastic": Solid(2.4e9, 1050, 0.38, 0.02),
    "acrylic": Solid(3.2e9, 1190, 0.38, 0.03),
    "vinyl": Solid(2.8e9, 1380, 0.40, 0.02),
    "cardboard": Solid(1.5e9, 250, 0.25, 0.06),
    "drumhead": Solid(18e6, 1380, 0.38, 0.01),
    "rubber": Solid(10e6, 1100, 0.48, 0.15),
    "leather": Solid(80e6, 900, 0.40, 0.20),
    "flesh": Solid(0.3e6, 1050, 0.48, 0.35),
    "cloth": Solid(1e6, 300, 0.20, 0.40),
    "soil": Solid(30e6, 1700, 0.30, 0.16),
    "gravel": Solid(150e6, 1800, 0.25, 0.12),
    "sand": Solid(40e6, 1600, 0.30, 0.20),
    "grass": Solid(4e6, 1300, 0.30, 0.25),
    "snow": Solid(2e6, 300, 0.20, 0.30),
    "water": Solid(0.5e6, 1000, 0.45, 0.06),
}
"""By family, and by single words whose material differs from that of their family."""

_SOLID_BY_WORD: dict[str, str] = {
    **{name: name for name in SOLIDS},
    **dict.fromkeys(("hoof", "claw", "nail"), "horn"),
    **dict.fromkeys(("clay", "tile"), "terracotta"),
    **dict.fromkeys(("ceramic", "china", "stoneware"), "porcelain"),
    **dict.fromkeys(("chrome", "steel"), "metal"),
    **dict.fromkeys(("aluminum",), "aluminium"),
    **dict.fromkeys(("hide",), "leather"),
    **dict.fromkeys(("carton", "paper"), "cardboard"),
}

# A vessel is at most as many diameters tall, or heights wide; what is more slender is solid.
_MOST_SLENDER = 2.5

_USUAL_SHAPES: dict[str, tuple[ShapeKind, float, float]] = {
    "wood": ("box", 0.3, 0.15),
    "bone": ("cylinder", 0.2, 0.2),
    "stone": ("ellipsoid", 0.8, 0.6),
    "brick": ("box", 0.5, 0.3),
    "metal": ("box", 0.5, 0.02),
    "glass": ("vessel", 1.2, 0.02),
    "porcelain": ("vessel", 1.1, 0.05),
    "cardboard": ("box", 0.8, 0.02),
    "drumhead": ("membrane", 1.0, 0.001),
    "plastic": ("box", 0.6, 0.04),
    "ice": ("box", 0.7, 0.15),
}


@dataclass(frozen=True, slots=True)
class MaterialFamily:
    """How a family of materials sounds beside its stiffness, density and loss.

    Attributes:
        shape: modes of the ground.
        damping: of the ground's modes [1/s].
        tilt: exponent by which higher modes of the ground are weaker.
        level: loudness relative to a wooden block [dB].
        instrument: General MIDI instrument of its notes.
        ground: frequency of the lowest mode where the material is the ground [Hz].
        grain_level: level of the grain noise relative to the ring [dB]; None for no grains.
        grain_band: of the grain noise [Hz].
        grain_decay: time in which the grain noise falls by 60 dB [s].
        grain_rate: grains a second while they settle; 0 for a smooth rustle.
    """

    shape: ModeShape
    damping: float
    tilt: float
    level: float
    instrument: str
    ground: float = 400.0
    grain_level: float | None = None
    grain_band: tuple[float, float] = (500.0, 6000.0)
    grain_decay: float = 0.08
    grain_rate: float = 0.0


DEFAULT_FAMILY = "wood"

FAMILIES: dict[str, MaterialFamily] = {
    "chitin": MaterialFamily(SHELL, 24, 0.7, 0, "kalimba", 700),
    "bone": MaterialFamily(BAR, 18, 0.8, 1, "xylophone", 600),
    "wood": MaterialFamily(BAR, 14, 0.8, 0, "marimba", 170),
    "stone": MaterialFamily(PLATE, 30, 0.5, 2, "woodblock", 1300),
    "brick": MaterialFamily(PLATE, 36, 0.7, 1, "woodblock", 800),
    "metal": MaterialFamily(PLATE, 3, 0.4, 3, "vibraphone", 260),
    "glass": MaterialFamily(BELL, 5, 0.4, 1, "celesta", 900),
    "ice": MaterialFamily(BELL, 12, 0.6, 0, "glockenspiel", 420, -14, (3e3, 12e3), 0.05),
    "porcelain": MaterialFamily(BELL, 30, 0.5, 1, "tubular bells", 1200),
    "cardboard": MaterialFamily(PLATE, 40, 0.9, -4, "taiko drum", 160),
    "plastic": MaterialFamily(SHELL, 20, 0.9, -2, "clavinet", 320),
    "rubber": MaterialFamily(MEMBRANE, 18, 1.1, -3, "slap bass 2", 120),
    "flesh": MaterialFamily(MEMBRANE, 30, 1.2, -4, "melodic tom", 110),
    "cloth": MaterialFamily(MEMBRANE, 45, 1.2, -9, "muted guitar", 130, -4, (300, 4e3), 0.06),
    "soil": MaterialFamily(
        *(MEMBRANE, 24, 1.0, -3, "melodic tom", 105),
        *(-5, (350, 4200), 0.11, 420),
    ),
    "gravel": MaterialFamily(
        *(PLATE, 60, 0.6, 0, "woodblock", 230),
        *(1, (1400, 9000), 0.20, 260),
    ),
    "sand": MaterialFamily(
        *(MEMBRANE, 60, 1.2, -5, "melodic tom", 90),
        *(2, (1500, 9500), 0.16, 1800),
    ),
    "grass": MaterialFamily(
        *(MEMBRANE, 60, 1.2, -6, "melodic tom", 95),
        *(0, (2200, 11000), 0.18, 700),
    ),
    "snow": MaterialFamily(
        *(MEMBRANE, 80, 1.3, -6, "melodic tom", 80),
        *(3, (700, 3600), 0.24, 520),
    ),
    "water": MaterialFamily(
        *(MEMBRANE, 25, 1.0, -3, "synth drum", 240),
        *(2, (600, 7000), 0.30, 160),
    ),
}

_FAMILY_BY_WORD: dict[str, str] = {
    **{name: name for name in FAMILIES},
    **dict.fromkeys(("shell", "carapace", "claw", "nail", "hoof", "horn", "beetle"), "chitin"),
    **dict.fromkeys(("ivory", "tooth", "skeleton", "antler"), "bone"),
    **dict.fromkeys(("oak", "pine", "bark", "timber", "plank", "log", "bamboo", "cork"), "wood"),
    **dict.fromkeys(("walnut", "ebony", "parquet"), "wood"),
    **dict.fromkeys(("rock", "granite", "marble", "slate", "boulder", "basalt"), "stone"),
    **dict.fromkeys(
        ("concrete", "clay", "tile", "tiles", "terracotta", "plaster", "asphalt"), "brick"
    ),
    **dict.fromkeys(("steel", "iron", "copper", "brass", "gold", "silver", "aluminium"), "metal"),
    **dict.fromkeys(("aluminum", "chrome", "tin", "bronze", "lead", "rust"), "metal"),
    **dict.fromkeys(("crystal", "diamond", "bottle"), "glass"),
    **dict.fromkeys(("ceramic", "china", "stoneware"), "porcelain"),
    **dict.fromkeys(("carton", "paper"), "cardboard"),
    **dict.fromkeys(("drumhead",), "flesh"),
    **dict.fromkeys(("vinyl", "acrylic", "resin", "nylon"), "plastic"),
    **dict.fromkeys(("latex", "foam", "silicone"), "rubber"),
    **dict.fromkeys(("skin", "fur", "leather", "hide", "scales", "paw", "body"), "flesh"),
    **dict.fromkeys(("lips", "iris"), "flesh"),
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


@lru_cache(maxsize=1024)
def family_name(material: str) -> str:
    """Return the family of the last known word of a material's name, or wood.

    Args:
        material: name in the scene, such as "green chitin" or "stone dust"; may be empty.
    """
    words = normalized_name(material).split()
    known = [_FAMILY_BY_WORD[word] for word in words if word in _FAMILY_BY_WORD]
    return known[-1] if known else DEFAULT_FAMILY


@lru_cache(maxsize=1024)
def solid_name(material: str) -> str:
    """Return the row of `SOLIDS` of a material: the last word that has one, or its family."""
    words = normalized_name(material).split()
    known = [w for w in words if w in _SOLID_BY_WORD or w in _FAMILY_BY_WORD]
    if not known:
        return DEFAULT_FAMILY
    return _SOLID_BY_WORD.get(known[-1]) or _FAMILY_BY_WORD[known[-1]]


@lru_cache(maxsize=1024)
def acoustic_name(material: str) -> str:
    """Return the name of a material without what is not heard, such as its colour."""
    name = solid_name(material)
    is_same = solid_name(name) == name and family_name(name) == family_name(material)
    return name if is_same else material


def solid_of(material: str) -> Solid:
    """Return the elastic properties of a material, see `solid_name`."""
    return SOLIDS[solid_name(material)]


def shape_in_material(material: str, shape: BodyShape) -> BodyShape:
    """Return the shape of a body of a material: what is round and upright of glass is a vessel."""
    usual = usual_shape(material, 1.0)
    upright = shape.kind == "cylinder" and shape.width < _MOST_SLENDER * shape.thickness
    if usual.kind != "vessel" or not upright or shape.length > _MOST_SLENDER * shape.width:
        return shape
    # The two extents that differ least are the diameter.
    stands = shape.length * shape.thickness > shape.width**2
    diameter, height = (shape.width, shape.length) if stands else (shape.length, shape.thickness)
    return BodyShape("vessel", diameter, height, usual.thickness * diameter)


@lru_cache(maxsize=1024)
def usual_shape(material: str, size: float) -> BodyShape:
    """Return the shape of a body of which only material and size [m] are known."""
    name = solid_name(material)
    name = name if name in _USUAL_SHAPES else family_name(material)
    kind, width, thickness = _USUAL_SHAPES.get(name, ("ellipsoid", 0.5, 0.4))
    return BodyShape(kind, size, width * size, thickness * size)
