"""Shanks: the thin lower links of limbs, as rings along their bones.

They are too thin for the grid of the trunk. A shank begins inside the muscles above it.
"""

from __future__ import annotations

import numpy as np

from pipeline.simulation.figures.hide.lumps import Lump, cone
from pipeline.simulation.figures.hide.sheets import outward, tube
from pipeline.simulation.figures.hide.stance import Chain
from pipeline.simulation.figures.hide.trunk import (
    FORWARD,
    LEG_DEPTH,
    LEG_WIDTH,
    SPLINE_STEPS,
    spline,
)
from pipeline.simulation.figures.network import ARM
from pipeline.simulation.figures.skeleton import Limb
from pipeline.simulation.figures.solids import Solid, loft
from pipeline.simulation.spatial import UP, Array, cross, normalized

AROUND = 12
"""Vertices of a ring."""

LINK_RINGS = 9
"""Rings of a link."""

KNOBS = {"hooves": 1.12, "plain": 0.98}
"""Radius at a joint, in that drawn, by the feet."""

WAISTS = {"hooves": 0.70, "plain": 0.94}
"""Radius halfway to the next joint, in that drawn, by the feet: cannons are thin, columns not."""

USUAL_KNOB, USUAL_WAIST = 1.04, 0.82

PASTERN_AT, PASTERN = (0.0, 0.22, 0.45, 0.65, 1.0), (1.12, 0.92, 0.94, 0.80, 0.20)
"""Shares of the last link above a hoof, and its radius there, in that drawn at its start."""

TIP_RINGS, TIP, TIP_SINKS = 5, 0.30, 0.12
"""Rings of the tip of a tail, the radius of its end in that of its root, and how far it sinks."""

BONE_OUT, FETLOCK_OUT = 0.60, 0.14
"""How far the bone of a bent joint stands out, and the tuft of a fetlock, in the radius there."""


def tail_solid(points: Array, radii: Array, start: float, beyond: float) -> Solid:
    """Return a smooth tail through nodes, closed at both ends.

    Args:
        points: (n, 3) nodes [m].
        radii: (n,) drawn at them [m].
        start: share of the first link that is left to what it grows from.
        beyond: length of the tip beyond the last node [m].
    """
    curve, sizes = spline(points, radii, 2 * SPLINE_STEPS)
    first = round(start * 2 * SPLINE_STEPS)
    curve, sizes = curve[first:], sizes[first:].copy()
    if beyond > 0.0:
        # The tip is a cone with a round end, which sinks a little.
        t = np.linspace(0.0, 1.0, TIP_RINGS + 1)[1:, None]
        way = normalized(curve[-1] - curve[-2])
        tip = curve[-1] + beyond * (t * way - TIP_SINKS * t * t * UP)
        curve = np.concatenate([curve, tip])
        sizes = np.concatenate([sizes, sizes[-1] * (1.0 - (1.0 - TIP) * t[:, 0] ** 1.3)])
    else:
        sizes[-1] *= 0.55
    return tube(curve, sizes, AROUND)


def shank_solid(chain: Chain, start: int, girths: Array, feet: str) -> Solid:
    """Return the shank of a limb, from the middle of the link before `start` to its tip.

    Args:
        chain: the limb as it stands.
        start: its first link, at least 1.
        girths: (n + 1, 2) width and depth at the nodes, in the drawn radii.
        feet: word of the figure for them.
    """
    waist, knob = WAISTS.get(feet, USUAL_WAIST), KNOBS.get(feet, USUAL_KNOB)
    points, radii = chain.points[start - 1 :], chain.radii[start - 1 :]
    places, sizes = [], []
    n = len(points) - 1
    for i in range(n):
        t = np.linspace(0.45 if i == 0 else 0.0, 1.0, LINK_RINGS + 1)
        t = t if i == n - 1 else t[:-1]
        r = radii[i] + (radii[i + 1] - radii[i]) * t
        # Knobs at both ends of a bone; muscles taper into the first joint.
        bone = waist + (knob - waist) * np.abs(2.0 * t - 1.0) ** 3.0
        above = above_shank(feet)
        sheath = [0.78 * above, 0.96 * above, above, knob]
        shape = np.interp(t, [0.45, 0.60, 0.80, 1.0], sheath) if i == 0 else bone
        if i == n - 1 and i > 0 and feet == "hooves":
            # A pastern is as thin as its bone, and ends inside the hoof.
            r, shape = radii[i], np.interp(t, PASTERN_AT, PASTERN)
        places.append(points[i] + t[:, None] * (points[i + 1] - points[i]))
        wide = girths[start - 1 + i] + (girths[start + i] - girths[start - 1 + i]) * t[:, None]
        sizes.append((r * shape)[:, None] * wide)
    middle, size = np.concatenate(places), np.concatenate(sizes)
    for _ in range(2):
        middle[1:-1] = 0.25 * middle[:-2] + 0.5 * middle[1:-1] + 0.25 * middle[2:]
        size[1:-1] = 0.2 * size[:-2] + 0.6 * size[1:-1] + 0.2 * size[2:]
    ways = normalized(np.gradient(middle, axis=0))
    side = np.broadcast_to([0.0, 0.0, 1.0], ways.shape)
    side = normalized(side - (side * ways).sum(axis=-1, keepdims=True) * ways)
    ahead = cross(side, ways)
    angle = np.arange(AROUND) * (2.0 * np.pi / AROUND)
    deep, wide = LEG_DEPTH * size[:, 1], LEG_WIDTH * size[:, 0]
    ring = deep[:, None, None] * np.cos(angle)[:, None] * ahead[:, None]
    ring = ring + wide[:, None, None] * np.sin(angle)[:, None] * side[:, None]
    rings = middle[:, None] + ring
    for i in range(start, len(chain.points) - 1):
        bend = chain.ways[i - 1] - chain.ways[i]
        sharp = float(np.linalg.norm(bend))
        if sharp < 0.25:
            continue
        is_fetlock = i == len(chain.points) - 2 and i > start
        # The point of a hock or an elbow: what looks outward moves outward.
        out, r = bend / sharp, float(chain.radii[i])
        top = chain.points[i] - 0.45 * r * chain.ways[i - 1]
        away = np.linalg.norm(rings - top - 0.5 * r * out, axis=-1) / (1.5 * r)
        looks = np.clip((ring * out).sum(axis=-1) / np.linalg.norm(ring, axis=-1), 0.0, 1.0)
        push = (FETLOCK_OUT if is_fetlock else BONE_OUT) * min(sharp, 1.0) * r
        rings = rings + (push * looks**2 * np.exp(-(away**2) * 1.5))[..., None] * out
    ends = np.stack([middle[0], middle[-1] + 0.6 * wide[-1] * ways[-1]])
    return outward(loft(rings, ends))


def above_shank(feet: str) -> float:
    """Return the radius of a limb above the first joint of its shank, in that drawn."""
    return 0.5 + 0.5 * WAISTS.get(feet, USUAL_WAIST)


def ankle_lump(chain: Chain) -> Lump:
    """Return the end of a shank, from which its foot grows."""
    a = chain.points[-1] - 0.35 * chain.spans[-1]
    r = float(chain.radii[-1])
    # It comes out of the shank at a flat angle, so that no collar is seen.
    return cone(a, chain.points[-1], (0.5 * r, 0.45 * r), (0.98 * r, 0.88 * r), 0.3 * r, FORWARD)


def first_shank(limb: Limb) -> int:
    """Return the first link of a limb that is too thin for the grid of the trunk."""
    count = len(limb.links)
    return 1 if limb.kind == ARM else max(count - (2 if count > 3 else 1), 1)
