"""Limb skins: links of one limb that look as if they were grown together.

Rings of vertices run along the links. Around a joint they follow both of its links, by shares
that go over from the one to the other, so that a knee that bends stays round.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.figures.skeleton import Limb, Link, Skeleton
from pipeline.simulation.figures.skins import Skin
from pipeline.simulation.figures.solids import lofted
from pipeline.simulation.spatial import Array, cross, normalized

AROUND = 14
"""Vertices of a ring."""

INNER = 5
"""Rings of a link between its joints."""

SOFT, HALF = 1.1, 0.42
"""How far from a joint its skin follows both links, in radii and at most in lengths of a link."""

CAP = np.radians([18.0, 40.0, 62.0, 80.0])
"""Latitudes of the rings of an end."""

EAR_LENGTH = 1.35
"""Length of an ear in lengths of its link."""

PEAK = np.log(0.5) / np.log(0.36)
"""Links are thickest at a third of their way, as a thigh is."""


@dataclass(frozen=True, slots=True)
class _Ring:
    """One ring: its middle and axis, radius, links, and the share of the second of these."""

    middle: Array
    along: Array
    radius: float
    links: tuple[int, int]
    share: float


def runs(limb: Limb, skeleton: Skeleton) -> list[tuple[int, ...]]:
    """Return the links of a limb that look as one, in order.

    Only what is round and of one material grows together, and nothing that slides.
    """
    found: list[list[int]] = []
    for number in limb.links:
        link = skeleton.links[number]
        if found and _grown_together(skeleton.links[found[-1][-1]], link, skeleton):
            found[-1].append(number)
        else:
            found.append([number])
    return [tuple(run) for run in found if skeleton.links[run[0]].shape == "round"]


def _grown_together(before: Link, link: Link, skeleton: Skeleton) -> bool:
    alike = before.shape == link.shape == "round" and before.material == link.material
    return alike and not bool(skeleton.prismatic[link.joint])


def limb_skin(run: Sequence[int], links: Sequence[Link], swelling: float) -> Skin:
    """Return the skin of links that have grown together.

    Args:
        run: their numbers, from the base outward.
        links: all of the skeleton.
        swelling: how much thicker than a cone they are in their thickest place, as a part.
    """
    rings = _rings(run, links, swelling)
    first, last = rings[0], rings[-1]
    begin = [_beyond(first, -angle) for angle in CAP[::-1]]
    end = [_beyond(last, angle) for angle in CAP]
    rings = [*begin, *rings, *end]
    y = _carried([ring.along for ring in rings])
    z = cross(np.array([ring.along for ring in rings]), y)
    angle = np.arange(AROUND) * (2.0 * np.pi / AROUND)
    around = np.cos(angle)[:, None] * y[:, None] + np.sin(angle)[:, None] * z[:, None]
    radii = np.array([ring.radius for ring in rings])
    places = np.array([ring.middle for ring in rings])[:, None] + radii[:, None, None] * around
    ends = np.stack(
        [first.middle - first.radius * first.along, last.middle + last.radius * last.along]
    )
    solid = lofted(places, ends)
    ringwise = [*np.repeat(np.arange(len(rings)), AROUND), 0, len(rings) - 1]
    pairs = np.array([ring.links for ring in rings])[ringwise]
    shares = np.array([ring.share for ring in rings])[ringwise]
    return Skin(solid.vertices, solid.faces, pairs, shares)


def leaf_skin(number: int, link: Link) -> Skin:
    """Return an ear: a leaf on a link, flat in the plane that it was drawn in."""
    span = EAR_LENGTH * (link.ends[1] - link.ends[0])
    along, across = normalized(span), normalized(cross(link.normal, span))
    s = np.linspace(0.0, 1.0, 12)
    wide = max(link.radii) * (0.6 + 2.6 * np.sin(np.pi * s**0.7)) * (1.0 - 0.55 * s)
    thick = 0.34 * wide
    angle = np.arange(AROUND) * (2.0 * np.pi / AROUND)
    normal = cross(along, across)
    flat = wide[:, None, None] * np.cos(angle)[:, None] * across
    flat = flat + thick[:, None, None] * np.sin(angle)[:, None] * normal
    places = link.ends[0] + s[:, None, None] * span + flat
    ends = np.stack([link.ends[0] - wide[0] * along, link.ends[0] + span + 0.4 * wide[-1] * along])
    return Skin.rigid(lofted(places, ends), number)


def _rings(run: Sequence[int], links: Sequence[Link], swelling: float) -> list[_Ring]:
    """Return the rings between the first joint and the tip of a run."""
    own = [links[number] for number in run]
    spans = np.array([link.ends[1] - link.ends[0] for link in own])
    lengths = np.sqrt((spans * spans).sum(axis=-1))
    ways = normalized(spans)
    widths = [0.0]
    for i, (before, after) in enumerate(itertools.pairwise(own)):
        shortest = HALF * float(min(lengths[i], lengths[i + 1]))
        widths.append(min(SOFT * max(before.radii[1], after.radii[0]), shortest))
    widths.append(0.0)
    rings = []
    for i, link in enumerate(own):
        for x in _places(float(lengths[i]), widths[i], widths[i + 1], last=i == len(own) - 1):
            s = x / float(lengths[i])
            a, b = link.radii
            radius = (a + (b - a) * s) * (
                1.0 + swelling * float(np.sin(np.pi * max(s, 0.0) ** PEAK))
            )
            middle = link.ends[0] + s * spans[i]
            pair, share, along = _joined(run, ways, i, x, float(lengths[i]), widths)
            rings.append(_Ring(middle, along, radius, pair, share))
    return rings


def _places(length: float, before: float, after: float, last: bool) -> list[float]:
    """Return the distances of a link's rings from its joint; the next link has that at its end."""
    start = [0.0, 0.5 * before] if before else [0.0]
    inner = np.linspace(before, length - after, INNER + 2)
    inner = inner[1:] if before == 0.0 else inner
    end = [length - 0.5 * after] if after else []
    places = [*start, *inner.tolist(), *end]
    return places if last or after else places[:-1]


def _joined(
    run: Sequence[int], ways: Array, i: int, x: float, length: float, widths: Sequence[float]
) -> tuple[tuple[int, int], float, Array]:
    """Return the links that a ring follows, the share of the second, and its axis."""
    if i > 0 and x < widths[i]:
        share = _smooth(0.5 + 0.5 * x / widths[i])
        along = normalized((1.0 - share) * ways[i - 1] + share * ways[i])
        return (run[i - 1], run[i]), share, along
    if i + 1 < len(run) and x > length - widths[i + 1]:
        share = _smooth(0.5 - 0.5 * (length - x) / widths[i + 1])
        along = normalized((1.0 - share) * ways[i] + share * ways[i + 1])
        return (run[i], run[i + 1]), share, along
    return (run[i], run[i]), 0.0, ways[i]


def _beyond(ring: _Ring, angle: float) -> _Ring:
    """Return a ring of the half ball that closes a skin."""
    middle = ring.middle + ring.radius * float(np.sin(angle)) * ring.along
    return _Ring(middle, ring.along, ring.radius * float(np.cos(angle)), ring.links, ring.share)


def _carried(ways: Sequence[Array]) -> Array:
    """Return a direction (n, 3) across each way, carried along from the first without a twist."""
    first = ways[0]
    across = np.eye(3)[int(np.abs(first).argmin())]
    found = []
    for way in ways:
        across = normalized(across - float((across * way).sum()) * way)
        found.append(across)
    return np.array(found)


def _smooth(s: float) -> float:
    return s * s * (3.0 - 2.0 * s)
