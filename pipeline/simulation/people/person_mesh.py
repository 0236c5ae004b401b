"""Person mesh: random clothes, and a clothed person as one mesh for each material."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, TypeVar

import numpy as np

from pipeline.simulation.people.body_mesh import (
    bare_arms,
    bare_shins,
    shirt,
    shoes,
    sleeves,
    trousers,
)
from pipeline.simulation.people.head_mesh import (
    Head,
    brows,
    eyeballs,
    hair_patch,
    head_skin,
    lids,
    lips,
    pupils,
)
from pipeline.simulation.people.proportions import GIRTH_FACTORS, BodyMeasures, Proportions
from pipeline.simulation.people.skinned_surface import SkinnedPatch, merge_patches
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
"""Skin material -> lip material."""

LIGHT_HAIR = ("chestnut fur", "fur", "sand fur", "red fur", "black fur")

DARK_HAIR = ("black fur", "black fur", "chestnut fur")

SHIRTS = ("red cloth", "green cloth", "white cloth", "yellow cloth", "blue cloth")

TROUSERS = ("denim", "black cloth", "grey cloth")

STYLES: tuple[Hair, ...] = ("short", "short", "bob", "bun", "long")

STATURES: tuple[Stature, ...] = ("slim", "medium", "medium", "sturdy")

SHOES = ("leather", "black cloth", "white cloth")


@dataclass(frozen=True, slots=True)
class Clothes:
    """Clothes, hair and stature of a person; materials by name.

    Attributes:
        skin: material.
        hair: material, of the brows too.
        shirt: material.
        trousers: material.
        shoes: material.
        style: of the hair.
        short_sleeves: whether arms are bare from above the elbow.
        shorts: whether legs are bare from above the knee.
        build: stature.
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


def random_clothes(name: str, seed: int, child: bool = False) -> Clothes:
    """Return the random clothes of a person by name, under a scene's seed."""
    rng = generator(seed, f"{name}/clothes")

    def choice(*options: Word) -> Word:
        return options[int(rng.integers(len(options)))]

    skin = choice(*LIPS)
    hair = choice(*(LIGHT_HAIR if LIPS[skin] == "lips" else DARK_HAIR))
    shirt, trousers = choice(*SHIRTS), choice(*TROUSERS)
    style = choice(*STYLES)
    return Clothes(
        skin=skin,
        hair=hair,
        shirt=shirt,
        trousers=trousers,
        shoes=choice(*SHOES),
        style=style,
        short_sleeves=bool(rng.random() < 0.6),
        shorts=bool(rng.random() < (0.6 if child else 0.15)),
        build=choice(*STATURES),
    )


EYEBALL_MATERIAL, PUPIL_MATERIAL = "porcelain", "eye"

MESH_CACHE_SIZE = 64
"""Number of persons whose meshes are kept for others like them."""


@dataclass(frozen=True, eq=False)
class MaterialLayer:
    """The part of a person of one material.

    Attributes:
        name: such as "shirt".
        mesh: at rest, following the frames by their numbers in `FRAMES`.
        material: by name.
    """

    name: str
    mesh: Mesh
    material: str


def person_layers(proportions: Proportions, clothes: Clothes) -> tuple[MaterialLayer, ...]:
    """Return the layers of a clothed person, standing at rest at the origin.

    `body_frames.frame_origins` are the places of its frames at rest.
    """
    materials = {
        "skin": clothes.skin,
        "lips": LIPS.get(clothes.skin, "lips"),
        "hair": clothes.hair,
        "shirt": clothes.shirt,
        "trousers": clothes.trousers,
        "shoes": clothes.shoes,
        "whites": EYEBALL_MATERIAL,
        "pupils": PUPIL_MATERIAL,
    }
    shape = (clothes.style, clothes.short_sleeves, clothes.shorts, clothes.build)
    return tuple(
        MaterialLayer(name, mesh, materials[name])
        for name, mesh in _cached_meshes(proportions, *shape)
    )


def layer_parts(
    name: str, layers: tuple[MaterialLayer, ...], first: int, mesh: int, rows: int
) -> tuple[list[Mesh], list[Part]]:
    """Return the meshes and parts of layers for a take.

    Args:
        name: of the person.
        layers: of the person.
        first: number of the person's first frame among the take's nodes.
        mesh: number of the person's first mesh.
        rows: number of rows of the take, for which parts live.
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


@lru_cache(maxsize=MESH_CACHE_SIZE)
def _cached_meshes(
    proportions: Proportions, style: Hair, short_sleeves: bool, shorts: bool, stature: Stature
) -> tuple[tuple[str, Mesh], ...]:
    build = BodyMeasures(proportions, GIRTH_FACTORS[stature])
    layers = _layers(build, style, short_sleeves, shorts)
    return tuple((name, _mesh(merge_patches(patches))) for name, patches in layers)


def _layers(
    build: BodyMeasures, style: Hair, short_sleeves: bool, shorts: bool
) -> Iterator[tuple[str, list[SkinnedPatch]]]:
    head = Head(build)
    bare = [bare_shins(build)] if shorts else []
    yield "skin", [head_skin(head), lids(head), bare_arms(build, short_sleeves), *bare]
    yield "lips", [lips(head)]
    locks = [] if style == "none" else [hair_patch(head, style)]
    yield "hair", [*locks, brows(head)]
    yield "shirt", [shirt(build), sleeves(build, short_sleeves)]
    yield "trousers", [trousers(build, shorts)]
    yield "shoes", [shoes(build)]
    yield "whites", [eyeballs(head)]
    yield "pupils", [pupils(head)]


def _mesh(patch: SkinnedPatch) -> Mesh:
    share = patch.share.astype(np.float32)
    arrays = (
        patch.vertices.astype(np.float32),
        np.ascontiguousarray(patch.faces, dtype=np.uint32),
        patch.frames.astype(np.int32),
        np.stack([np.float32(1.0) - share, share], axis=-1),
    )
    # The cache shares them.
    for array in arrays:
        array.setflags(write=False)
    return Mesh(*arrays)
