"""Mitsuba meshes, merged by material: the one module that names their parameters.

Small meshes of one material are merged, because updating one mesh in place is several times
faster than updating hundreds. The merge follows from the topology alone, so that every frame of
a build has the same scene, in any order of rendering.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from render.color import linear
from render.config import Material
from render.errors import ShotError
from render.footprints import FootprintRaster
from render.ground_wear import GroundWear
from render.shot import Mesh
from render.surfaces.footprint_lookup import FOOTPRINT_COUNT
from render.surfaces.material_bsdf import (
    area_emitter,
    material_bsdf,
    needs_coordinates,
    needs_vertex_shares,
)
from render.surfaces.mitsuba_bsdf import VERTEX_COLOR, Surface, share_names, vertex_shares
from render.surfaces.patterns import COVER_COLOR, COVER_SHARE, WARNED
from render.vertex_normals import vertex_normals

MERGE_LIMIT = 20_000
"""Vertices from which a mesh is not merged: it is likely to stand still (terrain)."""

_PLANES = np.array([[1, 2], [0, 2], [0, 1]])
"""Axes of the plane of projection along each axis; the rows of a pattern run along the first."""


_GroupKey = tuple[str, Surface, bool, tuple[bool, ...], str]


@dataclass(frozen=True, eq=False)
class Unwrapped:
    """A surface with texture coordinates and doubled vertices at seams.

    Attributes:
        source: (V,) index of the original vertex of each vertex.
        faces: (F, 3) indices of the doubled vertices.
        uv: (V, 2) texture coordinates [m].
    """

    source: NDArray[np.uint32]
    faces: NDArray[np.uint32]
    uv: NDArray[np.float32]


@dataclass(frozen=True)
class MeshGroup:
    """Meshes of a shot that become one Mitsuba mesh.

    Attributes:
        members: their indices in `Shot.meshes`.
        material: name of their material.
        surface: what patterns are laid on.
        smooth: whether they have vertex normals.
        faces: (F, 3) indices into the vertices of all members.
        share_material: the material, if its vertices have `mitsuba_bsdf.vertex_shares`.
        warned: (F,) hatched faces, or None.
        unwrapped: the surface with texture coordinates, None where it needs none.
        footprints: in the ground, or None; a mesh with footprints is not merged.
        has_colors: whether the vertices have colours.
        given_normals: whether the meshes bring their normals.
        cover: (V, 4) colours and their shares, or None; ground with a cover is not merged.
        wear: bare soil in the ground, or None; a mesh with wear is not merged.
    """

    members: tuple[int, ...]
    material: str
    surface: Surface
    smooth: bool
    faces: NDArray[np.uint32]
    share_material: Material | None
    warned: NDArray[np.bool_] | None
    unwrapped: Unwrapped | None
    footprints: FootprintRaster | None
    has_colors: bool
    given_normals: bool
    cover: NDArray[np.float32] | None
    wear: GroundWear | None


def group_meshes(
    meshes: Sequence[Mesh], materials: Mapping[str, Material]
) -> tuple[MeshGroup, ...]:
    """Return the groups into which the meshes of a shot are merged.

    Raises:
        ShotError: a mesh names an unknown material, or its arrays do not fit.
    """
    members: dict[_GroupKey, list[int]] = {}
    for i, mesh in enumerate(meshes):
        _check(mesh, materials)
        is_alone = len(mesh.vertices) >= MERGE_LIMIT or mesh.footprints is not None
        is_alone |= _surface(mesh) == "ground" and mesh.cover is not None
        is_alone |= mesh.wear is not None
        name = mesh.name if is_alone else ""
        extra = tuple(x is not None for x in (mesh.warned, mesh.colors, mesh.normals, mesh.cover))
        key = mesh.material, _surface(mesh), mesh.smooth, extra, name
        members.setdefault(key, []).append(i)
    return tuple(
        _group(tuple(indices), meshes, materials[material], material, surface, smooth)
        for (material, surface, smooth, _, _), indices in members.items()
    )


def _surface(mesh: Mesh) -> Surface:
    if mesh.uv is not None:
        return "ground"
    return "bare" if mesh.rest is None else "body"


def _check(mesh: Mesh, materials: Mapping[str, Material]) -> None:
    if mesh.material not in materials:
        raise ShotError(
            f"mesh {mesh.name!r} names material {mesh.material!r}, which the shot lacks; "
            f"it has {', '.join(sorted(materials))}"
        )
    n = len(mesh.vertices)
    if mesh.faces.size and int(mesh.faces.max()) >= n:
        raise ShotError(f"mesh {mesh.name!r} has a face with a vertex beyond its {n}")
    if mesh.uv is not None and mesh.uv.shape != (n, 2):
        raise ShotError(f"mesh {mesh.name!r} has uv of shape {mesh.uv.shape}, not ({n}, 2)")
    if mesh.rest is not None and mesh.rest.shape != (n, 3):
        raise ShotError(f"mesh {mesh.name!r} has rest of shape {mesh.rest.shape}, not ({n}, 3)")
    _check_colors(mesh, materials[mesh.material])
    if mesh.cover is not None and mesh.cover.shape != (n, 4):
        raise ShotError(f"mesh {mesh.name!r} has cover of shape {mesh.cover.shape}, not ({n}, 4)")
    if mesh.cover is not None and mesh.colors is not None:
        raise ShotError(f"mesh {mesh.name!r} has colours and a cover; it may have one of them")
    if mesh.warned is not None and mesh.warned.shape != mesh.faces.shape[:1]:
        counts = f"{len(mesh.warned)} values for {len(mesh.faces)} faces"
        raise ShotError(f"mesh {mesh.name!r} has `warned` with {counts}")


def _check_colors(mesh: Mesh, material: Material) -> None:
    n = len(mesh.vertices)
    for name, values in (("colors", mesh.colors), ("normals", mesh.normals)):
        if values is not None and values.shape != (n, 3):
            raise ShotError(f"mesh {mesh.name!r} has {name} of shape {values.shape}, not ({n}, 3)")
    if mesh.normals is not None and not mesh.smooth:
        raise ShotError(f"mesh {mesh.name!r} has normals, but is not smooth")
    if mesh.colors is not None and (_surface(mesh) != "bare" or mesh.warned is not None):
        raise ShotError(f"mesh {mesh.name!r} has colours and a pattern; it may have one of them")
    if mesh.colors is not None and material.transmission > 0.0:
        raise ShotError(f"mesh {mesh.name!r} has colours, which {mesh.material!r} cannot show")


def _group(
    members: tuple[int, ...],
    meshes: Sequence[Mesh],
    material: Material,
    name: str,
    surface: Surface,
    smooth: bool,
) -> MeshGroup:
    starts = np.cumsum([0, *(len(meshes[i].vertices) for i in members)])
    own = [meshes[i].faces.astype(np.uint32, copy=False) for i in members]
    # Scenery is large, and alone in its group: it is not copied.
    faces = own[0]
    if len(own) > 1:
        faces = np.concatenate([f + np.uint32(k) for f, k in zip(own, starts, strict=False)])
    share_material = material if needs_vertex_shares(material, surface) else None
    warned = [mesh.warned for mesh in (meshes[i] for i in members) if mesh.warned is not None]
    unwrapped = None
    if surface != "bare" and needs_coordinates(material, surface):
        # Ground is at rest where it stands.
        grouped = [meshes[i] for i in members]
        rest = [mesh.vertices if mesh.rest is None else mesh.rest for mesh in grouped]
        longest = np.repeat([_longest_axis(part) for part in rest], [len(part) for part in rest])
        unwrapped = unwrap(np.concatenate(rest), faces, longest)
    cover = [mesh.cover for mesh in (meshes[i] for i in members) if mesh.cover is not None]
    return MeshGroup(
        members,
        name,
        surface,
        smooth,
        faces,
        share_material,
        np.concatenate(warned) if warned else None,
        unwrapped,
        meshes[members[0]].footprints,
        meshes[members[0]].colors is not None,
        meshes[members[0]].normals is not None,
        np.concatenate(cover) if cover else None,
        meshes[members[0]].wear,
    )


def _joined(arrays: Sequence[NDArray[Any]]) -> NDArray[Any]:
    """Return arrays one after the other; a single one is not copied."""
    return arrays[0] if len(arrays) == 1 else np.concatenate(arrays)


def _longest_axis(rest: NDArray[np.float32]) -> int:
    """Return the axis along which vertices (N, 3) reach farthest."""
    return int(np.ptp(rest, axis=0).argmax()) if len(rest) else 0


def unwrap(
    rest: NDArray[np.float32], faces: NDArray[np.uint32], longest: NDArray[np.intp]
) -> Unwrapped:
    """Return a surface with texture coordinates from six sides of the box around it at rest.

    Every triangle is projected along the axis that it faces, which stretches no pattern by more
    than the square root of three. Where two sides meet, vertices are doubled; the doubles keep
    one normal, so that the seam is in the pattern alone. Rows of a pattern run along the longest
    side of a body on all of its sides but two.

    Args:
        rest: (N, 3) vertices at rest [m].
        faces: (F, 3).
        longest: (N,) axis of the longest side of the body of each vertex.
    """
    a, b, c = (rest[faces[:, i]].astype(float) for i in range(3))
    side = np.abs(np.cross(b - a, c - a)).argmax(axis=1)
    corners = faces.astype(np.int64) * 3 + side[:, None]
    kept, index = np.unique(corners, return_inverse=True)
    source = kept // 3
    planes = _PLANES[kept % 3]
    planes = np.where(planes[:, 1:] == longest[source, None], planes[:, ::-1], planes)
    uv = np.take_along_axis(rest[source], planes, axis=1)
    new_faces = index.reshape(faces.shape).astype(np.uint32)
    return Unwrapped(source.astype(np.uint32), new_faces, uv.astype(np.float32))


def build_mesh(group: MeshGroup, meshes: Sequence[Mesh], material: Material) -> mi.Mesh:
    """Return a group as a new Mitsuba mesh."""
    props = mi.Properties()
    props["mesh_bsdf"] = material_bsdf(
        material,
        group.surface,
        group.warned is not None,
        group.footprints,
        has_colors=group.has_colors,
        has_cover=group.cover is not None,
        wear=group.wear,
    )
    unwrapped = group.unwrapped
    if unwrapped:
        count = len(unwrapped.source)
    else:
        count = sum(len(meshes[i].vertices) for i in group.members)
    if material.glow > 0.0:
        props["mesh_emitter"] = mi.load_dict(area_emitter(material))
    mesh = mi.Mesh(
        group.material,
        count,
        len(group.faces),
        props=props,
        has_vertex_normals=group.smooth,
        has_vertex_texcoords=unwrapped is not None,
    )
    for name in share_names(group.share_material):
        mesh.add_attribute(name, 1, [0.0] * count)
    if group.warned is not None:
        share = _vertex_share(group.warned, group.faces)
        mesh.add_attribute(WARNED, 1, (share[unwrapped.source] if unwrapped else share).tolist())
    if group.has_colors:
        mesh.add_attribute(VERTEX_COLOR, 3, [0.0] * (3 * count))
    if group.cover is not None:
        mesh.add_attribute(COVER_COLOR, 3, [0.0] * (3 * count))
        mesh.add_attribute(COVER_SHARE, 1, [0.0] * count)
    values = mi.traverse(mesh)
    if group.cover is not None:
        cover = group.cover[unwrapped.source] if unwrapped else group.cover
        _write(values, COVER_COLOR, cover[:, :3])
        _write(values, COVER_SHARE, cover[:, 3])
    _write(values, "faces", unwrapped.faces if unwrapped else group.faces)
    if group.has_colors:
        of_members = [meshes[i].colors for i in group.members]
        colors = _joined([colors for colors in of_members if colors is not None])
        base = linear(material.color).astype(np.float32)
        # White scenery is large: its colours are not copied.
        _write(values, VERTEX_COLOR, colors if (base == 1.0).all() else colors * base)
    if unwrapped:
        _write(values, "vertex_texcoords", unwrapped.uv)
    update_vertices(values, "", group, meshes)
    values.update()
    return mesh


def update_vertices(values: Any, prefix: str, group: MeshGroup, meshes: Sequence[Mesh]) -> None:
    """Write the vertices of a group in this frame to Mitsuba's parameters.

    Raises:
        ShotError: a vertex is not finite.
    """
    vertices = _joined([meshes[i].vertices for i in group.members])
    vertices = np.ascontiguousarray(vertices, np.float32)
    if not np.isfinite(vertices).all():
        raise ShotError(f"a vertex of material {group.material!r} is not finite")
    source = slice(None) if group.unwrapped is None else group.unwrapped.source
    _write(values, prefix + "vertex_positions", vertices[source])
    if group.smooth:
        if group.given_normals:
            given = [meshes[i].normals for i in group.members]
            normals = _joined([n for n in given if n is not None])
        else:
            normals = vertex_normals(vertices, group.faces)
        _write(values, prefix + "vertex_normals", normals[source])
        if group.share_material is not None:
            shares = vertex_shares(group.share_material, vertices, normals)
            for name, share in shares.items():
                _write(values, prefix + name, share[source])


def update_footprints(values: Any, prefix: str, count: int) -> None:
    """Write the number of footprints made so far to Mitsuba's parameters of ground."""
    name = f"{prefix}bsdf.{FOOTPRINT_COUNT}"
    if name in values:
        values[name] = dr.opaque(type(values[name]), count)


def has_moved(group: MeshGroup, before: Sequence[Mesh], now: Sequence[Mesh]) -> bool:
    """Whether the vertices of any mesh of a group have changed."""
    return any(
        before[i] is not now[i]
        and before[i].vertices is not now[i].vertices
        and not np.array_equal(before[i].vertices, now[i].vertices)
        for i in group.members
    )


def _vertex_share(warned: NDArray[np.bool_], faces: NDArray[np.uint32]) -> NDArray[np.float32]:
    """Return the share of warned faces around each vertex, (V,)."""
    corners, values = faces.ravel(), np.repeat(warned.astype(float), 3)
    count = np.bincount(corners)
    return (np.bincount(corners, values) / np.maximum(count, 1)).astype(np.float32)


def _write(values: Any, name: str, array: NDArray[Any]) -> None:
    # The type of a buffer differs between the variants of Mitsuba.
    values[name] = type(values[name])(np.ascontiguousarray(array.ravel()))
