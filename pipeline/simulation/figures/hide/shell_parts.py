"""Limbs of arthropods: jointed legs, antennae of beads, and claws, as they stand."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from pipeline.simulation.figures.hide.sheets import Paint, painted, tube
from pipeline.simulation.figures.hide.stance import Chain
from pipeline.simulation.figures.solids import Solid
from pipeline.simulation.spatial import UP, Array, cross, normalized

AROUND = 8
"""Vertices around a link."""

HIP_DROP = 0.20
"""How far below its joint a beetle's leg leaves the body, in the length of its thigh."""

KNEE_DROP = 0.32
"""How much lower a beetle's knee is than its joint, in the height of that above the hip."""

JOINT_COLOR = "#120b07"

CLAW_RINGS = 15
"""Rings of a finger of a claw."""

FEET = 5
"""Segments of the last link of a leg, its tarsus."""


@dataclass(frozen=True)
class LegStyle:
    """How the legs of a kind of arthropod differ.

    Attributes:
        thick: factor on the drawn radius.
        flat: width across the upright, in the height.
        jointed: whether the last link has the segments of a foot.
        patella: whether the shin begins with a short link of its own, and the foot has two.
        dark: share of a dark colour at the joints.
    """

    thick: float = 1.0
    flat: float = 1.0
    jointed: bool = True
    patella: bool = False
    dark: float = 0.5


PATELLA = (
    (0.0, 0.05, 0.13, 0.19, 0.225, 0.27, 0.50, 0.93, 1.0),
    (0.66, 1.1, 1.22, 1.05, 0.62, 0.92, 1.18, 0.84, 0.62),
)
"""Thickness along a shin with a patella before it."""

METATARSUS = (
    (0.0, 0.08, 0.3, 0.56, 0.62, 0.68, 0.85, 1.0),
    (0.62, 1.0, 0.92, 0.86, 0.56, 0.86, 0.84, 0.5),
)
"""Thickness along a foot of two segments."""

LEG_STYLES = {
    "crab": LegStyle(1.1, 0.62, jointed=False),
    "centipede": LegStyle(1.15, 0.8, jointed=False),
    "scorpion": LegStyle(1.1, 0.75),
    "spider": LegStyle(1.08, patella=True, dark=0.85),
    "beetle": LegStyle(dark=0.8),
}
"""By the kind of shell; others have round legs as drawn."""


def leg_segment(chain: Chain, i: int, detail: float, style: LegStyle = LegStyle()) -> Solid:
    """Return one link of a leg, slender at its joints; the last one has the segments of a foot.

    Args:
        chain: the leg as it stands.
        i: number of the link.
        detail: share of the usual vertices along and around it.
        style: of the legs of its kind.
    """
    a, b = chain.points[i], chain.points[i + 1]
    r_a, r_b = style.thick * float(chain.radii[i]), style.thick * float(chain.radii[i + 1])
    if i == 0:
        # The base of a leg is no thicker than its knee, though its hip may be.
        r_a = min(r_a, 1.35 * r_b)
    is_foot = i == len(chain.ways) - 1 and i > 0
    is_parted = style.patella and i > 0
    t = np.linspace(0.0, 1.0, round(detail * (24 if is_parted else 14 if is_foot else 9)))
    radii = r_a + (r_b - r_a) * t
    if is_parted:
        shape = np.interp(t, *(METATARSUS if is_foot else PATELLA))
    elif is_foot and not style.jointed:
        # A blade that bends and ends in a point.
        shape = np.interp(t, [0.0, 0.10, 0.3, 0.7, 1.0], [0.66, 1.0, 1.05, 0.85, 0.4])
    elif is_foot:
        shape = 0.95 - 0.22 * np.cos(2.0 * np.pi * FEET * np.clip((t - 0.35) / 0.65, 0.0, 1.0))
        shape = np.where(t < 0.35, np.interp(t, [0.0, 0.12, 0.35], [0.55, 0.95, 0.74]), shape)
    else:
        # A thigh is thickest before its middle, a shin at its end.
        top = 0.42 if i == 0 else 0.66
        belly = 1.55 if style.patella else 1.28
        shape = np.interp(t, [0.0, 0.10, top, 0.92, 1.0], [0.60, 0.84, belly, 0.96, 0.70])
    middle = a + t[:, None] * (b - a)
    # Shells of legs are a little bowed, but around their link.
    height = min(0.06 * float(chain.lengths[i]), 0.8 * float((radii * shape)[len(t) // 2]))
    bow = height * np.sin(np.pi * t)
    bow *= 0.0 if is_foot and style.jointed else 1.0
    outward = normalized(
        UP * (1.0 - abs(chain.ways[i][1])) + 0.4 * (b - chain.points[0]) * [1, 0, 1]
    )
    middle = middle + bow[:, None] * outward
    return tube(middle, radii * shape, max(round(detail * AROUND), 6), style.flat, UP)


def beetle_leg(chain: Chain, i: int) -> list[Solid]:
    """Return the parts of one link of a beetle's leg: thigh with its hip, shin or foot.

    A thigh leaves the body from below, around the edge of the wing cases. A shin widens towards two
    spurs, between rows of spines, and each segment of a foot does so too.
    """
    chain = _crouched(chain)
    a, b, r = chain.points[i], chain.points[i + 1], float(chain.radii[i + 1])
    side = normalized(cross(chain.ways[i], UP))
    if i == 0:
        drop = HIP_DROP * float(chain.lengths[0]) * UP
        t = np.linspace(0.0, 1.0, 12)[:, None]
        root = a - drop
        bow = a + 0.52 * chain.spans[0] - 1.15 * drop
        middle = (1 - t) ** 2 * root + 2 * t * (1 - t) * bow + t**2 * b
        shape = np.interp(
            t[:, 0], [0.0, 0.06, 0.12, 0.58, 0.85, 0.95, 1.0], [1.0, 1.1, 1.0, 1.65, 1.25, 1.1, 0.7]
        )
        hip = np.array([root, root + 0.10 * (bow - root), root + 0.24 * (bow - root)])
        thick = r * np.array([1.2, 1.6, 1.1])
        return [tube(middle, r * shape, 10, 0.72, UP), tube(hip, thick, 8)]
    if i < len(chain.ways) - 1:
        knee = float(chain.radii[i])
        t = np.linspace(0.0, 1.0, 9)
        shape = np.interp(t, [0.0, 0.05, 0.14, 0.9, 1.0], [0.75, 0.95, 0.62, 0.98, 0.75])
        middle = a + t[:, None] * chain.spans[i] + (0.35 * knee * np.sin(np.pi * t))[:, None] * UP
        shin = tube(middle, knee * shape, AROUND, 0.8, UP)
        return [shin, *_spines(chain, i, side, knee)]
    t = np.linspace(0.0, 1.0, 3 * FEET + 1)
    # Each segment is narrow at its root and broad at its end.
    place = np.clip(t * FEET - np.floor(t * FEET - 1e-9), 0.0, 1.0)
    size = float(chain.radii[i])
    shape = size * (0.50 + 0.52 * place) * (1.0 - 0.35 * t)
    return [tube(a + t[:, None] * chain.spans[i], shape, 7, 0.8, UP)]


def _crouched(chain: Chain) -> Chain:
    """Return a leg whose knee rises less over its hip: thighs lie beside the wing cases."""
    points = chain.points.copy()
    points[1, 1] -= KNEE_DROP * max(points[1, 1] - points[0, 1], 0.0)
    return replace(chain, points=points)


def _spines(chain: Chain, i: int, side: Array, r: float) -> Iterator[Solid]:
    """Yield two rows of spines along a shin, and the spurs at its end."""
    for share, long in ((0.40, 1.2), (0.62, 1.3), (0.82, 1.4), (0.97, 2.2)):
        at = chain.points[i] + share * chain.spans[i]
        for sign in (-1.0, 1.0):
            out = normalized(0.8 * sign * side - 0.4 * UP + 0.9 * chain.ways[i])
            curve = np.array([at + 0.4 * r * out, at + (0.4 + long) * r * out])
            yield tube(curve, r * np.array([0.24, 0.03]), 5)


PATELLA_END, METATARSUS_END = 0.225, 0.62
"""Places of the inner joints of a parted shin and foot, along them."""


def joint_paint(chain: Chain, i: int, solid: Solid, style: LegStyle) -> Paint:
    """Return the paint of a link that is dark at its joints, and the more so further out.

    Args:
        chain: the limb as it stands.
        i: number of the link.
        solid: of the link.
        style: of the limbs of its kind.
    """
    along = ((solid.vertices - chain.points[i]) * chain.ways[i]).sum(axis=-1)
    t = along / float(chain.lengths[i])
    ends = np.exp(-((t / (0.10 if i else 0.2)) ** 2)) + np.exp(-(((t - 1.0) / 0.16) ** 2))
    if style.patella and i > 0:
        inner = PATELLA_END if i < len(chain.ways) - 1 else METATARSUS_END
        ends += np.exp(-(((t - inner) / 0.07) ** 2))
    outward = (i + np.clip(t, 0.0, 1.0)) / len(chain.ways)
    dark = style.dark * np.clip(ends + 1.4 * np.maximum(outward - 0.3, 0.0), 0.0, 1.0)
    return painted(len(t), JOINT_COLOR, dark)


def antenna_segment(chain: Chain, i: int) -> Solid:
    """Return one link of an antenna as a string of segments, each broadest near its end."""
    a, b = chain.points[i], chain.points[i + 1]
    r_a, r_b = float(chain.radii[i]), float(chain.radii[i + 1])
    r_a = min(r_a, 1.4 * r_b) if i == 0 else r_a
    beads = (
        1
        if i == 0 and len(chain.ways) > 1
        else max(3, round(float(chain.lengths[i]) / (4.5 * max(r_a, r_b))))
    )
    beads = min(beads, 6)
    place = np.array([0.0, 0.3, 0.75, 0.95])
    t = np.append((np.arange(beads)[:, None] + place).ravel() / beads, 1.0)
    shape = np.append(np.tile([0.55, 0.82, 1.0, 0.9], beads), 0.5)
    return tube(a + t[:, None] * (b - a), (r_a + (r_b - r_a) * t) * shape, 6)


def is_claw(chain: Chain) -> bool:
    """Return whether a limb ends in a claw: drawn thick before a thin tip."""
    if len(chain.ways) < 2:
        return False
    palm, tip = float(chain.radii[-2]), float(chain.radii[-1])
    return palm > 2.0 * tip and palm > 1.3 * float(chain.radii[-3])


def claw_solids(chain: Chain, sign: float) -> list[Solid]:
    """Return the palm of a claw and its two fingers.

    Args:
        chain: a limb whose last two nodes are the palm and the tip.
        sign: 1 on the right side of the body, -1 on the left.
    """
    palm, tip = chain.points[-2], chain.points[-1]
    r, way = float(chain.radii[-2]), chain.ways[-1]
    side = normalized(cross(way, UP)) * sign
    length = float(chain.lengths[-1])
    t = np.linspace(0.0, 1.0, 14)
    back = palm - 1.25 * r * way
    line = back + t[:, None] * (1.10 * r + 0.30 * length) * way
    shape = np.interp(t, [0.0, 0.07, 0.22, 0.55, 0.85, 1.0], [0.30, 0.52, 0.92, 1.16, 1.02, 0.55])
    solids = [tube(line, r * shape, 14, 0.66, side)]
    for inner in (-1.0, 1.0):
        # The fixed finger goes on from the palm; the other is hinged, and stands open.
        thick, out = (0.52, 0.50) if inner > 0 else (0.40, 0.86)
        root = palm + 0.02 * length * way + 0.48 * r * inner * side
        bow = palm + 0.55 * length * way + (out + 0.62) * r * inner * side
        end = tip + (0.10 if inner > 0 else 0.55) * r * inner * side
        s = np.linspace(0.0, 1.0, CLAW_RINGS)[:, None]
        curve = (1 - s) ** 2 * root + 2 * s * (1 - s) * bow + s**2 * end
        sizes = (
            r * thick * np.interp(s[:, 0], [0.0, 0.2, 0.7, 0.93, 1.0], [0.8, 1.0, 0.62, 0.3, 0.06])
        )
        finger = tube(curve, sizes, 9)
        # Teeth stand along the edges that meet.
        rings = finger.vertices[:-2].reshape(CLAW_RINGS, 9, 3)
        edge = np.clip(
            ((rings - curve[:, None]) * side).sum(axis=-1) * -inner / sizes[:, None], 0, 1
        )
        tooth = 0.34 * np.clip(np.sin(np.arange(CLAW_RINGS) * 2.2), 0.0, 1.0) * (s[:, 0] > 0.25)
        rings -= (inner * edge**3 * (tooth * sizes)[:, None])[..., None] * side
        solids.append(finger)
    return solids


def sting_solid(chain: Chain) -> Solid:
    """Return a bulb that ends in a curved sting, on the last link of a tail."""
    a, b = chain.points[-2], chain.points[-1]
    r, way = float(chain.radii[-2]), chain.ways[-1]
    bend = chain.ways[-1] - chain.ways[-2]
    down = normalized(bend - float((bend * way).sum()) * way) if np.abs(bend).max() > 1e-3 else -UP
    t = np.linspace(0.0, 1.0, 16)
    line = a - 0.7 * r * way + t[:, None] * (b - a + 0.7 * r * way)
    line = line + (0.55 * r * np.clip(t - 0.45, 0, 1) ** 2 * 4.0)[:, None] * down
    shape = np.interp(
        t, [0, 0.1, 0.32, 0.5, 0.62, 0.8, 1.0], [0.5, 0.85, 1.2, 0.95, 0.45, 0.22, 0.03]
    )
    return tube(line, r * shape, 12)


def mandibles(tip: Array, along: Array, radius: float, size: float) -> list[Solid]:
    """Return two toothed jaws that curve towards each other."""
    side = normalized(cross(along, UP))
    down = cross(along, side)
    solids = []
    for sign in (-1.0, 1.0):
        line = ((0.35, 0.48, 0.20), (1.05, 0.72, 0.26), (1.55, 0.52, 0.30), (1.80, 0.06, 0.32))
        points = np.array(
            [
                tip
                + radius
                * (1.0 + (size - 1.0) * (a > 0.5))
                * (a * along + sign * s * side + d * down)
                for a, s, d in line
            ]
        )
        s = np.linspace(0.0, 1.0, 10)
        curve = np.stack([np.interp(s, np.linspace(0, 1, 4), points[:, k]) for k in range(3)], -1)
        curve[1:-1] = 0.25 * curve[:-2] + 0.5 * curve[1:-1] + 0.25 * curve[2:]
        sizes = radius * size * np.interp(s, [0, 0.5, 1.0], [0.26, 0.20, 0.03])
        solids.append(tube(curve, sizes * (1.0 + 0.14 * np.sin(9.0 * s)), 8))
    return solids


def chelicerae(tip: Array, along: Array, radius: float) -> list[Solid]:
    """Return the two short pincers before the mouth of a scorpion."""
    side = normalized(cross(along, UP))
    solids = []
    for sign in (-1.0, 1.0):
        root = tip + radius * (0.55 * along + 0.26 * sign * side - 0.02 * UP)
        palm = np.array([root, root + radius * (0.30 * along + 0.04 * sign * side)])
        palm = np.stack([palm[0] + t * (palm[1] - palm[0]) for t in np.linspace(0.0, 1.0, 4)])
        solids.append(tube(palm, radius * np.array([0.16, 0.24, 0.24, 0.17]), 7))
        for inner in (-1.0, 1.0):
            start = palm[-1] + 0.10 * inner * sign * radius * side
            bow = start + radius * (0.16 * along + 0.05 * inner * sign * side - 0.02 * UP)
            end = start + radius * (0.32 * along - 0.05 * inner * sign * side - 0.08 * UP)
            solids.append(
                tube(np.array([start, bow, end]), radius * np.array([0.10, 0.08, 0.02]), 5)
            )
    return solids


def venom_claws(tip: Array, along: Array, radius: float) -> list[Solid]:
    """Return the first legs of a centipede, which are fangs below its head."""
    side = normalized(cross(along, UP))
    solids = []
    for sign in (-1.0, 1.0):
        line = ((-0.70, 0.78, -0.38), (0.30, 1.30, -0.46), (1.15, 1.02, -0.48), (1.50, 0.20, -0.52))
        points = np.array(
            [tip + radius * (a * along + sign * s * side + u * UP) for a, s, u in line]
        )
        t = np.linspace(0.0, 1.0, 12)
        curve = np.stack([np.interp(t, np.linspace(0, 1, 4), points[:, k]) for k in range(3)], -1)
        for _ in range(2):
            curve[1:-1] = 0.25 * curve[:-2] + 0.5 * curve[1:-1] + 0.25 * curve[2:]
        shape = np.interp(t, [0.0, 0.2, 0.34, 0.38, 0.7, 1.0], [0.30, 0.44, 0.34, 0.28, 0.20, 0.02])
        solids.append(tube(curve, radius * shape, 8))
    return solids


def palps(tip: Array, along: Array, radius: float) -> list[Solid]:
    """Return the two jointed palps below the jaws."""
    side = normalized(cross(along, UP))
    solids = []
    for sign in (-1.0, 1.0):
        line = ((0.55, 0.36, -0.50), (1.10, 0.62, -0.62), (1.45, 0.62, -0.30), (1.80, 0.50, -0.55))
        points = np.array(
            [tip + radius * (a * along + sign * s * side + u * UP) for a, s, u in line]
        )
        t = np.linspace(0.0, 1.0, 13)
        curve = np.stack([np.interp(t, np.linspace(0, 1, 4), points[:, k]) for k in range(3)], -1)
        shape = 0.060 + 0.022 * np.cos(2.0 * np.pi * (3.0 * t - 0.75))
        solids.append(tube(curve, radius * shape, 6))
    return solids
