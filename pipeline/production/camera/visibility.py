"""Visibility: how a camera sees a subject, from the meshes of a take as they are rendered.

Lines of sight run from the eye to points all over the subject and are tested against the triangles
of the other performers and against the ground.

Source: T. Möller, B. Trumbore, Fast, Minimum Storage Ray-Triangle Intersection, J. Graphics Tools
    2(1), 1997. A. Van Oosterom, J. Strackee, The Solid Angle of a Plane Triangle, IEEE Trans.
    Biomed. Eng. 30(2), 1983, eq. 8.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.production.camera.clearance import VisibleGround
from pipeline.production.shots.skinning import Skin, visible_parts
from pipeline.simulation.spatial import Array, normalized
from pipeline.simulation.take import Part, Take
from render.shot import CameraPose

MAX_POINTS = 24
"""Parts of a subject to whose centres lines of sight run."""

THIN_VERTICES = 60
"""Vertices of each part by which boxes and sizes are known; triangles need all of them."""

BOX_MARGIN = 0.05
"""Widening of boxes for the vertices left out, relative to their size."""

NEAREST = 0.01
"""Depth from which a vertex counts as ahead of the camera [m]."""

SIGHT_END = 0.98
"""Fraction of a line of sight that must be clear, so that a subject may touch what is behind it."""

GROUND_STEPS = np.linspace(0.05, 0.95, 24)
"""Fractions of a line of sight at which the ground is looked up."""

HIDDEN = 0.8
"""Share of a subject's points in the frame from which it counts as hidden."""

GROUND = "terrain"
"""Name of the ground as a blocker."""


@dataclass(frozen=True, slots=True)
class Sight:
    """How a camera sees a subject at one frame.

    Attributes:
        framed: whether its bounding box overlaps the frame.
        extent: side of a square of that box's area, relative to the frame's height.
        hidden: share of its points in the frame that something else hides, where it is `HIDDEN`
            or more; else a lower bound of it.
        blocker: performer that hides most of them, or `GROUND`; "" for none.
    """

    framed: bool
    extent: float = 0.0
    hidden: float = 0.0
    blocker: str = ""

    @property
    def is_blocked(self) -> bool:
        """Whether so little is left of it that nobody can tell what it is."""
        return self.hidden >= HIDDEN


class Visibility:
    """The cast of a take, and its ground, as lines of sight meet them.

    Attributes:
        take: that is filmed.
        ground: of the take.
    """

    def __init__(self, take: Take, ground: VisibleGround, clear: Collection[str] = ()) -> None:
        """Prepare the meshes of a take.

        Args:
            take: that is filmed.
            ground: of the take.
            clear: materials that can be seen through.
        """
        self.take = take
        self.ground = ground
        self._parts = visible_parts(take)
        self._solid = np.array([part.material not in clear for part in self._parts], dtype=bool)
        self._skin = Skin.of(take) if self._parts else None
        self._thin = self._skin.thinned(THIN_VERTICES) if self._skin is not None else None
        self._posed: PosedCast | None = None

    def at(self, row: int) -> PosedCast | None:
        """Return the cast at a row of the take; None if nothing of it is visible."""
        if self._skin is None or self._thin is None:
            return None
        if self._posed is None or self._posed.row != row:
            world = self._thin.posed(self.take, float(row)).astype(float)
            starts = self._thin.starts
            low = np.minimum.reduceat(world, starts[:-1])
            high = np.maximum.reduceat(world, starts[:-1])
            living = np.array([part.life[0] <= row < part.life[1] for part in self._parts])
            self._posed = PosedCast(
                row=row,
                take=self.take,
                ground=self.ground,
                parts=self._parts,
                skin=self._skin,
                vertices=tuple(np.split(world, starts[1:-1])),
                low=low - BOX_MARGIN * (high - low),
                high=high + BOX_MARGIN * (high - low),
                shown=living & self.take.alive[row, self._thin.nodes[0][starts[:-1]]],
                solid=self._solid,
            )
        return self._posed


@dataclass(frozen=True, eq=False)
class PosedCast:
    """The P visible parts of a take at one row.

    Attributes:
        row: of the take.
        take: of the parts.
        ground: below them.
        parts: in order.
        skin: of the parts.
        vertices: (v, 3) some of each part [m].
        low: (P, 3) lower corners of their boxes [m].
        high: (P, 3) upper corners [m].
        shown: (P,) whether each is alive.
        solid: (P,) whether each hides what is behind it.
    """

    row: int
    take: Take
    ground: VisibleGround
    parts: tuple[Part, ...]
    skin: Skin
    vertices: tuple[Array, ...]
    low: Array
    high: Array
    shown: NDArray[np.bool_]
    solid: NDArray[np.bool_]

    def sight(self, names: Collection[str], camera: CameraPose, aspect: float) -> Sight | None:
        """Return how a camera sees the performers `names` together; None if none is alive."""
        own = np.array([part.performer in names for part in self.parts], dtype=bool)
        members = np.flatnonzero(own & self.shown)
        if not members.size:
            return None
        eye = np.array(camera.p_WC)
        seen, depth = _coordinates(
            np.concatenate([self.vertices[i] for i in members]), camera, aspect
        )
        seen = seen[depth > NEAREST]
        if not len(seen):
            return Sight(framed=False)
        low, high = seen.min(axis=0), seen.max(axis=0)
        extent = float(np.sqrt(np.prod(high - low) * aspect) / 2.0)
        if not ((low < 1.0) & (high > -1.0)).all():
            return Sight(framed=False, extent=extent)
        points = self._points(members)
        plane, depth = _coordinates(points, camera, aspect)
        inside = (depth > NEAREST) & (np.abs(plane) < 1.0).all(axis=-1)
        if not inside.any():
            return Sight(framed=True, extent=extent)
        hidden, blocker = self._hidden(eye, points[inside], self.shown & self.solid & ~own)
        return Sight(True, extent, float(hidden.mean()), blocker)

    def surrounding(self, eye: Array) -> str:
        """Return the performer inside whose mesh a point (3,) lies, "" for none."""
        around = ((self.low < eye) & (eye < self.high)).all(axis=-1) & self.shown & self.solid
        for i in np.flatnonzero(around).tolist():
            if _winding_number(self._triangles(i) - eye) > 0.5:
                return self.parts[i].performer
        return ""

    def _points(self, members: NDArray[np.int64]) -> Array:
        """Return points (n, 3) all over some parts: their centres, and the outermost six."""
        some = members[:: -(-len(members) // MAX_POINTS)]
        vertices = np.concatenate([self.vertices[i] for i in some])
        outer = np.concatenate([vertices.argmin(axis=0), vertices.argmax(axis=0)])
        return np.concatenate([0.5 * (self.low[some] + self.high[some]), vertices[outer]])

    def _hidden(
        self, eye: Array, points: Array, others: NDArray[np.bool_]
    ) -> tuple[NDArray[np.bool_], str]:
        """Return which points (n, 3) are hidden from the eye, and the name of what hides most."""
        ways = SIGHT_END * (points - eye)
        line = eye + GROUND_STEPS[:, None, None] * ways
        hidden: NDArray[np.bool_] = np.asarray(
            (self.ground.height(line) > line[..., 1]).any(axis=0)
        )
        crossed = others[:, None] & _box_hits(self.low, self.high, eye, ways)
        if (hidden | crossed.any(axis=0)).mean() < HIDDEN:
            # Triangles can only hide fewer points than their boxes.
            return hidden, ""
        counts = {GROUND: int(hidden.sum())}
        for i in np.flatnonzero(crossed.any(axis=1)).tolist():
            left = np.flatnonzero(crossed[i] & ~hidden)
            if not left.size:
                continue
            hits = _hits(self._triangles(i), eye, ways[left])
            hidden[left[hits]] = True
            name = self.parts[i].performer
            counts[name] = counts.get(name, 0) + int(hits.sum())
        most = max(counts, key=lambda name: counts[name])
        return hidden, most if counts[most] else ""

    def _triangles(self, i: int) -> Array:
        """Return the triangles (T, 3, 3) of a part [m]."""
        first, end = self.skin.starts[i : i + 2]
        return self._world[first:end][self.take.meshes[self.parts[i].seen].faces]

    @cached_property
    def _world(self) -> Array:
        """All vertices (V, 3) [m]."""
        return self.skin.posed(self.take, float(self.row)).astype(float)


def _coordinates(points: Array, camera: CameraPose, aspect: float) -> tuple[Array, Array]:
    """Return frame coordinates (n, 2), of which the frame spans -1 to 1, and depths (n,) [m]."""
    eye, target = np.array(camera.p_WC), np.array(camera.p_WT)
    ahead = normalized(target - eye)
    right = normalized(np.cross(ahead, np.array(camera.up)))
    relative = points - eye
    depth = relative @ ahead
    tangent = np.tan(np.radians(camera.fov_deg) / 2.0)
    plane = np.stack([relative @ right / aspect, relative @ np.cross(right, ahead)], axis=-1)
    return plane / (tangent * np.maximum(depth, NEAREST))[:, None], depth


def _box_hits(low: Array, high: Array, eye: Array, ways: Array) -> NDArray[np.bool_]:
    """Return which boxes (P, 3) are crossed by which segments from `eye` along `ways` (n, 3)."""
    safe = np.where(np.abs(ways) < 1e-12, 1e-12, ways)
    a, b = (low - eye)[:, None] / safe, (high - eye)[:, None] / safe
    first = np.minimum(a, b).max(axis=-1).clip(0.0)
    last = np.maximum(a, b).min(axis=-1).clip(None, 1.0)
    return np.asarray(first <= last)


def _hits(triangles: Array, eye: Array, ways: Array) -> NDArray[np.bool_]:
    """Return which segments from `eye` along `ways` (n, 3) meet any triangle (T, 3, 3)."""
    ends = np.concatenate([eye[None], eye + ways])
    near = (triangles.max(axis=1) >= ends.min(axis=0)) & (triangles.min(axis=1) <= ends.max(axis=0))
    triangles = triangles[near.all(axis=-1)]
    corner = triangles[:, 0]
    edge, other = triangles[:, 1] - corner, triangles[:, 2] - corner
    origin = eye - corner
    # The rest of the scalar triple products, which does not depend on the segment.
    normal, p, q = np.cross(edge, other), np.cross(other, origin), np.cross(origin, edge)
    det = -ways @ normal.T
    with np.errstate(divide="ignore", invalid="ignore"):
        u, v, t = ways @ p.T / det, ways @ q.T / det, (origin * normal).sum(axis=-1) / det
        met = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (t > 0.0) & (t < 1.0)
    return np.asarray((met & (np.abs(det) > 1e-15)).any(axis=-1))


def _winding_number(triangles: Array) -> float:
    """Return how often triangles (T, 3, 3) relative to a point enclose it: 1 inside, 0 outside."""
    a, b, c = (triangles[:, k] for k in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=-1) for v in (a, b, c))
    volume = (a * np.cross(b, c)).sum(axis=-1)
    below = la * lb * lc
    for first, second, length in ((a, b, lc), (b, c, la), (c, a, lb)):
        below = below + (first * second).sum(axis=-1) * length
    return float(abs(np.arctan2(volume, below).sum()) / (2.0 * np.pi))
