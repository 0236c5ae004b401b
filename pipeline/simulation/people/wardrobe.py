"""Wardrobe: the clothes of people, all different in one scene as long as there are enough."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, TypeVar

from pipeline.simulation.people.features import MEAN_FEATURES, Features, draw_features
from pipeline.simulation.people.tints import LIPS
from pipeline.simulation.seeds import generator
from pipeline.spec.costume import COSTUMES, Costume, HairStyle

Stature = Literal["slim", "medium", "sturdy"]

Garment = Literal["skirt", "coat", "hood", "suit", "bib", "stripes", "tucked"]

Word = TypeVar("Word", bound=str)

LIGHT_HAIR = ("chestnut fur", "fur", "sand fur", "red fur", "black fur")

DARK_HAIR = ("black fur", "black fur", "brown fur")

LIGHT_IRISES = ("blue iris", "brown iris", "green iris")

# fmt: off
SHIRTS = (
    "red cloth", "teal cloth", "white cloth", "yellow cloth", "blue cloth", "pink cloth",
    "green cloth", "orange cloth", "plum cloth", "navy cloth",
)
# fmt: on

TROUSERS = ("denim", "black cloth", "grey cloth", "beige cloth", "navy cloth")

STYLES: tuple[HairStyle, ...] = ("short", "short", "bob", "bun", "long")

LONGER: tuple[HairStyle, ...] = ("bob", "bun", "long")

STATURES: tuple[Stature, ...] = ("slim", "medium", "medium", "sturdy")

SHOES = ("leather", "black cloth", "white cloth", "red cloth", "navy cloth")

BARE_LOOKING = ("tan skin", "brown skin", "dark skin")
"""Skins of which shoes of brown leather would look like the bare feet."""


@dataclass(frozen=True, slots=True)
class Outfit:
    """What a costume consists of.

    Attributes:
        garments: over shirt and trousers, or in place of these.
        shirts: materials to choose from.
        trousers: materials to choose from; empty for that of the shirt.
        shoes: materials to choose from.
        styles: of the hair to choose from.
        short_sleeves: whether arms are bare from above the elbow.
        shorts: whether legs are bare from above the knee.
    """

    garments: tuple[Garment, ...] = ()
    shirts: Sequence[str] = SHIRTS
    trousers: Sequence[str] = TROUSERS
    shoes: Sequence[str] = SHOES
    styles: Sequence[HairStyle] = STYLES
    short_sleeves: bool = False
    shorts: bool = False


OUTFITS: Mapping[Costume, Outfit] = {
    "casual": Outfit(short_sleeves=True, trousers=("denim",)),
    "summer": Outfit(
        short_sleeves=True,
        shorts=True,
        trousers=("beige cloth", "navy cloth", "denim"),
        shoes=("white cloth", "leather", "red cloth"),
    ),
    "office": Outfit(
        ("tucked",),
        shirts=("white cloth", "blue cloth", "pink cloth"),
        trousers=("black cloth", "grey cloth", "navy cloth"),
        shoes=("leather", "black leather"),
    ),
    "hoodie": Outfit(
        ("hood",),
        shirts=("grey cloth", "plum cloth", "orange cloth", "green cloth"),
        trousers=("denim", "black cloth"),
        shoes=("white cloth",),
    ),
    "coat": Outfit(
        ("coat",),
        shirts=("beige cloth", "navy cloth", "red cloth", "black cloth"),
        trousers=("black cloth", "denim"),
        shoes=("leather",),
    ),
    "dress": Outfit(("skirt",), trousers=(), short_sleeves=True, styles=LONGER),
    "skirt": Outfit(
        ("skirt",),
        shirts=("white cloth", "pink cloth", "yellow cloth"),
        trousers=("plum cloth", "navy cloth", "red cloth", "green cloth"),
        styles=LONGER,
    ),
    "suit": Outfit(
        ("suit",),
        shirts=("navy cloth", "grey cloth", "black cloth"),
        trousers=(),
        shoes=("leather", "black leather"),
        styles=("short", "short", "bun", "bob"),
    ),
    "sport": Outfit(
        ("stripes",),
        shirts=("red cloth", "blue cloth", "green cloth"),
        trousers=("black cloth", "navy cloth"),
        shoes=("white cloth",),
    ),
    "workwear": Outfit(
        ("bib",),
        shirts=("white cloth", "red cloth", "yellow cloth", "orange cloth"),
        trousers=("denim",),
        shoes=("leather",),
        short_sleeves=True,
    ),
}
"""What is worn, by the name of the costume."""


@dataclass(frozen=True, slots=True)
class Clothes:
    """Clothes, hair and stature of a person; materials by name.

    Attributes:
        skin: material.
        hair: material, of the brows too.
        iris: material.
        shirt: material, of coats, jackets and hoods too.
        trousers: material, of skirts and bibs too.
        shoes: material.
        style: of the hair.
        short_sleeves: whether arms are bare from above the elbow.
        shorts: whether legs are bare from above the knee.
        build: stature.
        garments: over shirt and trousers, or in place of these.
        accent: material of ties and stripes.
        hair_length: factor on the length of the hair.
        features: of the face.
    """

    skin: str = "fair skin"
    hair: str = "chestnut fur"
    iris: str = "brown iris"
    shirt: str = "red cloth"
    trousers: str = "denim"
    shoes: str = "leather"
    style: HairStyle = "short"
    short_sleeves: bool = True
    shorts: bool = False
    build: Stature = "medium"
    garments: tuple[Garment, ...] = ()
    accent: str = "white cloth"
    hair_length: float = 1.0
    features: Features = MEAN_FEATURES

    @property
    def is_curved(self) -> bool:
        """Whether bodies under them have a bust and a narrow waist: as hair is worn long."""
        return self.style in LONGER


def deal_clothes(wishes: Mapping[str, Costume | None], seed: int) -> dict[str, Clothes]:
    """Return the random clothes of all people of a scene, whatever their order.

    No two wear the same costume as long as there are enough, unless their author says so.

    Args:
        wishes: the costume of each person by its name, None for one that is dealt.
        seed: of the scene.
    """
    deck = generator(seed, "costumes")
    shuffled = [COSTUMES[int(k)] for k in deck.permutation(len(COSTUMES))]
    # Two who are dressed alike differ by colour.
    first = int(deck.integers(100))
    left = [costume for costume in shuffled if costume not in wishes.values()]
    dealt: Iterator[Costume] = itertools.chain(left, itertools.cycle(shuffled))
    return {
        name: _clothes(
            name, seed, next(dealt) if wish is None else wish, first + k + k // len(COSTUMES)
        )
        for k, (name, wish) in enumerate(sorted(wishes.items()))
    }


def _clothes(name: str, seed: int, costume: Costume, turn: int) -> Clothes:
    """Return the clothes of a person in a costume; `turn` chooses the colour of its shirt."""
    rng = generator(seed, f"{name}/clothes")

    def choice(options: Sequence[Word]) -> Word:
        return options[int(rng.integers(len(options)))]

    skin = choice(tuple(LIPS))
    is_light = LIPS[skin] == "lips"
    outfit = OUTFITS[costume]
    shirt = outfit.shirts[turn % len(outfit.shirts)]
    others = [material for material in outfit.trousers if material != shirt]
    hair = choice(LIGHT_HAIR if is_light else DARK_HAIR)
    iris = choice(LIGHT_IRISES if is_light else ("brown iris",))
    trousers = choice(others) if others else shirt
    shoes = choice(outfit.shoes)
    if shoes == "leather" and skin in BARE_LOOKING:
        shoes = "white cloth" if outfit.shorts or "skirt" in outfit.garments else "black leather"
    style = choice(outfit.styles)
    features = draw_features(generator(seed, f"{name}/features"), style == "short")
    return Clothes(
        skin=skin,
        hair=hair,
        iris=iris,
        shirt=shirt,
        trousers=trousers,
        shoes=shoes,
        style=style,
        short_sleeves=outfit.short_sleeves,
        shorts=outfit.shorts,
        build=choice(STATURES),
        garments=outfit.garments,
        accent=choice(("red cloth", "teal cloth", "plum cloth"))
        if "suit" in outfit.garments
        else "white cloth",
        features=features,
    )
