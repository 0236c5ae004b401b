"""Clothes: what a person looks like besides its proportions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from pipeline.simulation.seeds import generator

Hair = Literal["short", "bob", "bun", "long", "none"]
Stature = Literal["slim", "medium", "sturdy"]

SKINS = ("skin", "dark skin")
HAIRS = ("black fur", "chestnut fur", "fur", "sand fur", "red fur")
SHIRTS = ("red cloth", "blue cloth", "green cloth", "white cloth")
TROUSERS = ("blue cloth", "black cloth", "leather")
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

    skin: str = "skin"
    hair: str = "chestnut fur"
    shirt: str = "red cloth"
    trousers: str = "blue cloth"
    shoes: str = "leather"
    style: Hair = "short"
    short_sleeves: bool = True
    shorts: bool = False
    build: Stature = "medium"


def clothes_of(name: str, seed: int, child: bool = False) -> Clothes:
    """Return what a person of a name wears by itself, under a scene's seed."""
    chance = generator(seed, f"{name}/clothes")

    def one(*options: str) -> str:
        return options[int(chance.integers(len(options)))]

    skin, hair = one(*SKINS), one(*HAIRS)
    shirt = one(*SHIRTS)
    trousers = one(*(material for material in TROUSERS if material != shirt))
    style = one("short", "short", "bob", "bun", "long")
    return Clothes(
        skin=skin,
        hair="black fur" if skin == "dark skin" else hair,
        shirt=shirt,
        trousers=trousers,
        shoes=one(*SHOES),
        style=style,  # type: ignore[arg-type]
        short_sleeves=bool(chance.random() < 0.6),
        shorts=bool(chance.random() < (0.6 if child else 0.15)),
        build=one("slim", "medium", "medium", "sturdy"),  # type: ignore[arg-type]
    )
