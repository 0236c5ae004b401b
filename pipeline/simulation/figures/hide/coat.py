"""Coats: the paint of an animal's hide by part of the body."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.hide.head import Head
from pipeline.simulation.figures.hide.sheets import Paint, lay
from pipeline.simulation.figures.hide.stance import Stance, smoothstep
from pipeline.simulation.figures.solids import Solid, vertex_normals
from pipeline.simulation.spatial import Array

PATTERN_SIZES: Mapping[str, float] = {"spots": 0.42, "patches": 0.75, "stripes": 0.55}
"""Distance of a pattern's figures, in the body's radius."""

NET, NET_EDGE = 0.05, 0.09
"""Half the width of the net between patches, and that of its edge, in the distance of patches."""

SEAM = 0.35
"""Width of the soft edge of a part of the body, in its girth."""

LIMB_PLACES: Mapping[str, tuple[str, float, float]] = {
    "legs": ("leg", 0.18, 0.15),
    "shins": ("leg", 0.66, 0.16),
    "feet": ("leg", 0.90, 0.08),
    "arms": ("arm", 0.50, 0.30),
    "tail": ("tail", 0.05, 0.10),
    "tail tip": ("tail", 0.72, 0.12),
}
"""Kind of limb of a part, where along it the part begins, and how softly, in its length."""


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
    def girth(self) -> float:
        """Greatest radius of the body [m]."""
        figure = self.stance.figure
        return float(figure.drawing.radii[list(figure.anatomy.body)].max()) * figure.scale

    def paint(
        self, solid: Solid, limbs: list[int], is_head: bool, has_face: bool = False
    ) -> Paint | None:
        """Return the paint of a surface, None where there is none.

        Args:
            solid: as the figure stands.
            limbs: numbers of the limbs that it covers.
            is_head: whether it is the skull's.
            has_face: whether the skull is a part of it.
        """
        config = self.stance.figure.skin
        if not config.paint and not is_head and not has_face:
            return None
        paint = np.zeros((len(solid.vertices), 4))
        at = _Places(self, solid, limbs, is_head)
        for layer in config.paint:
            share = at.share(layer.where, layer.size)
            if share is not None:
                lay(paint, layer.color, layer.share * share)
        if (is_head or has_face) and self.head is not None:
            over = self.head.paint(solid.vertices)
            keep = (1.0 - over[:, 3:]) * paint[:, 3:]
            total = keep + over[:, 3:]
            mixed = (keep * paint[:, :3] + over[:, 3:] * over[:, :3]) / np.maximum(total, 1e-9)
            paint = np.concatenate([mixed, total], axis=1)
        return paint

    def hair_factors(self, solid: Solid, limbs: list[int], is_head: bool) -> Array | float:
        """Return the factors (V,) on the length of the coat; see `paint`."""
        layers = [x for x in self.stance.figure.skin.paint if x.hair != 1.0]
        if not layers:
            return 1.0
        at = _Places(self, solid, limbs, is_head)
        result = np.ones(len(solid.vertices))
        for layer in layers:
            share = at.share(layer.where, layer.size)
            if share is not None:
                result *= 1.0 + (layer.hair - 1.0) * share
        return result


class _Places:
    """The shares of the parts of a hide at its vertices."""

    def __init__(self, coat: Coat, solid: Solid, limbs: list[int], is_head: bool) -> None:
        self._coat, self._places, self._is_head = coat, solid.vertices, is_head
        self._normals = vertex_normals(solid.vertices, solid.faces)
        stance = coat.stance
        figure = stance.figure
        body = stance.body_distance(self._places)
        found = [body]
        self._limbs = limbs
        self._along = [np.zeros(len(body))]
        for i in limbs:
            chain = stance.chains[i]
            distances = chain.distances(self._places)
            found.append(distances.min(axis=0))
            self._along.append(chain.coordinates(self._places, distances))
        self._distances = np.array(found)
        self._kinds = ["body", *(figure.skeleton.limbs[i].kind for i in limbs)]

    def _of(self, kinds: tuple[str, ...]) -> Array:
        """Return the share (V,) of limbs of some kinds: 1 on them, softly 0 beyond."""
        return self._nearest(np.isin(self._kinds, kinds))

    def _nearest(self, own: NDArray[np.bool_]) -> Array:
        """Return the share (V,) of some parts: 1 on them, softly 0 beyond."""
        if own.all() or not own.any():
            return np.full(self._distances.shape[1], float(own.all()))
        nearer = self._distances[~own].min(axis=0) - self._distances[own].min(axis=0)
        return smoothstep(nearer / (SEAM * self._coat.girth) + 0.5)

    def _share_along(self, kind: str, first: float, soft: float) -> Array:
        """Return the share of limbs of a kind beyond a share of their length."""
        result = np.zeros(len(self._places))
        for k, own in enumerate(self._kinds):
            if own != kind:
                continue
            chain = self._coat.stance.chains[self._limbs[k - 1]]
            mine = self._nearest(np.arange(len(self._kinds)) == k)
            some = np.flatnonzero(mine)
            at = arc_share(chain.points, self._places[some])
            share = mine[some] * smoothstep((at - first) / soft + 0.5)
            result[some] = np.maximum(result[some], share)
        return result

    def share(self, place: str, size: float | None) -> Array | None:
        """Return the share (V,) of a part, None where the surface has nothing of it."""
        if place in PATTERN_SIZES:
            return self._pattern(place, size)
        if place in LIMB_PLACES:
            return self._share_along(*LIMB_PLACES[place])
        places: dict[str, Callable[[], Array | None]] = {
            "belly": self._belly,
            "back": lambda: smoothstep((self._up - 0.25) / 0.5) * self._of(("body",)),
            "body": lambda: self._of(("body", "leg", "arm")),
            "throat": lambda: smoothstep((-self._up - 0.1) / 0.4) * self._of(("head",)),
            "neck": self._neck,
            "face": lambda: np.full(len(self._places), 1.0 if self._is_head else 0.0),
            "muzzle": self._muzzle,
        }
        # Ears and manes have surfaces of their own.
        return places[place]() if place in places else None

    def _neck(self) -> Array:
        return np.zeros(len(self._places)) if self._is_head else self._of(("head",))

    @property
    def _up(self) -> Array:
        return np.asarray(self._normals[:, 1])

    def _belly(self) -> Array:
        """Return the share of the underside, which ends on the thighs."""
        near = smoothstep((0.25 - self._share_along("leg", 0.5, 1.0)) / 0.2)
        limbs = 0.8 * near * self._of(("leg", "arm"))
        under = smoothstep((-self._up - 0.15) / 0.5)
        return under * np.maximum(self._of(("body",)), limbs)

    def _muzzle(self) -> Array | None:
        head = self._coat.head
        if not self._is_head or head is None:
            return None
        x = ((self._places - head.back) * head.axes[0]).sum(axis=-1) / head.length
        return smoothstep((x - head.skull.muzzle_from) / 0.16 + 0.5)

    def _pattern(self, kind: str, size: float | None) -> Array:
        """Return a pattern of the coat, symmetric on no side."""
        p = self._places
        step = (size or PATTERN_SIZES[kind]) * self._coat.girth
        if kind == "stripes":
            wave = (
                p[:, 0] / step
                + 0.35 * np.sin(p[:, 1] / step * 1.7)
                + 0.2 * np.sin(p[:, 2] / step * 2.3)
            )
            top = smoothstep((self._normals[:, 1] + 0.9) / 0.6)
            return smoothstep((np.sin(2.0 * np.pi * wave) - 0.15) / 0.35) * top
        nearest, second = _cell_distances(p / step)
        if kind == "spots":
            return smoothstep((0.36 - nearest) / 0.10)
        return smoothstep((second - nearest - NET) / NET_EDGE)


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
