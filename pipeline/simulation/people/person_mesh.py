"""Person mesh."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, TypeVar

import numpy as np

from pipeline.simulation.people.body_mesh import arms, shins, shirt, shoes, sleeves, trousers
from pipeline.simulation.people.head_mesh import Head, brows, hair, lids, lips, pupils, skin, whites
from pipeline.simulation.people.proportions import STOUTNESS, Build, Proportions
from pipeline.simulation.people.skinned_surface import Patch, joined
from pipeline.simulation.seeds import generator
from pipeline.simulation.take import Mesh, Part

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


WHITE, PUPIL = "porcelain", "eye"
"""Materials of eyes."""

KEPT = 64
"""How many persons' flesh is kept to be worn by others like them."""


@dataclass(frozen=True, eq=False)
class Layer:
    """What of a person is of one material.

    Attributes:
        name: such as "shirt".
        mesh: at rest, following the frames by their numbers in `FRAMES`.
        material: by name.
    """

    name: str
    mesh: Mesh
    material: str


def dressed(proportions: Proportions, clothes: Clothes) -> tuple[Layer, ...]:
    """Return a clothed person, standing at rest at the origin.

    Its frames' places at rest are `frames.frame_origins`.
    """
    made_of = {
        "skin": clothes.skin,
        "lips": LIPS.get(clothes.skin, "lips"),
        "hair": clothes.hair,
        "shirt": clothes.shirt,
        "trousers": clothes.trousers,
        "shoes": clothes.shoes,
        "whites": WHITE,
        "pupils": PUPIL,
    }
    shape = (clothes.style, clothes.short_sleeves, clothes.shorts, clothes.build)
    return tuple(Layer(name, mesh, made_of[name]) for name, mesh in _meshes(proportions, *shape))


def worn(
    name: str, layers: tuple[Layer, ...], first: int, mesh: int, rows: int
) -> tuple[list[Mesh], list[Part]]:
    """Return meshes and parts of a take.

    Args:
        name: of the person.
        layers: its.
        first: number of its first frame among the take's nodes.
        mesh: number of its first mesh.
        rows: of the take; parts live through all of them.
    """
    meshes, parts = list[Mesh](), list[Part]()
    for layer in layers:
        own = layer.mesh
        nodes = (own.nodes + first).astype(np.int32)
        meshes.append(Mesh(own.vertices, own.faces, nodes, own.weights))
        size = float(np.ptp(own.vertices, axis=0).max())
        number = mesh + len(meshes) - 1
        parts.append(Part(f"{name}.{layer.name}", name, number, layer.material, size, (0, rows)))
    return meshes, parts


@lru_cache(maxsize=KEPT)
def _meshes(
    proportions: Proportions, style: Hair, short_sleeves: bool, shorts: bool, stature: Stature
) -> tuple[tuple[str, Mesh], ...]:
    build = Build(proportions, STOUTNESS[stature])
    layers = _layers(build, style, short_sleeves, shorts)
    return tuple((name, _mesh(joined(patches))) for name, patches in layers)


def _layers(
    build: Build, style: Hair, short_sleeves: bool, shorts: bool
) -> Iterator[tuple[str, list[Patch]]]:
    head = Head(build)
    bare = [shins(build)] if shorts else []
    yield "skin", [skin(head), lids(head), arms(build, short_sleeves), *bare]
    yield "lips", [lips(head)]
    locks = [] if style == "none" else [hair(head, style)]
    yield "hair", [*locks, brows(head)]
    yield "shirt", [shirt(build), sleeves(build, short_sleeves)]
    yield "trousers", [trousers(build, shorts)]
    yield "shoes", [shoes(build)]
    yield "whites", [whites(head)]
    yield "pupils", [pupils(head)]


def _mesh(patch: Patch) -> Mesh:
    share = patch.share.astype(np.float32)
    arrays = (
        patch.vertices.astype(np.float32),
        np.ascontiguousarray(patch.faces, dtype=np.uint32),
        patch.frames.astype(np.int32),
        np.stack([np.float32(1.0) - share, share], axis=-1),
    )
    # Many persons wear them.
    for array in arrays:
        array.setflags(write=False)
    return Mesh(*arrays)
