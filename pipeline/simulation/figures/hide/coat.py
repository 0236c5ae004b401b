"""Coats: the paint of an animal's hide by part of the body."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.hide.head import Head, _lay
from pipeline.simulation.figures.hide.sheets import Paint
from pipeline.simulation.figures.hide.stance import Stance, smoothstep
from pipeline.simulation.figures.solids import Solid
from pipeline.simulation.spatial import Array, cross, normalized

PATTERN_SIZES: Mapping[str, float] = {"spots": 0.42, "patches": 0.75, "stripes": 0.55}
"""Distance of a pattern's figures, in the body's radius."""


@dataclass(frozen=True, eq=False)
class Coat:
    """The paint of the surfaces of one animal.

    Attributes:
        stance: of the figure.
        head: None for a figure without a skull.
    """

    stance: Stance
    head: Head | None

    @cached_property
    def _girth(self) -> float:
        figure = self.stance.figure
        return float(figure.drawing.radii[list(figure.anatomy.body)].max()) * figure.scale

    def paint(self, solid: Solid, limbs: list[int], is_head: bool) -> Paint | None:
        """Return the paint of a surface, None where there is none.

        Args:
            solid: as the figure stands.
            limbs: numbers of the limbs that it covers.
            is_head: whether it is the skull's.
        """
        config = self.stance.figure.skin
        if not config.paint and not is_head:
            return None
        paint = np.zeros((len(solid.vertices), 4))
        at = _Places(self, solid, limbs, is_head)
        for layer in config.paint:
            share = at.share(layer.where, layer.size)
            if share is not None:
                _lay(paint, layer.color, layer.share * share)
        if is_head and self.head is not None:
            over = self.head.paint(solid.vertices)
            keep = (1.0 - over[:, 3:]) * paint[:, 3:]
            total = keep + over[:, 3:]
            mixed = (keep * paint[:, :3] + over[:, 3:] * over[:, :3]) / np.maximum(total, 1e-9)
            paint = np.concatenate([mixed, total], axis=1)
        return paint


class _Places:
    """The shares of the parts of a hide at its vertices."""

    def __init__(self, coat: Coat, solid: Solid, limbs: list[int], is_head: bool) -> None:
        self._coat, self._places, self._is_head = coat, solid.vertices, is_head
        self._normals = vertex_normals(solid)
        stance = coat.stance
        figure = stance.figure
        body = stance._body_distance(self._places)
        found = [body]
        self._limbs = limbs
        self._along = [np.zeros(len(body))]
        for i in limbs:
            chain = stance.chains[i]
            distances = chain.distances(self._places)
            found.append(distances.min(axis=0))
            self._along.append(chain.coordinates(self._places, distances))
        self._part = np.argmin(found, axis=0)
        self._kinds = ["body", *(figure.skeleton.limbs[i].kind for i in limbs)]

    def _of(self, kinds: tuple[str, ...]) -> NDArray[np.bool_]:
        return np.isin(self._part, [k for k, kind in enumerate(self._kinds) if kind in kinds])

    def _share_along(self, kind: str, first: float, soft: float) -> Array:
        """Return the share of limbs of a kind beyond a share of their length."""
        result = np.zeros(len(self._places))
        for k, own in enumerate(self._kinds):
            if own != kind:
                continue
            chain = self._coat.stance.chains[self._limbs[k - 1]]
            mine = np.flatnonzero(self._part == k)
            at = arc_share(chain.points, self._places[mine])
            result[mine] = smoothstep((at - first) / soft + 0.5)
        return result

    def share(self, place: str, size: float | None) -> Array | None:
        """Return the share (V,) of a part, None where the surface has nothing of it."""
        up, p = self._normals[:, 1], self._places
        flesh = self._of(("body", "leg", "arm"))
        trunk = self._of(("body",))
        match place:
            case "belly":
                near = smoothstep((0.45 - arc_all(self, "leg")) / 0.2)
                return smoothstep((-up - 0.15) / 0.5) * np.where(trunk, 1.0, np.where(flesh, near * 0.8, 0.0))
            case "back":
                return smoothstep((up - 0.25) / 0.5) * np.where(trunk, 1.0, 0.0)
            case "body":
                return np.where(trunk | flesh, 1.0, 0.0)
            case "throat":
                head = self._of(("head",))
                return smoothstep((-up - 0.1) / 0.4) * head
            case "neck":
                return np.where(self._of(("head",)) & (not self._is_head), 1.0, 0.0)
            case "face":
                return np.full(len(p), 1.0 if self._is_head else 0.0)
            case "muzzle":
                head = self._coat.head
                if not self._is_head or head is None:
                    return None
                x = ((p - head.back) * head.axes[0]).sum(axis=-1) / head.length
                return smoothstep((x - head.skull.muzzle_from) / 0.16 + 0.5)
            case "legs":
                return self._share_along("leg", 0.18, 0.15)
            case "shins":
                return self._share_along("leg", 0.58, 0.16)
            case "feet":
                return self._share_along("leg", 0.90, 0.08)
            case "arms":
                return self._share_along("arm", 0.5, 0.3)
            case "tail":
                return self._share_along("tail", 0.05, 0.1)
            case "tail tip":
                return self._share_along("tail", 0.72, 0.12)
            case "spots" | "patches" | "stripes":
                return self._pattern(place, size)
        return None

    def _pattern(self, kind: str, size: float | None) -> Array:
        """Return a pattern of the coat, symmetric on no side."""
        p = self._places
        step = (size or PATTERN_SIZES[kind]) * self._coat._girth
        if kind == "stripes":
            wave = p[:, 0] / step + 0.35 * np.sin(p[:, 1] / step * 1.7) + 0.2 * np.sin(
                p[:, 2] / step * 2.3
            )
            top = smoothstep((self._normals[:, 1] + 0.9) / 0.6)
            return smoothstep((np.sin(2.0 * np.pi * wave) - 0.15) / 0.35) * top
        nearest, second = _cell_distances(p / step)
        if kind == "spots":
            return smoothstep((0.36 - nearest) / 0.10)
        return smoothstep((second - nearest - 0.10) / 0.06)


def arc_all(places: _Places, kind: str) -> Array:
    """Return how far along limbs of a kind places lie, 0 to 1; 0 elsewhere."""
    return places._share_along(kind, 0.5, 1.0)


def arc_share(points: Array, places: Array) -> Array:
    """Return how far along a polyline (n, 3) places (N, 3) lie, 0 to 1."""
    spans = np.diff(points, axis=0)
    lengths = np.maximum(np.linalg.norm(spans, axis=-1), 1e-9)
    starts = np.concatenate([[0.0], np.cumsum(lengths)])
    best, found = np.full(len(places), np.inf), np.zeros(len(places))
    for k, (a, span, length) in enumerate(zip(points[:-1], spans, lengths, strict=True)):
        along = np.clip(((places - a) * span).sum(axis=-1) / length**2, 0.0, 1.0)
        off = np.linalg.norm(places - a - along[:, None] * span, axis=-1)
        found = np.where(off < best, starts[k] + along * length, found)
        best = np.minimum(off, best)
    return np.asarray(found / starts[-1])


def vertex_normals(solid: Solid) -> Array:
    """Return the unit normals (V, 3) of a surface."""
    faces = solid.faces.astype(int)
    a, b, c = (solid.vertices[faces[:, k]] for k in range(3))
    face = cross(b - a, c - a)
    normals = np.stack(
        [
            sum(np.bincount(faces[:, k], face[:, axis], len(solid.vertices)) for k in range(3))
            for axis in range(3)
        ],
        axis=-1,
    )
    return normalized(normals)


def _cell_distances(p: Array) -> tuple[Array, Array]:
    """Return the distances to the nearest and the second nearest point of a jittered grid.

    Source: Worley 1996, with an integer hash of the cell.
    """
    cell = np.floor(p).astype(np.int64)
    found = []
    for shift in np.ndindex(3, 3, 3):
        c = cell + np.array(shift) - 1
        h = (c[:, 0] * 73856093) ^ (c[:, 1] * 19349663) ^ (c[:, 2] * 83492791)
        jitter = np.stack([((h >> k) & 255) / 255.0 for k in (3, 9, 15)], axis=-1)
        found.append(np.linalg.norm(c + 0.15 + 0.7 * jitter - p, axis=-1))
    nearest = np.sort(found, axis=0)
    return nearest[0], nearest[1]
