"""Clothes: what a person looks like besides its proportions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeVar

from pipeline.simulation.seeds import generator

Hair = Literal["short", "bob", "bun", "long", "none"]
Stature = Literal["slim", "medium", "sturdy"]
Word = TypeVar("Word", bound=str)

LIPS = {
    "fair skin": "lips",
    "skin": "lips",
    "tan skin": "lips",
    "brown skin": "dark lips",
    "dark skin": "dark lips",
}
"""Skins, and the lips that go with them."""

LIGHT_HAIR = ("chestnut fur", "fur", "sand fur", "red fur", "black fur")
DARK_HAIR = ("black fur", "black fur", "chestnut fur")
SHIRTS = ("red cloth", "green cloth", "white cloth", "yellow cloth", "blue cloth")
TROUSERS = ("denim", "black cloth", "grey cloth")
STYLES: tuple[Hair, ...] = ("short", "short", "bob", "bun", "long")
STATURES: tuple[Stature, ...] = ("slim", "medium", "medium", "sturdy")
SHOES = ("leather", "black cloth", "white cloth")


@dataclass(frozen=True, slots=True)
class Clothes:
    """What a person wears and looks like; materials by name.

    Attributes:
        skin: material.
        hair: material, of the brows too.
        shirt: material.
        trousers: material.
        shoes: material.
        style: of the hair.
        short_sleeves: whether arms are bare from above the elbow.
        shorts: whether legs are bare from above the knee.
        build: how stout.
    """

    skin: str = "fair skin"
    hair: str = "chestnut fur"
    shirt: str = "red cloth"
    trousers: str = "denim"
    shoes: str = "leather"
    style: Hair = "short"
    short_sleeves: bool = True
    shorts: bool = False
    build: Stature = "medium"


def clothes_of(name: str, seed: int, child: bool = False) -> Clothes:
    """Return what a person of a name wears by itself, under a scene's seed."""
    chance = generator(seed, f"{name}/clothes")

    def one(*options: Word) -> Word:
        return options[int(chance.integers(len(options)))]

    skin = one(*LIPS)
    hair = one(*(LIGHT_HAIR if LIPS[skin] == "lips" else DARK_HAIR))
    shirt, trousers = one(*SHIRTS), one(*TROUSERS)
    style = one(*STYLES)
    return Clothes(
        skin=skin,
        hair=hair,
        shirt=shirt,
        trousers=trousers,
        shoes=one(*SHOES),
        style=style,
        short_sleeves=bool(chance.random() < 0.6),
        shorts=bool(chance.random() < (0.6 if child else 0.15)),
        build=one(*STATURES),
    )
