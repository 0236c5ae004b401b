"""Flesh of trunks, necks, legs and tails: lumps along the drawn nodes.

The drawn radii are those of the limbs; muscles, joints and the points of hocks and elbows come from
the way in which a leg bends.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.hide.lumps import SIDE, Lump, ball, cone
from pipeline.simulation.figures.hide.muscles import (
    LOIN_PLACE,
    haunch_muscles,
    loin_hollows,
    shoulder_muscles,
)
from pipeline.simulation.figures.hide.stance import Chain, Stance
from pipeline.simulation.spatial import UP, Array, normalized

FORWARD = np.array([1.0, 0.0, 0.0])

LEG_DEPTH, LEG_WIDTH = 1.18, 0.86
"""Depth from front to back, and width, of a leg in its drawn radius."""

UPPER_BLEND, LOWER_BLEND = 0.55, 0.35
"""Width of the union of the upper and the lower links of a limb, in their radius."""

SPLINE_STEPS = 4
"""Lumps of a neck or a tail for each of its links."""

NARROW_SHANK = -0.16
"""Waist of the links below knee and hock, as a fraction of their radius."""

SHEATHED, SHEATH_END = 0.76, 0.80
"""Where on the link above a shank the flesh ends, in its length, and how thick it is there, in the
shank: it goes in at a flat angle, so that no collar is seen."""

POINT_OF_JOINT = 0.50
"""Distance by which the bone of a bent joint stands out, in the radius there."""

LEVEL_BODY = 0.5
"""Cosine of the slope of a body that has withers and a brisket."""


SHORT_LEGS = 2.6
"""Length of legs below which the coat of a round body hides their muscles, in its radius."""

ON_MIDLINE = 0.05
"""Distance of a node from the midline up to which it is on it, in its radius."""

FLANK_PLACE, FLANK_DEPTH = 0.36, 0.62
"""Where the fold of the flank begins: ahead of the hip, in the way to the shoulder, and below the
middle of the trunk, in its height there."""


def body_lumps(figure: Figure, core: float = 1.0) -> Iterator[Lump]:
    """Yield the flesh of the trunk.

    Args:
        figure: an animal.
        core: radius at hips and shoulders, in that drawn: muscles around them need a thin core.
    """
    nodes = list(figure.anatomy.body)
    bones = list(figure.anatomy.bones) or [(nodes[0], nodes[0])]
    radii = figure.drawing.radii * figure.scale
    widths = {node: _girth(figure, node) for node in nodes}
    blend = 0.45 * float(np.median(radii[nodes]))
    for a, b in bones:
        ends = []
        for node in (a, b):
            width, height, lift = widths[node]
            r = float(radii[node])
            if abs(float(figure.points[node][2])) > ON_MIDLINE * r:
                r *= core
            ends.append((figure.points[node] + lift * r * UP, (height * r, width * r)))
        (p_a, r_a), (p_b, r_b) = ends
        yield cone(p_a, p_b, r_a, r_b, blend)


def _girth(figure: Figure, node: int) -> tuple[float, float, float]:
    """Return width, height and lift of a node's cross-section, in its radius."""
    width, height, lift = figure.drawing.girths[node]
    return float(width), float(height), float(lift)


def leg_lumps(
    chain: Chain,
    start: int,
    end: int,
    girths: Array,
    sheathed: float | None = None,
    root: float = 1.0,
) -> Iterator[Lump]:
    """Yield the flesh of some links of a leg or an arm.

    Args:
        chain: the limb as it stands.
        start: the first of the links, counted from 0.
        end: the link after the last.
        girths: (n + 1, 2) width and depth at the nodes, in the drawn radii.
        sheathed: radius of the shank in which they end, in that drawn; None without one.
        root: radius at the first node, in that drawn: muscles around it need a thin core.
    """
    points, radii, ways = chain.points, chain.radii, chain.ways
    for i in range(start, end):
        a, b, r_a, r_b = points[i], points[i + 1], float(radii[i]), float(radii[i + 1])
        upper = i < max(len(ways) - 2, 1)
        if i == 0:
            r_a = root * min(r_a, 1.9 * r_b)
        if sheathed is not None and i == end - 1:
            # Its end is coarse: it would come out of the shank in steps.
            b, r_b = a + SHEATHED * (b - a), SHEATH_END * sheathed * (r_a + SHEATHED * (r_b - r_a))
        blend = (UPPER_BLEND if upper else LOWER_BLEND) * max(r_a, r_b)
        if root < 1.0 and i == 0:
            blend *= root
        deep = LEG_DEPTH + (0.10 if i == 0 else 0.0)
        # The second of three links is a forearm.
        bulge = (0.14, 0.20)[i] if i < min(2, max(len(ways) - 1, 1)) else NARROW_SHANK
        yield cone(
            *(a, b),
            (deep * r_a * girths[i, 1], LEG_WIDTH * r_a * girths[i, 0]),
            (LEG_DEPTH * r_b * girths[i + 1, 1], LEG_WIDTH * r_b * girths[i + 1, 0]),
            blend,
            *(FORWARD, bulge),
        )
    for i in range(max(start, 1), end):
        yield from _joint_lumps(chain, i, float(girths[i].mean()))


def _joint_lumps(chain: Chain, i: int, girth: float) -> Iterator[Lump]:
    """Yield the bones of a joint of some girth: its knob, and its point where it is bent."""
    at, r = chain.points[i], girth * float(chain.radii[i])
    bend = chain.ways[i - 1] - chain.ways[i]
    sharp = float(np.linalg.norm(bend))
    yield ball(at, (r * 1.06, r * 1.06, r * 0.98), 0.5 * r)
    # A fetlock has no point.
    if sharp < 0.25 or i >= len(chain.ways) - 1:
        return
    out = bend / sharp
    reach = POINT_OF_JOINT * min(sharp, 1.0) * r
    tip = at + out * reach - 0.55 * r * chain.ways[i - 1]
    yield cone(at, tip, (0.75 * r, 0.65 * r), (0.55 * r, 0.5 * r), 0.5 * r, FORWARD)


def has_muscles(stance: Stance) -> bool:
    """Return whether muscles show: on legs that are neither columns nor short below a body."""
    figure = stance.figure
    legs = [stance.chain(limb) for limb in figure.skeleton.legs]
    if figure.style != "mammal" or figure.feet == "plain":
        return False
    if len(legs) < 4:
        return _is_hopper(figure, legs)
    girth = float(figure.drawing.radii[list(figure.anatomy.body)].max()) * figure.scale
    return float(np.mean([leg.lengths.sum() for leg in legs])) > SHORT_LEGS * girth


def _is_hopper(figure: Figure, legs: Sequence[Chain]) -> bool:
    """Return whether an animal on two legs has the haunches of one on four, as a kangaroo."""
    return figure.feet == "paws" and all(len(leg.points) > 3 for leg in legs)


def haunch_lumps(stance: Stance, trunk: Sequence[Lump]) -> Iterator[Lump]:
    """Yield shoulders, buttocks, withers and brisket of an animal on four legs.

    Args:
        stance: of a mammal.
        trunk: the lumps of its body.
    """
    figure = stance.figure
    legs = [stance.chain(limb) for limb in figure.skeleton.legs]
    if len(legs) < 4:
        for leg in legs:
            girth = _knee_girth(figure, leg)
            if _is_hopper(figure, legs):
                yield from haunch_muscles(leg, girth, is_upright=True)
            else:
                yield from _thigh(leg, 0.8, girth)
        return
    ahead = np.median([leg.points[0, 0] for leg in legs])
    front = [leg for leg in legs if leg.points[0, 0] >= ahead]
    hind = [leg for leg in legs if leg.points[0, 0] < ahead]
    shoulder = max(float(leg.points[0, 0]) for leg in front)
    is_smooth = not has_muscles(stance)
    if not is_smooth:
        yield from loin_hollows(trunk, hind, shoulder, _trunk_height(figure, hind, shoulder))
    for leg in front:
        yield from _shoulder(leg) if is_smooth else shoulder_muscles(leg)
    for leg in hind:
        girth = _knee_girth(figure, leg)
        if is_smooth or len(leg.points) < 3:
            yield from _thigh(leg, 1.0, girth)
        else:
            yield from haunch_muscles(leg, girth)
        if figure.feet != "plain":
            yield _flank(figure, leg, shoulder)
    r = float(front[0].radii[0])
    middle = np.mean([leg.points[0] for leg in front], axis=0)
    yield ball(middle + r * np.array([0.75, -0.55, 0.0]), (0.8 * r, 0.85 * r, 0.75 * r), 0.7 * r)


def _trunk_height(figure: Figure, hind: Sequence[Chain], shoulder: float) -> float:
    """Return the height of the middle of the trunk at the loin [m]."""
    x = float(np.mean([leg.points[0, 0] for leg in hind]))
    nodes = sorted(figure.anatomy.body, key=lambda node: float(figure.points[node][0]))
    places = np.array([figure.points[node] for node in nodes])
    return float(np.interp(x + LOIN_PLACE * (shoulder - x), places[:, 0], places[:, 1]))


def _shoulder(leg: Chain) -> Iterator[Lump]:
    """Yield the shoulder blade, and the muscle between it and the elbow, of a column."""
    hip, elbow, r, r_e = leg.points[0], leg.points[1], float(leg.radii[0]), float(leg.radii[1])
    outward = float(np.sign(hip[2]))
    top = hip + r * np.array([-0.25, 0.75, 0.05 * outward])
    point = hip + r * np.array([0.55, -0.55, 0.18 * outward])
    yield cone(top, point, (0.62 * r, 0.38 * r), (0.62 * r, 0.55 * r), 0.5 * r, FORWARD)
    yield cone(
        *(point, elbow, (0.6 * r, 0.5 * r), (1.25 * r_e, 0.95 * r_e), 0.5 * r, FORWARD),
    )


def _flank(figure: Figure, leg: Chain, shoulder: float) -> Lump:
    """Return the fold of skin between belly and knee, without which a waist looks pinched.

    Args:
        figure: an animal on four legs.
        leg: one of its hind legs.
        shoulder: how far ahead the shoulders are [m].
    """
    hip, knee = leg.points[0], leg.points[1]
    nodes = sorted(figure.anatomy.body, key=lambda node: float(figure.points[node][0]))
    x = float(hip[0]) + FLANK_PLACE * (shoulder - float(hip[0]))
    places = np.array([figure.points[node] for node in nodes])
    radii = figure.drawing.radii[nodes] * figure.scale
    girths = radii[:, None] * np.array([_girth(figure, node) for node in nodes])
    height = float(np.interp(x, places[:, 0], places[:, 1] + girths[:, 2]))
    wide, high = (float(np.interp(x, places[:, 0], girths[:, k])) for k in (0, 1))
    side = np.sign(hip[2]) * SIDE
    top = np.array([x, height - FLANK_DEPTH * high, 0.0]) + 0.42 * wide * side
    r_k = float(leg.radii[1])
    low = knee + 0.10 * (hip - knee) + 0.25 * r_k * FORWARD
    return cone(top, low, (0.62 * high, 0.50 * wide), (0.9 * r_k, 0.6 * r_k), 0.8 * r_k, FORWARD)


def _knee_girth(figure: Figure, leg: Chain) -> float:
    """Return the mean of width and depth of a leg's first joint, in its drawn radius."""
    number = figure.skeleton.limbs.index(leg.limb)
    node = figure.anatomy.appendages[number].nodes[1]
    return float(figure.drawing.girths[node, :2].mean())


def _thigh(leg: Chain, size: float, knee_girth: float) -> Iterator[Lump]:
    """Yield the muscles before and behind the thigh bone."""
    if len(leg.points) < 3:
        return
    hip, knee, r = leg.points[0], leg.points[1], float(leg.radii[0])
    r_k = knee_girth * float(leg.radii[1])
    outward = float(np.sign(hip[2]))
    back = hip + size * r * np.array([-0.52, 0.05, 0.10 * outward])
    low = knee + 0.35 * leg.spans[1] * 0.6 + r_k * np.array([-0.35, 0.0, 0.05 * outward])
    ends = (0.72 * r, 0.62 * r), (0.85 * r_k, 0.72 * r_k)
    yield cone(back, low, *ends, 0.55 * r, FORWARD, 0.08)
    front = hip + r * np.array([0.25, 0.0, 0.12 * outward])
    ends = (0.8 * r, 0.62 * r), (1.15 * r_k, 0.95 * r_k)
    yield cone(front, knee, *ends, 0.5 * r, FORWARD)


def spline(points: Array, radii: Array, steps: int = SPLINE_STEPS) -> tuple[Array, Array]:
    """Return points and radii along a smooth curve through `points` (n, 3).

    Source: Catmull-Rom.
    """
    if len(points) < 3:
        t = np.linspace(0.0, 1.0, steps + 1)[:, None]
        return points[0] + t * (points[-1] - points[0]), radii[0] + t[:, 0] * (radii[-1] - radii[0])
    both = np.concatenate([points, radii[:, None]], axis=1)
    both = np.concatenate([[2 * both[0] - both[1]], both, [2 * both[-1] - both[-2]]])
    found = [both[1]]
    for k in range(1, len(both) - 2):
        p0, p1, p2, p3 = both[k - 1 : k + 3]
        for t in np.linspace(0.0, 1.0, steps + 1)[1:]:
            found.append(
                0.5
                * (
                    2 * p1
                    + (p2 - p0) * t
                    + (2 * p0 - 5 * p1 + 4 * p2 - p3) * t**2
                    + (3 * p1 - p0 - 3 * p2 + p3) * t**3
                )
            )
    curve = np.array(found)
    return curve[:, :3], np.maximum(curve[:, 3], 0.3 * radii.min())


def tube_lumps(
    points: Array,
    radii: Array,
    deep: tuple[float, float],
    wide: tuple[float, float],
    blend: float,
    heights: Array | None = None,
) -> Iterator[Lump]:
    """Yield a smooth tube, as of a neck or a tail.

    Args:
        points: (n, 3) nodes that it goes through [m].
        radii: (n,) drawn at them [m].
        deep: height of its cross-section at its ends, in the drawn radius.
        wide: width of the same.
        blend: width of its union with what it grows from, in its radius.
        heights: (n,) factors of the height at the nodes.
    """
    curve, sizes = spline(points, radii)
    highs = np.ones(len(points)) if heights is None else heights
    sizes_up = sizes * np.interp(
        np.linspace(0.0, 1.0, len(curve)), np.linspace(0.0, 1.0, len(points)), highs
    )
    share = np.linspace(0.0, 1.0, len(curve))
    up = sizes_up * np.interp(share, [0.0, 1.0], deep)
    side = sizes * np.interp(share, [0.0, 1.0], wide)
    for i in range(len(curve) - 1):
        width = blend * float(sizes[i]) if i == 0 else 0.3 * float(sizes[i])
        ends = [(float(up[k]), float(side[k])) for k in (i, i + 1)]
        yield cone(
            curve[i], curve[i + 1], ends[0], ends[1], width, _upright(curve[i + 1] - curve[i])
        )


def _upright(way: Array) -> Array:
    """Return the direction of the back of a neck or tail that goes some way."""
    along = normalized(way)
    # The back of what rises steeply looks backward.
    return np.array([-along[1], along[0] if along[0] > 0 else abs(along[0]), 0.0]) + 1e-6 * UP
