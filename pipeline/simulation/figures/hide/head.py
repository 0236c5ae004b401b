"""Heads of animals: skull, eyes, ears and horns."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipeline.simulation.figures.hide.lumps import Lump, ball, cone
from pipeline.simulation.figures.hide.sheets import Paint, lay, linear_color, outward
from pipeline.simulation.figures.hide.skulls import Skull
from pipeline.simulation.figures.hide.stance import Chain, smoothstep
from pipeline.simulation.figures.solids import Solid, loft
from pipeline.simulation.spatial import UP, Array, cross, normalized

EYE_AROUND = 12

EYE_ANGLES = np.radians([8, 15, 20, 26, 34, 41, 47, 54, 66, 88, 120, 150])
"""Rings of an eyeball from where it looks [rad]: fine where pupil and iris end."""

PUPIL_DEG, IRIS_DEG = 21.0, 46.0

SOCKET, SOCKET_DEPTH = 1.20, 0.42
"""Radius of the lids, and depth of their middle below that of the eye, in the eye's radius."""

SCLERA = "#1e1611"
"""Colour of what is seen of an eye around its iris: animals show no white."""

SUNK = 0.30
"""Depth of the middle of an eye below the skull, in the eye's radius."""

HEAD_BLEND = 0.34
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
    def of(chain: Chain, skull: Skull, eye_scale: float) -> Head:
        """Return the head at the end of a chain."""
        along = chain.ways[-1]
        side = normalized(cross(along, UP)) if abs(along[1]) < 0.98 else np.array([0.0, 0.0, 1.0])
        axes = np.stack([along, cross(side, along), side])
        radii = (float(chain.radii[-2]), float(chain.radii[-1]))
        return Head(skull, chain.points[-2], axes, float(chain.lengths[-1]), radii, eye_scale)

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
        yield from self._bones()
        yield from self._features()

    def _bones(self) -> Iterator[Lump]:
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
        if self.skull.nose is not None:
            place, extent, _ = self.skull.nose
            r = self.radius(place[0])
            yield ball(self.place(place), [r * v for v in extent], 0.25 * r, self.axes)
        for hole, extent in self.skull.holes:
            r = self.radius(hole[0])
            for side in (1.0, -1.0):
                sizes = [r * value for value in extent]
                yield ball(self.place(hole, side), sizes, 0.12 * r, self.axes, carved=True)

    @property
    def eye_radius(self) -> float:
        """Radius of the eyes [m]."""
        return self.eye_scale * self.skull.eye_size * self.radius(self.skull.eye[0])

    def eye(self, side: float) -> Array:
        """Return the middle of an eye [m], which lies in its socket where it looks out."""
        return self._eyes[side]

    @cached_property
    def _eyes(self) -> dict[float, Array]:
        rows = list(self._bones())
        found = {}
        for side in (1.0, -1.0):
            at, look = self.place(self.skull.eye, side), self.way(self.skull.look, side)
            steps = np.linspace(-1.0, 2.0, 121) * self.radius(self.skull.eye[0])
            line = at + steps[:, None] * look
            depth = np.min([bone.distance(line) for bone in rows], axis=0)
            inside = np.flatnonzero(depth < -SUNK * self.eye_radius)
            found[side] = line[inside[-1]] if len(inside) else at
        return found

    def paint(self, places: Array) -> Paint:
        """Return the paint of the head's surface at places (N, 3): nostrils, nose, mouth, lids."""
        paint = np.zeros((len(places), 4))
        r = self.radii[1]
        seen = (places - self.back) @ self.axes.T
        if self.skull.mouth is not None:
            x0, y0, x1, y1 = self.skull.mouth
            a, b = self.place((x0, y0, 0.0)), self.place((x1, y1, 0.0))
            (ax, ay, _), (bx, by, _) = ((p - self.back) @ self.axes.T for p in (a, b))
            along = np.clip((seen[:, 0] - ax) / (bx - ax), 0.0, 1.0)
            off = np.hypot(
                seen[:, 1] - (ay + along * (by - ay)), np.maximum(ax - seen[:, 0], 0.0) * 1.0
            )
            lay(paint, "#241512", 0.9 * smoothstep(1.6 - off / (0.085 * r)))
        for at, radii in self.skull.holes:
            for side in (1.0, -1.0):
                away = ((places - self.place(at, side)) @ self.axes.T) / (
                    self.radius(at[0]) * np.array(radii)
                )
                off = np.sqrt((away * away).sum(axis=-1))
                lay(paint, "#120a08", smoothstep((1.35 - off) / 0.35))
        if self.skull.nose is not None:
            at, radii, color = self.skull.nose
            away = ((places - self.place(at)) @ self.axes.T) / (
                self.radius(at[0]) * np.array(radii)
            )
            lay(paint, color, smoothstep((1.28 - np.sqrt((away * away).sum(axis=-1))) / 0.22))
        for side in (1.0, -1.0):
            off = np.linalg.norm(places - self.eye(side), axis=-1) / self.eye_radius
            lay(paint, "#17100c", 0.92 * smoothstep((1.22 - off) / 0.25))
        return paint

    def eyeball(self, side: float, iris: str) -> tuple[Solid, Paint]:
        """Return an eye with iris and pupil, and its paint."""
        look = self.way(self.skull.look, side)
        across = normalized(cross(look, self.axes[0]))
        across = across if across[1] > 0 else -across
        other = cross(look, across)
        azimuth = np.arange(EYE_AROUND) * (2.0 * np.pi / EYE_AROUND)
        flat = np.cos(azimuth)[:, None] * across + np.sin(azimuth)[:, None] * other
        size = self.eye_radius
        rings = self.eye(side) + size * (
            np.cos(EYE_ANGLES)[:, None, None] * look + np.sin(EYE_ANGLES)[:, None, None] * flat
        )
        ends = np.stack([self.eye(side) + size * look, self.eye(side) - size * look])
        solid = outward(loft(rings, ends))
        angles = np.degrees(np.concatenate([np.repeat(EYE_ANGLES, EYE_AROUND), [0.0, np.pi]]))
        turned = np.concatenate([np.tile(azimuth, len(EYE_ANGLES)), [0.0, 0.0]])
        pupils = {"round": (1.0, 1.0), "slit": (1.7, 0.45), "bar": (0.65, 1.35)}
        tall, wide = pupils[self.skull.pupil]
        shape = np.hypot(np.cos(turned) / tall, np.sin(turned) / wide)
        paint = np.concatenate(
            [np.tile(linear_color(SCLERA), (len(angles), 1)), np.ones((len(angles), 1))], axis=1
        )
        lay(paint, "#0d0907", smoothstep((IRIS_DEG + 10.0 - angles) / 8.0))
        lay(paint, iris, smoothstep((IRIS_DEG - angles) / 6.0))
        lay(paint, "#050404", smoothstep((PUPIL_DEG - angles * shape) / 5.0 + 0.5))
        return solid, paint
