"""Person mesh: a clothed person as one mesh for each material."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from functools import lru_cache

import numpy as np

from pipeline.simulation.people.body_mesh import (
    bare_arms,
    bare_shins,
    trousers,
)
from pipeline.simulation.people.features import Features, with_features
from pipeline.simulation.people.footwear import shoes
from pipeline.simulation.people.garments import (
    FRONTS,
    bib,
    coat_skirt,
    fastenings,
    hood,
    lapels,
    skirt,
    stripes,
    suit_front,
    tie,
)
from pipeline.simulation.people.hair_lay import brow_hair, head_hair
from pipeline.simulation.people.head_mesh import (
    Head,
    bearded,
    brows,
    ears,
    eyeballs,
    hair_patch,
    haired,
    head_skin,
    neck_skin,
    parted,
    teeth,
)
from pipeline.simulation.people.proportions import GIRTH_FACTORS, BodyMeasures, Proportions
from pipeline.simulation.people.shirt_mesh import Sleeve, shirt
from pipeline.simulation.people.skinned_surface import SkinnedPatch, merge_patches
from pipeline.simulation.people.tints import tint_colors
from pipeline.simulation.people.trims import belt, collar, cuffs, shirt_cuffs, waistband
from pipeline.simulation.people.wardrobe import Clothes, Garment, Stature
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Mesh, Part
from pipeline.spec.costume import HairStyle

EYEBALL_MATERIAL = "eye white"

FOLDED_COLLARS = frozenset[Garment](("tucked", "coat", "bib"))
"""Garments that go with a collar; others with a ribbed neck."""

SHAVEN = 0.13
"""Share of the colour of hair on the shaven skin of grown people without a bust."""

LEAST_CREASE = 2e-5
"""Least move of a vertex in a crease that is kept [m]."""

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
        "hair": clothes.hair,
        "shirt": clothes.shirt,
        "trousers": clothes.trousers,
        "shoes": clothes.shoes,
        "accent": clothes.accent,
        "front": "white cloth",
        "eyes": EYEBALL_MATERIAL,
    }
    sleeves_and_legs = (clothes.short_sleeves, clothes.shorts)
    shape = (
        (clothes.style, clothes.hair_length),
        *sleeves_and_legs,
        clothes.build,
        clothes.is_curved,
        clothes.garments,
        clothes.features,
    )
    colors = clothes.skin, clothes.iris, clothes.shoes, clothes.hair
    return tuple(
        MaterialLayer(name, mesh, materials[name])
        for name, mesh in _cached_meshes(proportions, *shape, *colors)
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
        meshes.append(replace(own, nodes=nodes))
        size = float(np.ptp(own.vertices, axis=0).max())
        number = mesh + len(meshes) - 1
        parts.append(Part(f"{name}.{layer.name}", name, number, layer.material, size, (0, rows)))
    return meshes, parts


@lru_cache(maxsize=MESH_CACHE_SIZE)
def _cached_meshes(
    proportions: Proportions,
    hair: tuple[HairStyle, float],
    short_sleeves: bool,
    shorts: bool,
    stature: Stature,
    is_curved: bool,
    garments: tuple[Garment, ...],
    features: Features,
    *colors: str,
) -> tuple[tuple[str, Mesh], ...]:
    tints = tint_colors(*colors)
    style, length = hair
    build = BodyMeasures(proportions, GIRTH_FACTORS[stature], is_curved)
    head = Head(build)
    layers = [
        (name, _mesh(merge_patches(patches), tints))
        for name, patches in _layers(build, head, style, short_sleeves, shorts, garments, features)
    ]
    locks = []
    if style != "none":
        locks.append(parted(hair_patch(head, style), head, style, features.parting))
    grown = [*(length * head_hair(head, style, patch, features.parting) for patch in locks)]
    grown.append(brow_hair(head, brows(head)))
    own = [
        with_features(patch, features, head.centre, head.size) for patch in (*locks, brows(head))
    ]
    combed = _mesh(merge_patches(own), tints, np.concatenate(grown))
    return (*layers, ("hair", combed))


def _layers(
    build: BodyMeasures,
    head: Head,
    style: HairStyle,
    short_sleeves: bool,
    shorts: bool,
    garments: tuple[Garment, ...],
    features: Features,
) -> Iterator[tuple[str, list[SkinnedPatch]]]:
    bare = [bare_shins(build)] if shorts or "skirt" in garments else []

    def own(patch: SkinnedPatch) -> SkinnedPatch:
        return with_features(patch, features, head.centre, head.size)

    # Shaven skin is darker where a beard would grow.
    shaven = 0.0 if build.is_curved else SHAVEN
    beard = 0.0 if build.childish > 0.0 else max(features.beard, shaven)
    scalp = head_skin(head) if style == "none" else haired(head_skin(head), head)
    face = [own(bearded(scalp, head, beard)), neck_skin(head), own(ears(head))]
    yield "skin", [*face, bare_arms(build, short_sleeves), *bare]
    tucked = not {"skirt", "coat", "tucked", "bib"}.isdisjoint(garments)
    over = {"coat": coat_skirt, "hood": hood}
    worn = [over[word](build) for word in garments if word in over]
    if "suit" in garments:
        worn.append(lapels(build))
    elif "hood" not in garments:
        worn.append(collar(build, not FOLDED_COLLARS.isdisjoint(garments)))
    worn += [fastenings(build, word) for word in garments if word in FRONTS]
    outer = not {"suit", "coat"}.isdisjoint(garments)
    sleeve: Sleeve = "short" if short_sleeves else "straight" if outer else "cuffed"
    worn.append(cuffs(build, sleeve))
    yield "shirt", [shirt(build, sleeve, tucked), *worn]
    legs = [skirt(build)] if "skirt" in garments else [trousers(build, shorts, "coat" in garments)]
    if "bib" in garments:
        legs += [bib(build), waistband(build)]
    yield "trousers", legs
    if "suit" in garments:
        yield "front", [suit_front(build), shirt_cuffs(build)]
        yield "accent", [tie(build)]
    if "stripes" in garments:
        yield "accent", [stripes(build)]
    yield "shoes", [shoes(build, bool(bare)), *([belt(build)] if "tucked" in garments else [])]
    yield "eyes", [own(eyeballs(head)), own(teeth(head))]


def _mesh(patch: SkinnedPatch, tints: Array, hair: Array | None = None) -> Mesh:
    share = patch.share.astype(np.float32)
    extra = dict[str, Array]()
    if len(patch.tint) or len(patch.shade):
        extra["paint"] = _paint(patch, tints)
    if hair is not None:
        extra["hair"] = hair
    if len(patch.targets):
        extra["offsets"] = patch.offsets
    if len(patch.crease):
        # What does not show would be posed all the same.
        shows = np.abs(patch.crease).max(axis=1, keepdims=True) > LEAST_CREASE
        if shows.any():
            extra["creases"] = np.where(shows, patch.crease, 0.0)
    if len(patch.twist):
        extra["twists"] = patch.twist
    mesh = Mesh(
        patch.vertices.astype(np.float32),
        np.ascontiguousarray(patch.faces, dtype=np.uint32),
        patch.frames.astype(np.int32),
        np.stack([np.float32(1.0) - share, share], axis=-1),
        targets=patch.targets.astype(np.int32),
        **{name: values.astype(np.float32) for name, values in extra.items()},
    )
    # The cache shares them.
    for name in (f.name for f in fields(Mesh)):
        getattr(mesh, name).setflags(write=False)
    return mesh


def _paint(patch: SkinnedPatch, tints: Array) -> Array:
    """Return the colours and their shares (V, 4) that tint a patch and shade it.

    Shade s of a mixture is s a paint + s (1 - a) material, a paint whose share is 1 - s (1 - a).
    """
    number, part = patch.tints[:, 0].astype(int), patch.tints[:, 1:]
    shade = patch.shades[:, None]
    share = 1.0 - shade * (1.0 - part)
    color = shade * part * tints[number] / np.maximum(share, 1e-6)
    return np.concatenate([color, share], axis=-1)
