"""Skins: rendered surfaces of grown-together links, and of a body with limbs that grow from it.

A limb's skin is a sequence of vertex rings. Around a joint they follow both of its links, by
shares that change over from one to the other, so that a bent knee stays round.

The stumps of necks, tails and thighs join the body's smooth union. Its skin follows the body, and
over a stump increasingly the limb, inside whose own skin it ends.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.network import HEAD, LEG, TAIL
from pipeline.simulation.figures.skeleton import Limb, Link, Skeleton
from pipeline.simulation.figures.solids import Solid, body_solid, loft
from pipeline.simulation.spatial import Array, cross, normalized

SKIN_RING_VERTICES = 14
"""Vertices of a ring."""

LINK_RINGS = 5
"""Rings of a link between its joints."""

BLEND_RADII, MAX_BLEND_LENGTH = 1.1, 0.42
"""Distance from a joint within which its skin follows both links, in radii and at most in link
lengths."""

CAP_LATITUDES = np.radians([18.0, 40.0, 62.0, 80.0])
"""Latitudes of the rings of a cap [rad]."""

EAR_LENGTH = 1.35
"""Length of an ear, in lengths of its link."""

SWELLING_EXPONENT = np.log(0.5) / np.log(0.36)
"""Places the thickest point of a link at a third of its length, like a thigh's."""


@dataclass(frozen=True, slots=True)
class StumpShape:
    """Shape of stumps, the roots of limbs that grow from the skin of a body.

    Attributes:
        kinds: of limbs with a stump. Arms turn too far.
        min_radius: least root radius of a limb with a stump, in the body's.
        length: of a stump, in radii of its root.
        max_length: of a stump, in lengths of its link.
        separation: difference of distances from two stumps beyond which only the nearer one counts,
            in radii.
        end_ratio: radius of a stump's end, in the link's there: it ends inside the limb's skin.
    """

    kinds: tuple[str, ...] = (LEG, HEAD, TAIL)
    min_radius: float = 0.30
    length: float = 1.7
    max_length: float = 0.55
    separation: float = 0.8
    end_ratio: float = 0.90


STUMP_SHAPE = StumpShape()


@dataclass(frozen=True, eq=False)
class Skin:
    """A closed surface whose vertices follow up to two links.

    Attributes:
        vertices: (V, 3) in the creation frame [m].
        faces: (F, 3), counter-clockwise from outside.
        links: (V, 2) numbers.
        share: (V,) of the second link; the first has the rest.
        paint: (V, 4) linear colour in place of the material's, and its share; None for none.
        hair: (V, 3) of a coat, from root to tip in the creation frame [m]; None for none.
    """

    vertices: Array
    faces: NDArray[np.uint32]
    links: NDArray[np.int64]
    share: Array
    paint: Array | None = None
    hair: Array | None = None

    @staticmethod
    def rigid(solid: Solid, link: int) -> Skin:
        """Return a solid that follows one link."""
        count = len(solid.vertices)
        return Skin(solid.vertices, solid.faces, np.full((count, 2), link), np.zeros(count))


def merge_skins(skins: Sequence[Skin]) -> Skin:
    """Return several skins as one."""
    starts = np.cumsum([0, *(len(skin.vertices) for skin in skins)])
    faces = [skin.faces + np.uint32(start) for skin, start in zip(skins, starts, strict=False)]
    return Skin(
        np.concatenate([skin.vertices for skin in skins]),
        np.concatenate(faces),
        np.concatenate([skin.links for skin in skins]),
        np.concatenate([skin.share for skin in skins]),
        _merged([skin.paint for skin in skins], skins, 4),
        _merged([skin.hair for skin in skins], skins, 3),
    )


def _merged(values: Sequence[Array | None], skins: Sequence[Skin], columns: int) -> Array | None:
    """Return what vertices of several skins have, 0 where a skin has nothing."""
    if all(value is None for value in values):
        return None
    return np.concatenate(
        [
            np.zeros((len(skin.vertices), columns)) if value is None else value
            for value, skin in zip(values, skins, strict=True)
        ]
    )


@dataclass(frozen=True, slots=True)
class _Ring:
    """A ring: centre and axis, radius, links, and the share of the second one."""

    middle: Array
    along: Array
    radius: float
    links: tuple[int, int]
    share: float


def skin_runs(limb: Limb, skeleton: Skeleton) -> list[tuple[int, ...]]:
    """Return the sequences of a limb's links that grow together.

    Only round links of one material do, and none that slides.
    """
    found: list[list[int]] = []
    for number in limb.links:
        link = skeleton.links[number]
        if found and _is_continuous(skeleton.links[found[-1][-1]], link, skeleton):
            found[-1].append(number)
        else:
            found.append([number])
    return [tuple(run) for run in found if skeleton.links[run[0]].shape == "round"]


def _is_continuous(before: Link, link: Link, skeleton: Skeleton) -> bool:
    alike = before.shape == link.shape == "round" and before.material == link.material
    return alike and not bool(skeleton.prismatic[link.joint])


def limb_skin(run: Sequence[int], links: Sequence[Link], swelling: float) -> Skin:
    """Return the skin of links that grow together.

    Args:
        run: their numbers, from the base outward.
        links: all links of the skeleton.
        swelling: greatest thickness beyond a cone, as a fraction.
    """
    rings = _rings(run, links, swelling)
    first, last = rings[0], rings[-1]
    begin = [_cap_ring(first, -angle) for angle in CAP_LATITUDES[::-1]]
    end = [_cap_ring(last, angle) for angle in CAP_LATITUDES]
    rings = [*begin, *rings, *end]
    y = _parallel_transport([ring.along for ring in rings])
    z = cross(np.array([ring.along for ring in rings]), y)
    angle = np.arange(SKIN_RING_VERTICES) * (2.0 * np.pi / SKIN_RING_VERTICES)
    around = np.cos(angle)[:, None] * y[:, None] + np.sin(angle)[:, None] * z[:, None]
    radii = np.array([ring.radius for ring in rings])
    places = np.array([ring.middle for ring in rings])[:, None] + radii[:, None, None] * around
    ends = np.stack(
        [first.middle - first.radius * first.along, last.middle + last.radius * last.along]
    )
    solid = loft(places, ends)
    ringwise = [*np.repeat(np.arange(len(rings)), SKIN_RING_VERTICES), 0, len(rings) - 1]
    pairs = np.array([ring.links for ring in rings])[ringwise]
    shares = np.array([ring.share for ring in rings])[ringwise]
    return Skin(solid.vertices, solid.faces, pairs, shares)


def leaf_skin(number: int, link: Link) -> Skin:
    """Return an ear: a leaf on a link, flat in its drawing plane."""
    span = EAR_LENGTH * (link.ends[1] - link.ends[0])
    along, across = normalized(span), normalized(cross(link.normal, span))
    s = np.linspace(0.0, 1.0, 12)
    wide = max(link.radii) * (0.6 + 2.6 * np.sin(np.pi * s**0.7)) * (1.0 - 0.55 * s)
    thick = 0.34 * wide
    angle = np.arange(SKIN_RING_VERTICES) * (2.0 * np.pi / SKIN_RING_VERTICES)
    normal = cross(along, across)
    flat = wide[:, None, None] * np.cos(angle)[:, None] * across
    flat = flat + thick[:, None, None] * np.sin(angle)[:, None] * normal
    places = link.ends[0] + s[:, None, None] * span + flat
    ends = np.stack([link.ends[0] - wide[0] * along, link.ends[0] + span + 0.4 * wide[-1] * along])
    return Skin.rigid(loft(places, ends), number)


def _rings(run: Sequence[int], links: Sequence[Link], swelling: float) -> list[_Ring]:
    """Return the rings between the first joint and the tip of a run."""
    own = [links[number] for number in run]
    spans = np.array([link.ends[1] - link.ends[0] for link in own])
    lengths = np.sqrt((spans * spans).sum(axis=-1))
    ways = normalized(spans)
    widths = [0.0]
    for i, (before, after) in enumerate(itertools.pairwise(own)):
        shortest = MAX_BLEND_LENGTH * float(min(lengths[i], lengths[i + 1]))
        widths.append(min(BLEND_RADII * max(before.radii[1], after.radii[0]), shortest))
    widths.append(0.0)
    rings = []
    for i, link in enumerate(own):
        for x in _ring_distances(
            float(lengths[i]), widths[i], widths[i + 1], last=i == len(own) - 1
        ):
            s = x / float(lengths[i])
            a, b = link.radii
            radius = (a + (b - a) * s) * (
                1.0 + swelling * float(np.sin(np.pi * max(s, 0.0) ** SWELLING_EXPONENT))
            )
            middle = link.ends[0] + s * spans[i]
            pair, share, along = _ring_links(run, ways, i, x, float(lengths[i]), widths)
            rings.append(_Ring(middle, along, radius, pair, share))
    return rings


def _ring_distances(length: float, before: float, after: float, last: bool) -> list[float]:
    """Return the distances of a link's rings from its joint, without those of the next link."""
    start = [0.0, 0.5 * before] if before else [0.0]
    inner = np.linspace(before, length - after, LINK_RINGS + 2)
    inner = inner[1:] if before == 0.0 else inner
    end = [length - 0.5 * after] if after else []
    places = [*start, *inner.tolist(), *end]
    return places if last or after else places[:-1]


def _ring_links(
    run: Sequence[int], ways: Array, i: int, x: float, length: float, widths: Sequence[float]
) -> tuple[tuple[int, int], float, Array]:
    """Return the links that a ring follows, the share of the second, and its axis."""
    if i > 0 and x < widths[i]:
        share = _smooth_share(0.5 + 0.5 * x / widths[i])
        along = normalized((1.0 - share) * ways[i - 1] + share * ways[i])
        return (run[i - 1], run[i]), share, along
    if i + 1 < len(run) and x > length - widths[i + 1]:
        share = _smooth_share(0.5 - 0.5 * (length - x) / widths[i + 1])
        along = normalized((1.0 - share) * ways[i] + share * ways[i + 1])
        return (run[i], run[i + 1]), share, along
    return (run[i], run[i]), 0.0, ways[i]


def _cap_ring(ring: _Ring, angle: float) -> _Ring:
    """Return a ring of the hemisphere that closes a skin."""
    middle = ring.middle + ring.radius * float(np.sin(angle)) * ring.along
    return _Ring(middle, ring.along, ring.radius * float(np.cos(angle)), ring.links, ring.share)


def _parallel_transport(ways: Sequence[Array]) -> Array:
    """Return directions (n, 3) across ways, transported from the first one without twist."""
    first = ways[0]
    across = np.eye(3)[int(np.abs(first).argmin())]
    found = []
    for way in ways:
        across = normalized(across - float((across * way).sum()) * way)
        found.append(across)
    return np.array(found)


def _smooth_share(s: float) -> float:
    return s * s * (3.0 - 2.0 * s)


@dataclass(frozen=True, eq=False)
class Stump:
    """The root of a limb.

    Attributes:
        link: number of its first link.
        ends: (2, 3) in the creation frame [m].
        radii: at the ends [m].
    """

    link: int
    ends: Array
    radii: tuple[float, float]


def find_stumps(
    limbs: Sequence[Limb], links: Sequence[Link], girth: float, material: str, own: str
) -> list[Stump]:
    """Return the stumps that grow from a body.

    Args:
        limbs: of the figure.
        links: of the figure.
        girth: radius of the body [m].
        material: of the body's solid.
        own: material of links that name none.
    """
    found = []
    for limb in limbs:
        number = limb.links[0]
        link = links[number]
        alike = (link.material or own) == (material or own)
        stout = link.radii[0] >= STUMP_SHAPE.min_radius * girth
        if limb.kind not in STUMP_SHAPE.kinds or not alike or not stout or link.shape != "round":
            continue
        span = link.ends[1] - link.ends[0]
        length = float(np.sqrt((span * span).sum()))
        part = min(STUMP_SHAPE.length * link.radii[0] / length, STUMP_SHAPE.max_length)
        end = link.radii[0] + (link.radii[1] - link.radii[0]) * part
        ends = np.stack([link.ends[0], link.ends[0] + part * span])
        found.append(Stump(number, ends, (link.radii[0], STUMP_SHAPE.end_ratio * end)))
    return found


def body_skin(
    points: Array,
    radii: Array,
    bones: Sequence[tuple[int, int]],
    flatness: float,
    stumps: Sequence[Stump],
) -> Skin:
    """Return the skin of a body and its stumps.

    Args:
        points: (n, 3) nodes in the creation frame [m].
        radii: (n,) of the solid at the nodes [m].
        bones: pairs of nodes.
        flatness: height, in the width.
        stumps: that grow from it.
    """
    n = len(points)
    everywhere = np.concatenate([points, *(stump.ends for stump in stumps)])
    thick = np.concatenate([radii, *(np.array(stump.radii) for stump in stumps)])
    more = [(n + 2 * k, n + 2 * k + 1) for k in range(len(stumps))]
    solid = body_solid(everywhere, thick, [*bones, *more], flatness)
    count = len(solid.vertices)
    links, share = np.zeros((count, 2), dtype=np.int64), np.zeros(count)
    if stumps:
        near = [_stump_weight(solid.vertices, stump) for stump in stumps]
        follows, distances = (np.array(values) for values in zip(*near, strict=True))
        nearest = distances.argmin(axis=0)
        rows = np.arange(count)
        links[:, 1] = np.array([stump.link for stump in stumps])[nearest]
        share = follows[nearest, rows] * _separation(distances)
    return Skin(solid.vertices, solid.faces, links, share)


def _separation(distances: Array) -> Array:
    """Return 0 halfway between two stumps, and 1 away from there (n,).

    Args:
        distances: (S, n) of places from the stumps' lines, in radii.
    """
    if len(distances) == 1:
        return np.ones(distances.shape[1])
    first, second = np.sort(distances, axis=0)[:2]
    return _smoothstep((second - first) / STUMP_SHAPE.separation)


def _stump_weight(places: Array, stump: Stump) -> tuple[Array, Array]:
    """Return how much places (n, 3) follow a limb, and their distance from it in radii.

    The weight grows along the stump, and fades away from it.
    """
    span = stump.ends[1] - stump.ends[0]
    square = float((span * span).sum())
    away = places - stump.ends[0]
    along = (away * span).sum(axis=-1) / square
    off = away - np.clip(along, 0.0, 1.0)[:, None] * span
    distance: Array = np.sqrt((off * off).sum(axis=-1)) / stump.radii[0]
    near = _smoothstep((2.5 - distance) / 1.6)
    return near * _smoothstep((along + 0.6) / 1.5), distance


def _smoothstep(s: Array) -> Array:
    s = np.clip(s, 0.0, 1.0)
    return s * s * (3.0 - 2.0 * s)
