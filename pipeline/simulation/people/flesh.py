"""Flesh: a clothed person as meshes over its frames, one for each material."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from pipeline.simulation.people import arms, face, hair, legs, trunk
from pipeline.simulation.people.build import STOUTNESS, Build
from pipeline.simulation.people.clothes import LIPS, Clothes, Hair, Stature
from pipeline.simulation.people.patches import Patch, joined
from pipeline.simulation.people.proportions import Proportions
from pipeline.simulation.take import Mesh, Part

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
    head = face.Head(build)
    bare = [legs.shins(build)] if shorts else []
    yield "skin", [face.skin(head), face.lids(head), arms.arms(build, short_sleeves), *bare]
    yield "lips", [face.lips(head)]
    locks = [] if style == "none" else [hair.hair(head, style)]
    yield "hair", [*locks, face.brows(head)]
    yield "shirt", [trunk.shirt(build), arms.sleeves(build, short_sleeves)]
    yield "trousers", [legs.trousers(build, shorts)]
    yield "shoes", [legs.shoes(build)]
    yield "whites", [face.whites(head)]
    yield "pupils", [face.pupils(head)]


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
