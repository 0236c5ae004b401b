"""Face mesh: the skin of a head as a grid of rays, with slits between lids and between lips.

Columns and rows are directions from a place inside of the head: azimuth from the front, and
elevation. One row runs along the eyes and one along the mouth; there the grid is cut open, so that
lids and lips part. Behind each slit a pocket closes the surface.
Lengths are in heads, from the middle of the head: X forward, Y up, Z to the right.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.people.face_shape import NECK_TOP, FaceShape, face_field
from pipeline.simulation.people.signed_distance import Field
from pipeline.simulation.people.skinned_surface import ramp
from pipeline.simulation.spatial import Array, normalized

ORIGIN = np.array([-0.06, -0.05, 0.0])
"""Of the rays."""

NECK_END, NECK_END_SHARE = -0.62, 0.72
"""Height of the ring at which the rays end, and its radius in that of the neck around it."""

EYE_COLUMNS, BESIDE_EYE = 8, 4
"""Columns between the corners of an eye, and between the nose and the eye."""

BEHIND_EYE_DEG = np.array([3.0, 7.0, 12.0, 19.0, 28.0, 40.0, 55.0, 73.0, 94.0, 118.0])
"""Columns behind the outer corner of the eye, if that lay at 32 degrees."""

BELOW_MOUTH_DEG = np.array(
    [1.1, 2.4, 3.8, 5.3, 7.2, 10.0, 13.5, 18.0, 23.0, 28.0, 33.0, 38.5, 44.5]
)
ABOVE_MOUTH_DEG = np.array([0.9, 1.9, 3.0, 4.2, 5.6])
"""Rows below and above the mouth; the lowest one lies in the neck."""

ABOVE_EYE_DEG = np.array([2.0, 4.0, 6.2, 8.6, 11.2, 14.0, 17.5, 22.0, 28.0, 36.0, 46.0, 57.0, 69.0])
"""Rows above the eyes, if these lay at 8 degrees."""

MIDDLE_ROWS = 13
"""Rows between those of the mouth and that of the eyes, denser towards the eyes."""

UPPER_LIP_DEG, LOWER_LIP_DEG = 4.2, 5.4
"""Heights of the lips."""

UPPER_LIP, LOWER_LIP, LIP_GROOVE = 0.014, 0.018, 0.009
"""By how much lips stand out, and how deep they meet."""

UPPER_LID_DEG, LOWER_LID_DEG = 17.0, 13.0
"""Heights of the skin that goes with a lid."""

OPEN_UPPER, OPEN_LOWER = 0.35, 0.34
"""Heights of an open eye above and below its corners, in radii of the eyeball."""

SHUT_LOWER = 0.72
"""Height below the corners at which shut lids meet, in `OPEN_LOWER`."""

POCKET_DEPTH, POCKET_HEIGHT, POCKET_END = 0.05, 0.018, 0.16
"""Depth and half height of the mouth behind the lips, and depth at which it ends."""

LID_RIM = 0.93
"""Depth to which the rim of a lid goes, in radii of the eyeball."""

RAY_STEPS, RAY_LENGTH = 70, 0.75


def cast_rays(solid: Field, directions: Array) -> Array:
    """Return the places (n, 3) at which rays from `ORIGIN` leave a solid for good."""
    t = np.full(len(directions), RAY_LENGTH)
    for _ in range(RAY_STEPS):
        t = t - 0.9 * solid(ORIGIN + t[:, None] * directions)
    return ORIGIN + t[:, None] * directions


@dataclass(frozen=True, eq=False)
class FaceGrid:
    """The skin of a head, closed, with its mouth shut and its eyes open.

    Attributes:
        vertices: (V, 3).
        faces: (F, 3), counter-clockwise from outside.
        lips: (V,) share of the colour of lips.
        hollow: (V,) share of the darkness inside of the mouth.
        jaw: (V,) share that moves with the jaw.
        closing: (V, 3) offsets that close the lids.
        lid: (V,) share of the upper lids, negative of the lower ones.
        upper: (V,) 1 above the mouth, 0 below.
    """

    vertices: Array
    faces: NDArray[np.uint32]
    lips: Array
    hollow: Array
    jaw: Array
    closing: Array
    lid: Array
    upper: Array


def face_grid(face: FaceShape) -> FaceGrid:
    """Return the skin of a head."""
    return _Grid(face).woven()


def _angles(place: Array) -> tuple[float, float]:
    """Return azimuth and elevation of a place, seen from the origin of the rays [degrees]."""
    x, y, z = (place - ORIGIN).tolist()
    return float(np.degrees(np.arctan2(z, x))), float(np.degrees(np.arctan2(y, np.hypot(x, z))))


def _directions(azimuth: Array, elevation: Array) -> Array:
    a, e = np.radians(azimuth), np.radians(elevation)
    return np.stack([np.cos(e) * np.cos(a), np.sin(e), np.cos(e) * np.sin(a)], axis=-1)


@dataclass
class _Points:
    """Vertices behind the grid's own.

    Attributes:
        first: number of the first one.
        places: of each (3,).
        shut: places with the lids closed.
        traits: darkness, whether above the mouth, and share of the lid of each.
    """

    first: int
    places: list[Array] = field(default_factory=list)
    shut: list[Array] = field(default_factory=list)
    traits: list[tuple[float, bool, float]] = field(default_factory=list)

    def add(
        self,
        place: Array,
        shut: Array | None = None,
        hollow: float = 0.0,
        upper: bool = True,
        lid: float = 0.0,
    ) -> int:
        """Add a vertex, and return its number."""
        self.places.append(place)
        self.shut.append(place if shut is None else shut)
        self.traits.append((hollow, upper, lid))
        return self.first + len(self.places) - 1


class _Grid:
    """The grid of a face: R rows, those of the slits twice, of N columns around the head."""

    def __init__(self, face: FaceShape) -> None:
        self.face = face
        (eye, radius), (mouth, wide) = face.eye, face.mouth
        inner, _ = _angles(eye + np.array([0.075, 0.0, -radius]))
        outer, _ = _angles(eye + np.array([0.020, 0.0, 0.98 * radius]))
        self.eye_azimuth, self.eye_half = 0.5 * (inner + outer), 0.5 * (outer - inner)
        _, self.eye_elevation = _angles(eye + np.array([0.8 * radius, 0.0, 0.0]))
        _, self.mouth_elevation = _angles(mouth)
        columns = self._columns(inner, outer)
        corner, _ = _angles(mouth + np.array([-0.045, 0.0, wide]))
        self.mouth_end = int(np.argmin(np.abs(columns - corner)))
        self.mouth_half = float(columns[self.mouth_end])
        rows, below = self._rows()
        eye_row = len(rows) - len(ABOVE_EYE_DEG) - 1
        # From behind on the left over the front to the right.
        self.azimuth = np.concatenate([-columns[:0:-1], columns[:-1]])
        self.signed = np.arange(len(self.azimuth)) - (len(columns) - 1)
        self.column = np.abs(self.signed)
        elevation = np.insert(rows, [below, eye_row], [self.mouth_elevation, self.eye_elevation])
        # Of each slit the lower row; the upper one is the next.
        self.mouth_row, self.eye_row = below, eye_row + 1
        self.shape = len(elevation), len(self.azimuth)
        self.A = np.broadcast_to(self.azimuth, self.shape)
        self.E = np.broadcast_to(elevation[:, None], self.shape)
        level = np.arange(len(elevation))
        self.above_mouth = np.broadcast_to((level > self.mouth_row)[:, None], self.shape)
        self.above_eye = np.broadcast_to((level > self.eye_row)[:, None], self.shape)
        self.solid = face_field(face)

    @staticmethod
    def _columns(inner: float, outer: float) -> Array:
        """Return the azimuths of the right half from front to back, between corners of the eye."""
        eased = 0.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, EYE_COLUMNS + 1)))
        behind = outer + BEHIND_EYE_DEG * (180.0 - outer) / 148.0
        front = np.linspace(0.0, inner, BESIDE_EYE + 1)[:-1]
        return np.concatenate([front, inner + (outer - inner) * eased, behind, [180.0]])

    def _rows(self) -> tuple[Array, int]:
        """Return the elevations of the rows from below, and the number of that of the mouth."""
        mouth, eye = self.mouth_elevation, self.eye_elevation
        lip = mouth + ABOVE_MOUTH_DEG
        share = np.linspace(0.0, 1.0, MIDDLE_ROWS + 2)[1:-1]
        middle = lip[-1] + (eye - lip[-1]) * (1.0 - (1.0 - share) ** 1.25)
        top = eye + ABOVE_EYE_DEG * (90.0 - eye) / 82.0
        below = mouth - BELOW_MOUTH_DEG[::-1]
        return np.concatenate([below, [mouth], lip, middle, [eye], top]), len(below)

    def woven(self) -> FaceGrid:
        """Return the finished skin."""
        places, closed, lid = self._lidded()
        shift, lips = self._lips(places)
        places, closed = places + shift, closed + shift
        number = self._numbers()
        points = _Points(number.size)
        quads, triangles = self._sheet(number, points)
        for row, columns, m in self._slits():
            pocket = self._pocket(row, columns, m, number, places, closed, points)
            quads += pocket[0]
            triangles += pocket[1]
        q, t = np.array(quads), np.array(triangles)
        faces = np.concatenate([q[:, [0, 2, 1]], q[:, [0, 3, 2]], t[:, ::-1]])
        hollow, upper, more_lid = np.array(points.traits).T
        every = np.concatenate([places.reshape(-1, 3), points.places])
        shut = np.concatenate([closed.reshape(-1, 3), points.shut])
        # Outside of the slits their two rows are one.
        used, faces = np.unique(faces, return_inverse=True)
        upper = np.concatenate([self.above_mouth.ravel().astype(float), upper])[used]
        return FaceGrid(
            every[used],
            faces.reshape(-1, 3).astype(np.uint32),
            np.concatenate([lips.ravel(), np.zeros(len(hollow))])[used],
            np.concatenate([np.zeros(number.size), hollow])[used],
            self._jaw(every[used], upper),
            (shut - every)[used],
            np.concatenate([lid.ravel(), more_lid])[used],
            upper,
        )

    def _lidded(self) -> tuple[Array, Array, Array]:
        """Return the places (R, N, 3) of the grid, those with shut lids, and shares of lids."""
        u = (np.abs(self.A) - self.eye_azimuth) / self.eye_half
        almond = np.clip(1.0 - u * u, 0.0, None) ** 0.72
        eye, radius = self.face.eye
        distance = np.linalg.norm(eye + np.array([radius, 0.0, 0.0]) - ORIGIN)
        height = float(np.degrees(radius / distance))
        away = self.E - self.eye_elevation
        up = self.above_eye * np.clip(1.0 - away / UPPER_LID_DEG, 0.0, 1.0) ** 2
        low = ~self.above_eye * np.clip(1.0 + away / LOWER_LID_DEG, 0.0, 1.0) ** 2
        # The highest place of the opening lies nearer to the nose.
        opening = height * almond * (OPEN_UPPER * (1.0 - 0.12 * u) * up - OPEN_LOWER * low)
        shut = -SHUT_LOWER * OPEN_LOWER * height * almond * np.maximum(up, low)
        places = cast_rays(self.solid, _directions(self.A.ravel(), (self.E + opening).ravel()))
        places = places.reshape(*self.shape, 3)
        moves = opening != 0.0
        closed = places.copy()
        closed[moves] = cast_rays(self.solid, _directions(self.A[moves], (self.E + shut)[moves]))
        places[0] = closed[0] = self._neck_ring()
        return places, closed, np.where(moves, up - low, 0.0)

    def _neck_ring(self) -> Array:
        """Return the lowest row (N, 3), inside of the neck."""
        x, y = self.face.neck_base
        share = (NECK_END - NECK_TOP[1]) / (y - NECK_TOP[1])
        middle = np.array([NECK_TOP[0] + share * (x - NECK_TOP[0]), NECK_END, 0.0])
        around = _directions(self.azimuth, np.zeros(len(self.azimuth)))
        return middle + NECK_END_SHARE * self.face.neck * around

    def _lips(self, places: Array) -> tuple[Array, Array]:
        """Return by how much lips move the grid (R, N, 3), and the share of their colour."""
        off = self.E - self.mouth_elevation
        beside = np.abs(self.A) / self.mouth_half
        v = np.minimum(beside, 1.0)
        bow = 1.0 - 0.80 * v**1.6 - 0.16 * np.exp(-((v / 0.16) ** 2))
        curve = 1.0 - v**2.2
        above = self.above_mouth
        height = np.where(above, UPPER_LIP_DEG * bow, LOWER_LIP_DEG * curve)
        part = np.abs(off) / np.maximum(height, 0.05 * UPPER_LIP_DEG)
        is_lip = (part < 1.6) & (v < 1.0)
        bump = np.sin(np.pi * np.clip(0.12 + 0.88 * part, 0.0, 1.0) ** 0.8)
        bump *= is_lip * np.where(above, UPPER_LIP * curve**0.5, LOWER_LIP * curve**0.6)
        groove = LIP_GROOVE * np.exp(-((off / 1.5) ** 2)) * (1.0 - ramp(beside, 0.9, 1.3))
        outward = normalized(places - ORIGIN + np.array([0.0, 0.2, 0.0]))
        colour = np.where(is_lip, np.clip((1.12 - part) / 0.24, 0.0, 1.0), 0.0)
        return (bump - groove)[..., None] * outward, colour

    def _numbers(self) -> NDArray[np.int64]:
        """Return the numbers (R, N) of the vertices; outside of a slit its rows have the same."""
        number = np.arange(self.shape[0] * self.shape[1]).reshape(self.shape)
        eye = self.column - BESIDE_EYE
        in_eye = (eye > 0) & (eye < EYE_COLUMNS)
        for row, is_open in (
            (self.mouth_row, self.column < self.mouth_end),
            (self.eye_row, in_eye),
        ):
            number[row + 1, ~is_open] = number[row, ~is_open]
        return number

    def _sheet(
        self, number: NDArray[np.int64], points: _Points
    ) -> tuple[list[list[int]], list[list[int]]]:
        """Return quads and triangles of the grid, closed at the crown and in the neck."""
        after = np.roll(number, -1, axis=1)
        strips = [
            np.stack([number[r], after[r], after[r + 1], number[r + 1]], axis=-1)
            for r in range(len(number) - 1)
            if r not in (self.mouth_row, self.eye_row)
        ]
        crown = points.add(cast_rays(self.solid, np.array([[0.0, 1.0, 0.0]]))[0])
        base = points.add(self._neck_ring().mean(axis=0))
        caps = [
            np.stack([number[-1], after[-1], np.full(self.shape[1], crown)], axis=-1),
            np.stack([after[0], number[0], np.full(self.shape[1], base)], axis=-1),
        ]
        return np.concatenate(strips).tolist(), np.concatenate(caps).tolist()

    def _slits(self) -> list[tuple[int, NDArray[np.int64], float]]:
        """Return the lower row, the columns from corner to corner, and the side of each slit."""
        eye = self.column - BESIDE_EYE
        in_eye = (eye >= 0) & (eye <= EYE_COLUMNS)
        return [
            (self.mouth_row, np.flatnonzero(self.column <= self.mouth_end), 0.0),
            *(
                (self.eye_row, np.flatnonzero(in_eye & (self.signed * m > 0)), m)
                for m in (-1.0, 1.0)
            ),
        ]

    def _pocket(
        self,
        row: int,
        columns: NDArray[np.int64],
        m: float,
        number: NDArray[np.int64],
        places: Array,
        closed: Array,
        points: _Points,
    ) -> tuple[list[list[int]], list[list[int]]]:
        """Return quads and triangles of the pocket behind a slit."""
        quads, triangles = list[list[int]](), list[list[int]]()
        is_eye = row == self.eye_row
        end = self.face.mouth[0] - np.array([POCKET_END, 0.0, 0.0])
        middle = self.face.eye[0] * [1.0, 1.0, m] if is_eye else end
        deep = points.add(middle, hollow=0.0 if is_eye else 1.0)
        for side in (0, 1):
            margin = number[row + side, columns].tolist()
            ring = [
                self._rim(places[row + side, c], closed[row + side, c], m, side, c, points)
                for c in columns[1:-1].tolist()
            ]
            order = -1 if side else 1
            # Corners of the slit lie at both ends of the rim.
            rim = [margin[0], *ring, margin[-1]]
            for k in range(1, len(rim) - 2):
                quads.append([margin[k], margin[k + 1], rim[k + 1], rim[k]][::order])
            for k in range(len(rim) - 1):
                triangles.append([rim[k], rim[k + 1], deep][::order])
            triangles.append([margin[0], margin[1], ring[0]][::order])
            triangles.append([margin[-2], margin[-1], ring[-1]][::order])
        return quads, triangles

    def _rim(
        self, place: Array, shut: Array, m: float, side: int, column: int, points: _Points
    ) -> int:
        """Add the vertex behind one of the margin of a lid, or of a lip where `m` is 0."""
        sign = 1.0 if side else -1.0
        if m:
            middle, radius = self.face.eye[0] * [1.0, 1.0, m], LID_RIM * self.face.eye[1]
            behind, shut = (middle + radius * normalized(x - middle) for x in (place, shut))
            return points.add(behind, shut, lid=sign)
        height = POCKET_HEIGHT * (1.0 - (self.azimuth[column] / self.mouth_half) ** 2)
        behind = place + np.array([-POCKET_DEPTH, sign * height, 0.0])
        return points.add(behind, hollow=0.8, upper=side == 1)

    def _jaw(self, p: Array, upper: Array) -> Array:
        """Return how much vertices move with the jaw (V,)."""
        mouth, wide = self.face.mouth
        # Beside the mouth the cheek is drawn out between both.
        beside = ramp(np.abs(p[:, 2]), 0.55 * wide, 1.5 * wide)
        depth = ramp(p[:, 1], mouth[1] + 0.16, mouth[1] - 0.16)
        share = (1.0 - upper) * (1.0 - beside) + depth * beside
        # Not the neck.
        return share * ramp(p[:, 0], -0.06, 0.14) * ramp(p[:, 1], -0.60, -0.50)
