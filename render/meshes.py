"""Meshes in Mitsuba: the one module that knows the names of its mesh parameters.

Small meshes of one material are merged, because one mesh that is updated in place
is several times faster than hundreds. What is merged follows from the topology
alone, so that every frame of a build, rendered in any order, has the same scene.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from render.config import Material
from render.errors import ShotError
from render.footprints import Prints
from render.shares import share_names, shares
from render.shot import Mesh
from render.surfaces.footprint_lookup import PRINTED
from render.surfaces.material_bsdf import (
    TINTED,
    Surface,
    bsdf,
    glowing,
    has_shares,
    needs_coordinates,
)
from render.unwrapping import Unwrapped, unwrapped

ALONE = 20_000
"""A mesh of this many vertices is not merged: it is likely to stand still (terrain)."""


@dataclass(frozen=True)
class Group:
    """Meshes that make up one mesh of Mitsuba.

    Attributes:
        members: their places in `Shot.meshes`.
        material: name of their material.
        surface: what patterns are laid on.
        smooth: whether they have vertex normals.
        faces: (F, 3) indices into the vertices of all members.
        shared: the material, if its vertices say which share of its colours they show.
        tinted: (F,) faces in the colour of a warning, or None.
        unwrapped: the surface with texture coordinates, None where it needs none.
        prints: what is pressed into it, or None; such a mesh stands alone.
    """

    members: tuple[int, ...]
    material: str
    surface: Surface
    smooth: bool
    faces: NDArray[np.uint32]
    shared: Material | None
    tinted: NDArray[np.bool_] | None
    unwrapped: Unwrapped | None
    prints: Prints | None


def groups(meshes: Sequence[Mesh], materials: Mapping[str, Material]) -> tuple[Group, ...]:
    """Return the groups into which the meshes of a shot are merged.

    Raises:
        ShotError: a mesh names a material that the shot has not, or its arrays do not fit.
    """
    members: dict[tuple[str, Surface, bool, bool, str], list[int]] = {}
    for i, mesh in enumerate(meshes):
        _check(mesh, materials)
        alone = len(mesh.vertices) >= ALONE or mesh.prints is not None
        name = mesh.name if alone else ""
        alike = mesh.material, _surface(mesh), mesh.smooth, mesh.tinted is not None, name
        members.setdefault(alike, []).append(i)
    return tuple(
        _group(tuple(places), meshes, materials[material], material, surface, smooth)
        for (material, surface, smooth, _, _), places in members.items()
    )


def _surface(mesh: Mesh) -> Surface:
    if mesh.uv is not None:
        return "ground"
    return "bare" if mesh.rest is None else "body"


def _check(mesh: Mesh, materials: Mapping[str, Material]) -> None:
    if mesh.material not in materials:
        raise ShotError(
            f"mesh {mesh.name!r} asks for material {mesh.material!r}, which the shot has not; "
            f"it has {', '.join(sorted(materials))}"
        )
    n = len(mesh.vertices)
    if mesh.faces.size and int(mesh.faces.max()) >= n:
        raise ShotError(f"mesh {mesh.name!r} has a face with a vertex beyond its {n}")
    if mesh.uv is not None and mesh.uv.shape != (n, 2):
        raise ShotError(f"mesh {mesh.name!r} has uv of shape {mesh.uv.shape}, not ({n}, 2)")
    if mesh.rest is not None and mesh.rest.shape != (n, 3):
        raise ShotError(f"mesh {mesh.name!r} has rest of shape {mesh.rest.shape}, not ({n}, 3)")
    if mesh.tinted is not None and mesh.tinted.shape != mesh.faces.shape[:1]:
        told = f"has tints for {len(mesh.tinted)} faces, not {len(mesh.faces)}"
        raise ShotError(f"mesh {mesh.name!r} {told}")


def _group(
    members: tuple[int, ...],
    meshes: Sequence[Mesh],
    words: Material,
    material: str,
    surface: Surface,
    smooth: bool,
) -> Group:
    starts = np.cumsum([0, *(len(meshes[i].vertices) for i in members)])
    faces = [
        meshes[i].faces.astype(np.uint32) + np.uint32(s)
        for i, s in zip(members, starts, strict=False)
    ]
    all_faces = np.concatenate(faces)
    shared = words if has_shares(words, surface) else None
    tints = [t for t in (meshes[i].tinted for i in members) if t is not None]
    tinted = np.concatenate(tints) if tints else None
    laid = _unwrapped([meshes[i] for i in members], all_faces, words, surface)
    prints = meshes[members[0]].prints
    return Group(members, material, surface, smooth, all_faces, shared, tinted, laid, prints)


def _unwrapped(
    meshes: Sequence[Mesh], faces: NDArray[np.uint32], words: Material, surface: Surface
) -> Unwrapped | None:
    if surface == "bare" or not needs_coordinates(words, surface):
        return None
    # Ground stands where it is at rest.
    rest = [mesh.vertices if mesh.rest is None else mesh.rest for mesh in meshes]
    return unwrapped(np.concatenate(rest), faces)


def built(group: Group, meshes: Sequence[Mesh], words: Material) -> mi.Mesh:
    """Return a group as a new mesh of Mitsuba."""
    props = mi.Properties()
    props["mesh_bsdf"] = bsdf(words, group.surface, group.tinted is not None, group.prints)
    laid = group.unwrapped
    count = len(laid.source) if laid else sum(len(meshes[i].vertices) for i in group.members)
    if words.glow > 0.0:
        props["mesh_emitter"] = mi.load_dict(glowing(words))
    mesh = mi.Mesh(
        group.material,
        count,
        len(group.faces),
        props=props,
        has_vertex_normals=group.smooth,
        has_vertex_texcoords=laid is not None,
    )
    for name in share_names(group.shared):
        mesh.add_attribute(name, 1, [0.0] * count)
    if group.tinted is not None:
        tints = _at_vertices(group.tinted, group.faces)
        mesh.add_attribute(TINTED, 1, (tints[laid.source] if laid else tints).tolist())
    values = mi.traverse(mesh)
    _write(values, "faces", laid.faces if laid else group.faces)
    if laid:
        _write(values, "vertex_texcoords", laid.uv)
    update(values, "", group, meshes)
    values.update()
    return mesh


def update(values: Any, prefix: str, group: Group, meshes: Sequence[Mesh]) -> None:
    """Write where a group stands in this frame into Mitsuba's parameters.

    Raises:
        ShotError: a vertex is not finite.
    """
    vertices = np.concatenate([meshes[i].vertices for i in group.members])
    vertices = np.ascontiguousarray(vertices, np.float32)
    if not np.isfinite(vertices).all():
        raise ShotError(f"a vertex of material {group.material!r} is not finite")
    every = slice(None) if group.unwrapped is None else group.unwrapped.source
    _write(values, prefix + "vertex_positions", vertices[every])
    if group.smooth:
        normals = vertex_normals(vertices, group.faces)
        _write(values, prefix + "vertex_normals", normals[every])
        if group.shared is not None:
            for name, share in shares(group.shared, vertices, normals).items():
                _write(values, prefix + name, share[every])


def imprint(values: Any, prefix: str, group: Group, meshes: Sequence[Mesh]) -> None:
    """Write how many prints have been made into Mitsuba's parameters."""
    name = f"{prefix}bsdf.{PRINTED}"
    if group.prints is not None and name in values:
        values[name] = dr.opaque(type(values[name]), meshes[group.members[0]].printed)


def _at_vertices(tinted: NDArray[np.bool_], faces: NDArray[np.uint32]) -> NDArray[np.float32]:
    """Return which share of the faces about each vertex is tinted, (V,)."""
    corners, tints = faces.ravel(), np.repeat(tinted.astype(float), 3)
    count = np.bincount(corners)
    return (np.bincount(corners, tints) / np.maximum(count, 1)).astype(np.float32)


def _write(values: Any, name: str, array: NDArray[Any]) -> None:
    # The type of a buffer differs between the variants of Mitsuba.
    values[name] = type(values[name])(np.ascontiguousarray(array.ravel()))


def moved(group: Group, before: Sequence[Mesh], now: Sequence[Mesh]) -> bool:
    """Whether any mesh of a group stands elsewhere than before."""
    return any(
        before[i] is not now[i]
        and before[i].vertices is not now[i].vertices
        and not np.array_equal(before[i].vertices, now[i].vertices)
        for i in group.members
    )


def vertex_normals(vertices: NDArray[np.float32], faces: NDArray[np.uint32]) -> NDArray[np.float32]:
    """Return the unit normals of the vertices, weighted by the area of the faces.

    Computed here and not by Mitsuba, which adds them up in parallel in any order.

    Args:
        vertices: (V, 3) [m].
        faces: (F, 3).
    """
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    n = np.cross(b - a, c - a)
    corners = faces.T.ravel()
    sums = [np.bincount(corners, np.tile(n[:, i], 3), len(vertices)) for i in range(3)]
    total = np.stack(sums, axis=1)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    # A vertex of collapsed triangles only is never seen; any direction will do.
    up = np.array([0.0, 1.0, 0.0])
    return np.where(length > 1e-20, total / np.maximum(length, 1e-20), up).astype(np.float32)
