"""Limbs of one structure as arrays over limbs and moments, for fast kinematics.

Arrays are (components, joints, limbs, moments), so that one operation handles thousands of limbs
in cached memory. Each joint has a frame with its axis as z, and an x perpendicular to the next
axis as well: its value turns x and y in their plane, and a constant turn about x, the bend, leads
to the next axis. This is a third of the work of turning about constant axes of the creation frame.

Limbs of one structure have equally many joints of the same kinds, and the same vanishing
constants, which then cost nothing. So a limb's result does not depend on the other limbs to the
last bit; no sum depends on array sizes.

Source: Denavit and Hartenberg 1955, Sims 1987, 5.2; the origins stay at the joints, so that axes
may be parallel.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.ball_aim import BallAim, ball_joints, pick_limbs
from pipeline.simulation.figures.bend_path import BendPath, hangs
from pipeline.simulation.figures.fold_curve import has_foot
from pipeline.simulation.figures.foot_link import FootLink
from pipeline.simulation.figures.kinematics import LimbBatch
from pipeline.simulation.spatial import Array, cross, normalized

ROUNDING = 1e-12
"""Values nearer to 0 are rounding, in 1 or in a limb's length."""

Frame = tuple[Array, Array, Array, Array]
"""x, y and z of a frame and its origin relative to the base link, (3, l, m) each [m]."""


@dataclass(frozen=True, eq=False)
class ChainGroup:
    """The constants of l limbs with k joints each; a last axis of 1 stands for the moments.

    Attributes:
        rows: (l,) numbers of the limbs in their batch.
        slides: for each joint whether it slides along its axis instead of turning about it.
        used: for each joint which components of its way are not 0, whether the cosine of its bend
            is not, and whether there is a bend.
        base: (3, 3, l, 1) x, y, z of the first joint's frame before it moves.
        first: (3, l, 1) place of the first joint relative to the base link [m].
        offset: (k, l, 1) turn about z at joint value zero [rad].
        bend: (k, 2, l, 1) cosine and sine of the constant turn about x to the next axis.
        way: (k, 3, l, 1) to the next joint, or to the tip, in the joint's frame [m].
        home: (k, 3, 3, l, 1) x, y, z of the frames at joint values zero.
        lower, upper, preferred: (k, l, 1) [rad or m].
        lengths: (l, 1) stretched [m].
        path: of their bends, by distance.
        on_path: (l, 1) their numbers there.
        aim: of the ball joints at their bases; None where there are none.
        foot: their last links; None where these are no feet.
    """

    rows: NDArray[np.int64]
    slides: tuple[bool, ...]
    used: tuple[tuple[bool, ...], ...]
    base: Array
    first: Array
    offset: Array
    bend: Array
    way: Array
    home: Array
    lower: Array
    upper: Array
    preferred: Array
    lengths: Array
    path: BendPath
    on_path: NDArray[np.int64]
    aim: BallAim | None
    foot: FootLink | None

    def subset(self, chosen: slice | NDArray[np.int64]) -> ChainGroup:
        """Return some limbs alone; numbers may repeat."""
        of_limbs: dict[str, Any] = {
            name: pick_limbs(getattr(self, name), chosen)
            for name in self.__dataclass_fields__
            if name not in ("rows", "slides", "used", "path", "aim", "foot")
        }
        aim = None if self.aim is None else self.aim.subset(chosen)
        return replace(self, rows=self.rows[chosen], aim=aim, **of_limbs)

    def frames(self, q: Array) -> Iterator[Frame]:
        """Yield the frames of the joints at values `q` (k, l, m) [rad or m], then the tip's."""
        turns = [not slides for slides in self.slides]
        angle = self.offset + (q if all(turns) else q * np.reshape(turns, (-1, 1, 1)))
        cosines, sines = np.cos(angle), np.sin(angle)
        x, y, z = self.base
        p = self.first
        for j, (c, s) in enumerate(zip(cosines, sines, strict=True)):
            x, y = c * x + s * y, c * y - s * x
            if self.slides[j]:
                p = p + q[j] * z
            yield x, y, z, p
            *goes, leans, bends = self.used[j]
            for axis, far, there in zip((x, y, z), self.way[j], goes, strict=True):
                if there:
                    p = p + far * axis
            cosine, sine = self.bend[j]
            if bends and leans:
                y, z = cosine * y + sine * z, cosine * z - sine * y
            elif bends:
                y, z = sine * z, -sine * y
        yield x, y, z, p

    def rotation(self, j: int, frame: Frame) -> Array:
        """Return R_BJ (3, 3, l, m) of joint `j`, the identity at joint values zero."""
        x, y, z, _ = frame
        u, v, w = self.home[j]
        R = np.empty((3, *np.broadcast_shapes(x.shape, z.shape)))
        for column in range(3):
            R[:, column] = x * u[column] + y * v[column] + z * w[column]
        return R


def group_chains(batch: LimbBatch, owner: NDArray[np.int64]) -> list[ChainGroup]:
    """Return limbs grouped by structure, without those that have no joints.

    Args:
        batch: the limbs.
        owner: (L,) numbers of their creatures. Limbs of one creature with the same joints share a
            structure, so that few legs are still solved together.
    """
    base, offset, bend, way, home = _constants(batch)
    has_ball = ball_joints(batch)
    with_foot = has_ball & hangs(batch) & has_foot(batch)
    kinds = np.stack([has_ball, with_foot], axis=1)
    joints = np.concatenate([batch.is_joint, batch.prismatic, kinds], axis=1)
    leans, bends = bend[..., :1] != 0.0, (bend != [1.0, 0.0]).any(axis=-1, keepdims=True)
    used = np.concatenate([way != 0.0, leans, bends], axis=-1)
    families = defaultdict[tuple[int, bytes], list[int]](list)
    for row, own in enumerate(joints):
        families[int(owner[row]), own.tobytes()].append(row)
    makes = defaultdict[bytes, list[int]](list)
    for (_, own), alike in families.items():
        used[alike] = used[alike].any(axis=0)
        makes[own + used[alike[0]].tobytes()].extend(alike)
    found = []
    for numbers in makes.values():
        rows = np.array(numbers)
        k = int(batch.is_joint[rows[0]].sum())
        if not k:
            continue

        def last(values: Array, rows: NDArray[np.int64] = rows) -> Array:
            return np.ascontiguousarray(np.moveaxis(values[rows], 0, -1)[..., None])

        same = batch.rows(rows).first_joints(k)
        ball, foot = kinds[rows[0]].tolist()
        # Limbs that are alike share their paths.
        kinds_of = [getattr(same, f.name).reshape(len(rows), -1) for f in fields(same)]
        first, on_path = _first_of_each(np.concatenate(kinds_of, axis=1))
        each = same.rows(first)
        path = BendPath.of(each)
        found.append(
            ChainGroup(
                rows=rows,
                slides=tuple(batch.prismatic[rows[0], :k].tolist()),
                used=tuple(map(tuple, used[rows[0], :k].tolist())),
                base=last(base),
                first=last(batch.places[:, 0]),
                offset=last(offset[:, :k]),
                bend=last(bend[:, :k]),
                way=last(way[:, :k]),
                home=last(home[:, :k]),
                lower=last(batch.lower[:, :k]),
                upper=last(batch.upper[:, :k]),
                preferred=last(batch.preferred[:, :k]),
                lengths=last(batch.lengths),
                path=path,
                on_path=on_path[:, None],
                aim=BallAim.of(same) if ball else None,
                foot=FootLink.of(each, path) if foot else None,
            )
        )
    return found


def _first_of_each(values: Array) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the first rows (k,) of each kind of equal rows (l, n), and the kinds of all (l,)."""
    known = dict[bytes, int]()
    kinds = np.array([known.setdefault(row.tobytes(), len(known)) for row in values])
    return np.unique(kinds, return_index=True)[1], kinds


def _constants(batch: LimbBatch) -> tuple[Array, Array, Array, Array, Array]:
    """Return base (L, 3, 3), offset (L, n), bend (L, n, 2), way (L, n, 3), home (L, n, 3, 3)."""
    z, ends = batch.axes.copy(), np.concatenate([batch.places[:, 1:], batch.tips[:, None]], axis=1)
    for j in range(1, z.shape[1]):
        # Padding repeats the joint before it.
        z[:, j] = np.where(batch.is_joint[:, j, None], z[:, j], z[:, j - 1])
    after = np.concatenate([z[:, 1:], z[:, -1:]], axis=1)
    far = ends - batch.places
    normal = cross(z, after)
    sine = np.linalg.norm(normal, axis=-1, keepdims=True)
    # Along a common normal; between parallel axes along the link, whose way has one component then.
    least = np.eye(3)[np.argmin(np.abs(z), axis=-1)]
    sideways = _perpendicular(far, z)
    short = np.linalg.norm(sideways, axis=-1, keepdims=True) < 1e-6 * batch.lengths[:, None, None]
    x = np.where(sine > ROUNDING, normal / np.maximum(sine, ROUNDING), 0.0)
    x = np.where(sine > ROUNDING, x, np.where(short, least, sideways))
    # Twice: a normal of nearly parallel axes is not quite perpendicular to them.
    x = normalized(_perpendicular(normalized(_perpendicular(x, z)), z))
    home = np.stack([x, cross(z, x), z], axis=-2)
    bend = np.stack([_dot(z, after), _dot(normal, x)], axis=-1)
    bend[np.abs(bend) < ROUNDING] = 0.0
    bend[..., 0] = np.where(bend[..., 1] == 0.0, np.sign(bend[..., 0]), bend[..., 0])
    way = np.stack([_dot(far, home[:, :, i]) for i in range(3)], axis=-1)
    way[np.abs(way) < ROUNDING * batch.lengths[:, None, None]] = 0.0
    before = np.concatenate([x[:, :1], x[:, :-1]], axis=1)
    offset = np.arctan2(_dot(cross(before, x), z), _dot(before, x))
    return home[:, 0], offset, bend, way, home


def _dot(a: Array, b: Array) -> Array:
    return (a * b).sum(axis=-1)


def _perpendicular(v: Array, z: Array) -> Array:
    """Return the parts of `v` perpendicular to the unit vectors `z`."""
    return v - _dot(v, z)[..., None] * z
