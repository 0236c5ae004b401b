"""Shells: plates and segments of the bodies of arthropods, by kind.

Plates meet in creases: their lumps are joined with hardly any blend.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.hide.lumps import Lump, ball, cone
from pipeline.simulation.figures.hide.sheets import Paint, outward, painted
from pipeline.simulation.figures.hide.stance import Stance
from pipeline.simulation.figures.hide.wing_cases import ShellPlan
from pipeline.simulation.figures.network import HEAD, TAIL
from pipeline.simulation.figures.solids import Solid, loft
from pipeline.simulation.spatial import Array

SHIELD_EDGE = "#1c0a06"

CREASE = 0.10
"""Width of the union of two plates, in their radius."""

ON_MIDLINE = 1e-6
"""Distance from the midline of what is on it [m]."""


@dataclass(frozen=True, eq=False)
class Axis:
    """The midline of an arthropod as it stands, from front to back.

    Attributes:
        body: (n, 3) nodes of the body on it [m].
        radii: (n,) drawn at them [m].
        head: (m, 3) nodes of the head from the body outward.
        head_radii: (m,) of them.
        tail: (k, 3) nodes of the tail from the body outward.
        tail_radii: (k,) of them.
    """

    body: Array
    radii: Array
    head: Array
    head_radii: Array
    tail: Array
    tail_radii: Array

    @staticmethod
    def of(stance: Stance) -> Axis:
        """Return the midline of a figure."""
        figure: Figure = stance.figure
        radii = figure.drawing.radii * figure.scale
        middle = [n for n in figure.anatomy.body if abs(figure.points[n, 2]) < ON_MIDLINE]
        middle = middle or list(figure.anatomy.body)
        middle.sort(key=lambda n: -float(figure.points[n, 0]))
        ends: dict[str, tuple[Array, Array]] = {}
        for chain in stance.chains:
            if chain.limb.kind in (HEAD, TAIL):
                ends.setdefault(chain.limb.kind, (chain.points, chain.radii))
        nothing = np.zeros((0, 3)), np.zeros(0)
        return Axis(
            figure.points[middle],
            radii[middle],
            *ends.get(HEAD, nothing),
            *ends.get(TAIL, nothing),
        )

    @property
    def rear(self) -> tuple[Array, float]:
        """The last node and its radius."""
        if len(self.tail):
            return self.tail[-1], float(self.tail_radii[-1])
        return self.body[-1], float(self.radii[-1])


def front_of(stance: Stance) -> tuple[Array, float]:
    """Return the foremost node of a body (3,), and its radius [m]."""
    axis = Axis.of(stance)
    return axis.body[0], float(axis.radii[0])


def body_plates(kind: str, stance: Stance) -> dict[str, list[Lump]]:
    """Return the plates of trunk, head and tail: "body", "head" and "tail".

    Args:
        kind: beetle, ant, spider, scorpion, centipede, crab or plain.
        stance: of the figure.
    """
    axis = Axis.of(stance)
    if kind == "beetle":
        return {"body": list(_beetle(beetle_plan(stance))), HEAD: list(_head(axis, 0.72, 1.0))}
    if kind == "crab":
        return {"body": list(_crab(axis))}
    if kind == "spider":
        return {
            "body": list(_spider(axis)),
            HEAD: list(_spider_head(axis)),
            TAIL: list(_spider_abdomen(axis)),
        }
    if kind in ("scorpion", "centipede"):
        rings = list(_rings(axis, 5 if kind == "scorpion" else 1))
        return {"body": rings, HEAD: list(_head(axis, 0.66, 1.15))}
    abdomen = list(_abdomen(axis, kind == "ant"))
    return {"body": list(_thorax(axis)), HEAD: list(_head(axis, 0.80, 1.0)), TAIL: abdomen}


def _plate(at: Array, radii: tuple[float, float, float], crease: float = CREASE) -> Lump:
    return ball(at, radii, crease * min(radii))


def beetle_plan(stance: Stance) -> ShellPlan:
    """Return where the upper plates of a beetle are."""
    axis = Axis.of(stance)
    front, r_f = axis.body[0], float(axis.radii[0])
    rear, r_r = axis.rear
    widest = float(axis.radii[1:].max()) if len(axis.radii) > 1 else r_f
    return ShellPlan(
        front=float(front[0]) + 0.80 * r_f,
        waist=float(front[0]) - 0.62 * r_f,
        rear=float(rear[0]) - 0.95 * r_r,
        rim=float(front[1]) + 0.06 * widest,
        half_width=1.12 * widest,
        height=0.66 * widest,
    )


def _beetle(plan: ShellPlan) -> Iterator[Lump]:
    """Yield what is below the upper plates: breast, and rings of the abdomen."""
    w, length = plan.half_width, plan.waist - plan.rear
    low = plan.rim - 0.06 * w
    breast = 0.5 * (plan.front + plan.waist)
    yield _plate(np.array([breast, low, 0.0]), (0.42 * w, 0.34 * w, 0.62 * w))
    yield _plate(np.array([plan.waist - 0.16 * length, low, 0.0]), (0.44 * w, 0.44 * w, 0.80 * w))
    for k in range(5):
        t = 0.34 + 0.13 * k
        size = float(plan.case_width(np.array([t]))[0])
        at = np.array([plan.waist - t * length, low, 0.0])
        yield _plate(at, (0.13 * length, 0.44 * size, 0.90 * size), 0.04)


def _head(axis: Axis, high: float, wide: float) -> Iterator[Lump]:
    """Yield the capsule of a head, and the neck behind it."""
    if not len(axis.head):
        return
    at, r = axis.head[-1], float(axis.head_radii[-1])
    for k in range(1, len(axis.head) - 1):
        s = float(axis.head_radii[k])
        yield _plate(axis.head[k], (0.9 * s, 0.62 * s, 0.88 * s))
    neck = 0.6 * min(r, float(axis.head_radii[0]))
    yield cone(axis.head[0], at, (0.7 * neck, neck), (0.7 * neck, neck), 0.1 * neck)
    yield _plate(at, (1.05 * r, high * r, wide * r))
    yield _plate(at + np.array([0.62 * r, -0.16 * r, 0.0]), (0.55 * r, 0.42 * r, 0.66 * r), 0.3)


def _thorax(axis: Axis) -> Iterator[Lump]:
    """Yield the segments of a body and what joins them."""
    count = len(axis.body)
    for k in range(count):
        r = float(axis.radii[k])
        yield _plate(axis.body[k], (1.02 * r, 0.80 * r, 0.92 * r))
    for k in range(count - 1):
        s = 0.55 * float(min(axis.radii[k], axis.radii[k + 1]))
        yield cone(axis.body[k], axis.body[k + 1], (s, s), (s, s), 0.5 * s)


def _abdomen(axis: Axis, is_ant: bool) -> Iterator[Lump]:
    """Yield the segments behind the body; an ant's last one has rings, on a thin waist."""
    rear = list(zip(axis.tail[1:], axis.tail_radii[1:], strict=True))
    before = axis.body[-1]
    for k, (at, radius) in enumerate(rear):
        r = float(radius)
        s = 0.5 * min(r, float(axis.tail_radii[k]))
        yield cone(before, at, (s, s), (s, s), 0.5 * s)
        if is_ant and k == len(rear) - 1 and r > 0.0:
            # The rings of the abdomen.
            for j in range(4):
                x = 0.62 - 0.42 * j
                size = r * (0.94, 1.02, 0.92, 0.62)[j]
                yield _plate(
                    at + np.array([x * r, 0.0, 0.0]), (0.62 * size, 0.86 * size, 0.92 * size), 0.05
                )
        else:
            yield _plate(at, (1.1 * r, 0.85 * r, 0.95 * r))
        before = at


def _spider(axis: Axis) -> Iterator[Lump]:
    """Yield the shield that carries the legs."""
    front, back = axis.body[0], axis.body[-1]
    r = float(axis.radii.max())
    yield cone(front, back, (0.74 * r, 1.0 * r), (0.70 * r, 1.05 * r), 0.3 * r)


def _spider_head(axis: Axis) -> Iterator[Lump]:
    """Yield the front of the shield, which carries the eyes."""
    if len(axis.head):
        at, s = axis.head[-1], float(axis.head_radii[-1])
        yield _plate(at - [0.35 * s, -0.18 * s, 0.0], (1.15 * s, 0.95 * s, 1.05 * s), 0.5)
        yield cone(axis.head[0], at, (0.8 * s, s), (0.8 * s, s), 0.3 * s)


def _spider_abdomen(axis: Axis) -> Iterator[Lump]:
    """Yield the round abdomen on its waist, with its spinnerets."""
    back = axis.body[-1]
    nodes, radii = axis.tail[1:], axis.tail_radii[1:]
    before = back
    for k, at in enumerate(nodes):
        s = float(radii[k])
        yield cone(before, at, (0.30 * s, 0.30 * s), (0.4 * s, 0.4 * s), 0.1 * s)
        if k == len(nodes) - 1:
            yield _plate(at + np.array([0.0, 0.10 * s, 0.0]), (1.20 * s, 0.92 * s, 0.98 * s))
            yield _plate(
                at + np.array([-0.25 * s, 0.14 * s, 0.0]), (1.0 * s, 0.90 * s, 1.02 * s), 0.4
            )
            for side in (-1.0, 1.0):
                tip = at + s * np.array([-1.34, -0.14, 0.13 * side])
                yield cone(at - [s, 0, 0], tip, (0.16 * s,) * 2, (0.08 * s,) * 2, 0.1 * s)
        before = at


def _rings(axis: Axis, between: int) -> Iterator[Lump]:
    """Yield overlapping plates along the body, each a little wider at its rear."""
    line = [*zip(axis.body, axis.radii, strict=True)]
    if between == 1:
        yield from _core(axis)
    else:
        front, r_f = line[0]
        yield _plate(front, (1.1 * float(r_f), 0.62 * float(r_f), 1.12 * float(r_f)), 0.1)
        start, end = (
            float(front[0]) - 0.55 * float(r_f),
            float(axis.body[-1][0]) - 0.75 * float(axis.radii[-1]),
        )
        places = np.linspace(start, end, between + 1)
        xs, rs = axis.body[::-1, 0], axis.radii[::-1]
        for x in places:
            r = float(np.interp(x, xs, rs))
            at = np.array([x, float(front[1]), 0.0])
            step = abs(float(places[1] - places[0]))
            yield _plate(at, (0.72 * step, 0.60 * r, 1.10 * r), 0.06)


def segment_line(axis: Axis) -> list[tuple[Array, float]]:
    """Return place and radius of the shields of a body in rings, that of the jaws first."""
    line = [(at, float(r)) for at, r in zip(axis.body, axis.radii, strict=True)]
    if len(axis.head) > 1:
        front, r = line[0]
        line.insert(0, (front + 0.55 * (axis.head[-1] - front), 0.82 * r))
    return line


def _core(axis: Axis) -> Iterator[Lump]:
    """Yield what is below the shields of a body in rings."""
    for (a, r_a), (b, r_b) in itertools.pairwise(segment_line(axis)):
        low = np.array([0.0, -0.12, 0.0])
        ends = (0.46 * r_a, 0.86 * r_a), (0.46 * r_b, 0.86 * r_b)
        yield cone(a + low * r_a, b + low * r_b, *ends, 0.0)


def shields(stance: Stance) -> Iterator[tuple[Solid, Paint]]:
    """Yield the shields on the back of a centipede, whose rear edges lie over the next."""
    line = segment_line(Axis.of(stance))
    for k, (at, r) in enumerate(line):
        behind = line[k + 1][0] if k + 1 < len(line) else at + (at - line[k - 1][0])
        before = line[k - 1][0] if k else at - (behind - at)
        # Neighbours are of unequal length, as those of centipedes are.
        share = 0.57 if k % 2 else 0.46
        yield _shield(at, r, at + share * (before - at), at + (share + 0.06) * (behind - at))


def _shield(at: Array, r: float, front: Array, rear: Array) -> tuple[Solid, Paint]:
    """Return one shield from front to rear, and its paint."""
    t = np.array([0.0, 0.06, 0.25, 0.6, 0.88, 0.97, 1.0])
    wide = r * np.array([0.80, 0.98, 1.08, 1.18, 1.24, 1.22, 1.08])
    high = r * np.array([0.40, 0.52, 0.58, 0.62, 0.66, 0.64, 0.50])
    angle = np.arange(14) * (2.0 * np.pi / 14)
    up, side = np.sin(angle), np.cos(angle)
    # Flat on top, with a keel at each side, and flat below.
    rise = np.where(up > 0.0, np.abs(up) ** 0.7, -0.35 * np.abs(up))
    out = np.sign(side) * np.abs(side) ** 0.75
    x = front[0] + t * (rear[0] - front[0])
    rings = np.stack(
        [
            np.broadcast_to(x[:, None], (len(t), 14)),
            at[1] - 0.05 * r + high[:, None] * rise,
            wide[:, None] * out,
        ],
        axis=-1,
    )
    solid = outward(loft(rings, rings.mean(axis=1)[[0, -1]]))
    dark = np.concatenate([np.repeat([0.7, 0.5, 0.1, 0.0, 0.1, 0.6, 0.8], 14), [0.7, 0.8]])
    return solid, painted(len(solid.vertices), SHIELD_EDGE, dark)


CRAB_BUMPS = ((0.42, 0.0, 0.20), (0.30, 0.52, 0.26), (-0.12, 0.0, 0.26), (-0.18, 0.70, 0.28))
"""Bumps on a carapace: place ahead and to the side, and radius, in that of the body."""


def _crab(axis: Axis) -> Iterator[Lump]:
    """Yield a broad carapace with teeth along its front edge."""
    middle = axis.body.mean(axis=0)
    r = float(axis.radii.max())
    yield _plate(middle + np.array([0.08 * r, 0.10 * r, 0.0]), (0.98 * r, 0.52 * r, 1.42 * r))
    yield _plate(
        middle + np.array([0.10 * r, -0.10 * r, 0.0]), (0.95 * r, 0.40 * r, 1.36 * r), 0.05
    )
    yield _plate(middle + np.array([-0.45 * r, 0.05 * r, 0.0]), (0.62 * r, 0.46 * r, 0.95 * r), 0.6)
    for x, z, size in CRAB_BUMPS:
        for side in (-1.0, 1.0) if z else (1.0,):
            high = 0.58 * float(np.sqrt(max(1.0 - (x / 1.06) ** 2 - (z / 1.42) ** 2, 0.05)))
            at = middle + r * np.array([0.08 + x, high, side * z])
            yield ball(at, (size * r, 0.10 * r, 1.25 * size * r), 0.10 * r)
    for side in (-1.0, 1.0):
        for k in range(5):
            angle = np.radians(24.0 + 13.5 * k)
            rim = np.array([np.cos(angle), 0.0, side * 1.44 * np.sin(angle)])
            at = middle + r * (0.92 * rim + [0.08, 0.0, 0.0])
            yield cone(at, at + 0.20 * r * rim, (0.09 * r,) * 2, (0.02 * r,) * 2, 0.06 * r)
