"""Heads of animals: the skull, and where eyes and mouth are on it."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from pipeline.simulation.figures.hide.lumps import Lump, ball, cone, union_distance
from pipeline.simulation.figures.hide.sheets import Paint, lay
from pipeline.simulation.figures.hide.skulls import Skull
from pipeline.simulation.figures.hide.stance import Chain, segment_distance, smoothstep
from pipeline.simulation.spatial import UP, Array, cross, normalized
from pipeline.spec.skin import Skin as SkinConfig

SOCKET, SOCKET_DEPTH = 1.16, 0.36
"""Radius of the lids, and depth of their middle below that of the eye, in the eye's radius."""

RAY_STEPS = 121
"""Samples of a ray to the surface of a skull."""

MOUTH_SIDE, MOUTH_FRONT = 7, 4
"""Points of the mouth line along a side, and round the front of one."""

NOSE_WAY, NOSE_SUNK = (1.0, 0.05, 0.0), 0.35
"""Direction along and up in which a bare nose is set on the muzzle, and the depth of its middle in
the skin, in its length."""

FRONT = 0.92
"""Place along a head from which the mouth line goes round its front."""

SMILE = 0.16
"""Height by which the corner of a mouth is turned up, in the radius there."""

LIPS = 0.10
"""Width of the dark lips on either side of the mouth line, in the radius of the muzzle."""

SHADOW = 0.45
"""Share of the colour of the lids on the skull around them."""

HEAD_BLEND = 0.30
"""Width of the union of a head's lumps, in their radius."""


@dataclass(frozen=True, eq=False)
class Head:
    """A head as it stands.

    Attributes:
        skull: its shape.
        back: (3,) where the neck ends [m].
        axes: (3, 3) rows along, up and to the right.
        length: of the last link [m].
        radii: drawn at its back and its tip [m].
        eye_scale: size of the eyes, in the skull's own.
    """

    skull: Skull
    back: Array
    axes: Array
    length: float
    radii: tuple[float, float]
    eye_scale: float = 1.0

    @staticmethod
    def of(chain: Chain, skull: Skull, config: SkinConfig) -> Head:
        """Return the head at the end of a chain."""
        along = chain.ways[-1]
        side = normalized(cross(along, UP)) if abs(along[1]) < 0.98 else np.array([0.0, 0.0, 1.0])
        axes = np.stack([along, cross(side, along), side])
        size = config.head_size
        radii = (size * float(chain.radii[-2]), size * float(chain.radii[-1]))
        length = size * float(chain.lengths[-1])
        own = replace(
            skull,
            pupil=config.pupil or skull.pupil,
            whiskers=skull.whiskers if config.whiskers is None else config.whiskers,
        )
        return Head(own, chain.points[-2], axes, length, radii, config.eye_size)

    def radius(self, along: float) -> float:
        """Return the drawn radius at a share of the head's length [m]."""
        share = min(max(along, 0.0), 1.0)
        return self.radii[0] + (self.radii[1] - self.radii[0]) * share

    def place(self, at: tuple[float, float, float], side: float = 1.0) -> Array:
        """Return a place (3,) on the skull [m]; `side` -1 for the left."""
        r = self.radius(at[0])
        # Beyond the tip the head goes on by its radius.
        ahead = min(at[0], 1.0) * self.length + max(at[0] - 1.0, 0.0) * r / 0.3 * 1.0
        result: Array = np.array([ahead, at[1] * r, side * at[2] * r]) @ self.axes + self.back
        return result

    def way(self, direction: tuple[float, float, float], side: float = 1.0) -> Array:
        """Return a direction (3,) given along, up and to the side."""
        result: Array = normalized(np.array(direction) * [1.0, 1.0, side]) @ self.axes
        return result

    def lumps(self) -> Iterator[Lump]:
        """Yield the skull with its lids, nose and nostrils."""
        yield from self.bones()
        yield from self._features()

    def bones(self) -> Iterator[Lump]:
        """Yield the lumps of the skull without lids, nose and nostrils."""
        for a, b, r_a, r_b in self.skull.rows:
            s_a, s_b = self.radius(a[0]), self.radius(b[0])
            for side in (1.0, -1.0) if a[2] or b[2] else (1.0,):
                yield cone(
                    *(self.place(a, side), self.place(b, side)),
                    *((r_a[0] * s_a, r_a[1] * s_a), (r_b[0] * s_b, r_b[1] * s_b)),
                    HEAD_BLEND * min(s_a, s_b),
                    self.axes[1],
                )

    def _features(self) -> Iterator[Lump]:
        size = self.eye_radius
        for side in (1.0, -1.0):
            if self.skull.lids:
                at = self.eye(side) - SOCKET_DEPTH * size * self.way(self.skull.look, side)
                yield ball(at, (SOCKET * size,) * 3, self.skull.lids * size * 2.0)
        if self.nose is not None:
            nose = self.nose_extent
            yield ball(self.nose, nose.tolist(), 0.6 * float(nose.min()), self.axes)
        for hole, extent in self.skull.holes:
            r = self.radius(hole[0])
            for side in (1.0, -1.0):
                sizes = [r * value for value in extent]
                yield ball(self.place(hole, side), sizes, 0.12 * r, self.axes, carved=True)

    @cached_property
    def nose(self) -> Array | None:
        """The middle (3,) of a bare nose, which lies in the skin [m]; None without one."""
        if self.skull.nose is None:
            return None
        at = self.place(self.skull.nose[0])
        way = self.way(NOSE_WAY)
        hit = self._surface(list(self.bones()), at, way, NOSE_SUNK * float(self.nose_extent[0]))
        return at if hit is None else hit

    @property
    def nose_extent(self) -> Array:
        """Radii (3,) of a bare nose along, up and to the side [m]."""
        assert self.skull.nose is not None
        place, extent, _ = self.skull.nose
        return self.radius(place[0]) * np.array(extent)

    @property
    def eye_radius(self) -> float:
        """Radius of the eyes [m]."""
        return self.eye_scale * self.skull.eye_size * self.radius(self.skull.eye[0])

    def eye(self, side: float) -> Array:
        """Return the middle of an eye [m], which lies in its socket where it looks out."""
        return self._eyes[side]

    @cached_property
    def _eyes(self) -> dict[float, Array]:
        rows = list(self.bones())
        found = {}
        for side in (1.0, -1.0):
            at, look = self.place(self.skull.eye, side), self.way(self.skull.look, side)
            hit = self._surface(rows, at, look, self.skull.sunk * self.eye_radius)
            found[side] = at if hit is None else hit
        return found

    def _surface(self, lumps: list[Lump], start: Array, way: Array, depth: float) -> Array | None:
        """Return the outermost place (3,) on a ray that is so deep inside; None without one."""
        steps = np.linspace(-1.0, 2.0, RAY_STEPS) * max(self.radii)
        line = start + steps[:, None] * way
        inside = np.flatnonzero(union_distance(lumps, line) < -depth)
        return line[inside[-1]] if len(inside) else None

    def on_skin(self, place: Array) -> Array:
        """Return the place (3,) on the skin straight ahead or behind one near it [m]."""
        hit = self._surface(list(self.bones()), place, self.axes[0], 0.0)
        return place if hit is None else hit

    @cached_property
    def mouth(self) -> Array | None:
        """Places (n, 3) on the skin from the left corner of the mouth to the right one [m]."""
        if self.skull.mouth is None:
            return None
        x0, y0, x1, y1 = self.skull.mouth
        rows = list(self.bones())
        half = []
        turns = np.linspace(90.0, 0.0, MOUTH_FRONT + 1)[1:]
        rays = [(x, 90.0) for x in np.linspace(x0, FRONT, MOUTH_SIDE)]
        for x, turn in [*rays, *((FRONT, turn) for turn in turns)]:
            share = (x - x0) / (x1 - x0) if turn == 90.0 else 1.0
            y = y0 + (y1 - y0) * share + SMILE * max(1.0 - 3.0 * share, 0.0)
            way = self.way((float(np.cos(np.radians(turn))), 0.0, float(np.sin(np.radians(turn)))))
            hit = self._surface(rows, self.place((x, y, 0.0)), way, 0.0)
            if hit is not None:
                half.append((hit - self.back) @ self.axes.T)
        if len(half) < 3:
            return None
        right = np.array(half)
        both = np.concatenate([right * [1.0, 1.0, -1.0], right[-2::-1]])
        result: Array = both @ self.axes + self.back
        return result

    def clearance(self, places: Array) -> Array:
        """Return the distances (N,) of places (N, 3) from eyes, nostrils and mouth [m]."""
        eyes = [
            np.linalg.norm(places - self.eye(side), axis=-1) - SOCKET * self.eye_radius
            for side in (1.0, -1.0)
        ]
        holes = [
            np.linalg.norm(places - self.place(at, side), axis=-1) - max(radii) * self.radius(at[0])
            for at, radii in self.skull.holes
            for side in (1.0, -1.0)
        ]
        lips = [] if self.mouth is None else [line_distance(places, self.mouth)]
        return np.maximum(np.min([*eyes, *holes, *lips], axis=0), 0.0)

    def paint(self, places: Array) -> Paint:
        """Return the paint of the head's surface at places (N, 3): nostrils, nose, mouth, lids."""
        paint = np.zeros((len(places), 4))
        if self.mouth is not None:
            off = line_distance(places, self.mouth) / (LIPS * self.radii[1])
            lay(paint, "#241512", 0.8 * smoothstep(1.5 - off))
        for at, radii in self.skull.holes:
            for side in (1.0, -1.0):
                away = ((places - self.place(at, side)) @ self.axes.T) / (
                    self.radius(at[0]) * np.array(radii)
                )
                off = np.sqrt((away * away).sum(axis=-1))
                lay(paint, "#120a08", smoothstep((1.35 - off) / 0.35))
        if self.skull.nose is not None and self.nose is not None:
            color = self.skull.nose[2]
            away = ((places - self.nose) @ self.axes.T) / self.nose_extent
            lay(paint, color, smoothstep((1.28 - np.sqrt((away * away).sum(axis=-1))) / 0.22))
        for side in (1.0, -1.0):
            off = np.linalg.norm(places - self.eye(side), axis=-1) / self.eye_radius
            lay(paint, self.skull.lid_color, SHADOW * smoothstep((1.30 - off) / 0.35))
        return paint


def line_distance(places: Array, line: Array) -> Array:
    """Return the distances (N,) of places (N, 3) from a polyline (n, 3) [m]."""
    spans = itertools.pairwise(line)
    return np.min([segment_distance(places, a, b, 0.0, 0.0) for a, b in spans], axis=0)
