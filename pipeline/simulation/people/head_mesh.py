"""Head mesh: skin of head and neck, eyes under lids, brows, lips and hair.

Lengths are in heads, from the middle of the head: X forward, Y up, Z to the right. A child's eyes
are larger and lower, its jaw and nose smaller.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.figures.solids import loft
from pipeline.simulation.people.proportions import BodyMeasures
from pipeline.simulation.people.signed_distance import (
    Field,
    ellipsoid,
    half_space,
    round_cone,
    smooth_difference,
    smooth_intersection,
    smooth_union,
)
from pipeline.simulation.people.skinned_surface import (
    SkinnedPatch,
    Surface,
    cached_part,
    ellipsoid_surface,
    merge_patches,
    polygonise,
    ramp,
    tube,
    with_mirror,
)
from pipeline.simulation.spatial import Array, normalized

EYE_DIRECTION = np.array([1.0, -0.01, 0.10])
"""Of the right eye."""


@dataclass(frozen=True)
class Head:
    """The head of a person.

    Attributes:
        build: measures of the person.
    """

    build: BodyMeasures

    @property
    def size(self) -> float:
        """Distance from chin to crown [m]."""
        p = self.build.proportions
        return p.head_size * p.height

    @property
    def centre(self) -> Array:
        """Middle (3,) [m]."""
        return np.array([0.02 * self.size, self.build.proportions.height - 0.5 * self.size, 0.0])

    def at(self, x: float, y: float, z: float) -> Array:
        """Return a place (3,) in the head [m]."""
        return self.centre + self.size * np.array([x, y, z])

    @property
    def eye(self) -> tuple[Array, float]:
        """Middle (3,) and radius of the right eye [m]."""
        child = self.build.childish
        radius = 0.070 + 0.014 * child
        return self.at(0.312 - 0.014 * child, 0.015 - 0.045 * child, 0.150), radius * self.size


@cached_part
def head_skin(head: Head) -> SkinnedPatch:
    """Return head, neck and ears, which turn between chest and head along the neck."""
    s, build = head.size, head.build
    centre = head.centre
    base = build.level(0.826)
    low = (centre[0] - 0.55 * s, base - 0.20 * s, -0.52 * s)
    high = (centre[0] + 0.66 * s, centre[1] + 0.56 * s, 0.52 * s)
    net = polygonise(_head_field(head), low, high, 0.063 * s, symmetric=True)
    y = net.vertices[:, 1]
    chin = float(head.at(0.0, -0.42, 0.0)[1])
    return net.follow("chest", "head", ramp(y, base + 0.15 * (chin - base), chin))


def _head_field(head: Head) -> Field:
    s, child = head.size, head.build.childish
    at, pair = head.at, _both_sides
    jaw = 1.0 - 0.10 * child
    solids = [
        ellipsoid(at(-0.045, 0.115, 0.0), s * np.array([0.430, 0.385, 0.345])),
        ellipsoid(
            at(0.090, -0.130 - 0.02 * child, 0.0),
            s * np.array([0.285, 0.330, 0.262 + 0.02 * child]),
        ),
        round_cone(
            at(0.215, -0.385, -0.035), at(0.215, -0.385, 0.035), 0.105 * s * jaw, 0.105 * s * jaw
        ),
        *pair(lambda m: ellipsoid(at(0.175, -0.150, 0.130 * m), (0.135 + 0.02 * child) * s)),
        *pair(
            lambda m: round_cone(
                at(0.330, 0.135, 0.05 * m), at(0.245, 0.125, 0.215 * m), 0.058 * s, 0.05 * s
            )
        ),
    ]
    skull = smooth_union(solids, 0.11 * s)
    sockets = smooth_union(
        pair(
            lambda m: ellipsoid(
                at(0.425, 0.020 - 0.05 * child, 0.150 * m), s * np.array([0.10, 0.075, 0.095])
            )
        ),
        0.02 * s,
    )
    skull = smooth_difference(skull, sockets, 0.09 * s)
    nose = 1.0 - 0.28 * child
    features = [
        skull,
        round_cone(
            at(0.345, 0.06, 0.0), at(0.375 + 0.075 * nose, -0.125, 0.0), 0.030 * s, 0.052 * s * nose
        ),
        *pair(lambda m: ellipsoid(at(0.375, -0.150, 0.048 * m * nose), 0.038 * s)),
        *pair(
            lambda m: round_cone(
                at(0.375, -0.252, 0.0),
                at(0.335, -0.262, 0.080 * m),
                0.026 * s,
                0.014 * s,
                (1.0, 0.8, 1.0),
            )
        ),
        round_cone(at(0.362, -0.292, -0.035), at(0.362, -0.292, 0.035), 0.030 * s, 0.030 * s),
        *pair(
            lambda m: ellipsoid(at(-0.035, -0.035, 0.335 * m), s * np.array([0.085, 0.135, 0.048]))
        ),
        _neck_field(head),
    ]
    return smooth_union(features, 0.045 * s)


def _neck_field(head: Head) -> Field:
    build = head.build
    g = build.girth
    base = (-0.010 * g, build.level(0.838), 0.0)
    return round_cone(base, head.at(-0.115, -0.22, 0.0), 0.0340 * g, 0.0315 * g)


def _both_sides(make: Callable[[float], Field]) -> list[Field]:
    return [make(1.0), make(-1.0)]


def eyeballs(head: Head) -> SkinnedPatch:
    """Return both eyeballs."""
    centre, radius = head.eye
    return with_mirror(ellipsoid_surface(centre, np.full(3, radius), 7, 10).follow("head"))


def irises(head: Head) -> SkinnedPatch:
    """Return both irises: lenses on the eyeballs."""
    return _on_eyes(head, 0.50, 0.63)


def pupils(head: Head) -> SkinnedPatch:
    """Return both pupils: smaller lenses on the irises."""
    return _on_eyes(head, 0.76, 0.33)


def _on_eyes(head: Head, ahead: float, size: float) -> SkinnedPatch:
    """Return a lens before each eye, by its place ahead and its radius in the eyeball's."""
    centre, radius = head.eye
    along = normalized(EYE_DIRECTION)
    lens = _lens(centre + ahead * radius * along, along, size * radius)
    return with_mirror(lens.follow("head"))


def _lens(centre: Array, along: Array, radius: float) -> Surface:
    surface = ellipsoid_surface(np.zeros(3), np.array([radius, 0.86 * radius, radius]), 5, 10)
    x = normalized(np.cross(along, [0.0, 0.0, 1.0]))
    R = np.stack([x, along, np.cross(x, along)], axis=-1)
    return Surface((surface.vertices[:, None, :] * R).sum(axis=-1) + centre, surface.faces)


def lids(head: Head) -> SkinnedPatch:
    """Return both upper and lower lids: caps over the eyes, for a calm look."""
    centre, radius = head.eye
    upper = _ball_cap(centre, 1.09 * radius, tilt=0.12, edge=0.30)
    lower = _ball_cap(centre, 1.07 * radius, tilt=np.pi - 0.15, edge=0.52)
    return with_mirror(merge_patches([upper.follow("head"), lower.follow("head")]))


def _ball_cap(centre: Array, radius: float, tilt: float, edge: float) -> Surface:
    """Return the cap of a ball above a plane that is tipped forward.

    Args:
        centre: (3,) of the ball [m].
        radius: of the ball [m].
        tilt: lean of the pole forward [rad].
        edge: height of the plane above the centre, in radii.
    """
    angle = np.linspace(np.arcsin(edge), np.pi / 2, 5)[:-1]
    turn = np.arange(10) * (2.0 * np.pi / 10)
    sizes, rises = np.cos(angle), np.sin(angle)
    # The rim has a thickness, closed inside of the ball.
    sizes, rises = np.concatenate([[0.90 * sizes[0]], sizes]), np.concatenate([[edge], rises])
    ring = np.stack(
        [
            sizes[:, None] * np.sin(turn),
            np.repeat(rises[:, None], 10, axis=1),
            sizes[:, None] * np.cos(turn),
        ],
        axis=-1,
    )
    solid = loft(ring, np.array([[0.0, edge, 0.0], [0.0, 1.0, 0.0]]))
    c, s = np.cos(tilt), np.sin(tilt)
    x, y, z = solid.vertices.T
    return Surface(
        centre + radius * np.stack([c * x + s * y, c * y - s * x, z], axis=-1), solid.faces
    )


def brows(head: Head) -> SkinnedPatch:
    """Return both brows."""
    s, child = head.size, head.build.childish
    lower = 0.03 * child
    line = [
        (0.394, 0.136 - lower, 0.066),
        (0.364, 0.150 - lower, 0.140),
        (0.288, 0.118 - lower, 0.225),
    ]
    points = np.array([head.at(*p) for p in line])
    return with_mirror(tube(points, s * np.array([0.016, 0.018, 0.010]), 6).follow("head"))


def lips(head: Head) -> SkinnedPatch:
    """Return both lips."""
    s, child = head.size, head.build.childish
    wide, up = 0.088 - 0.012 * child, 0.01 * child
    upper = [(0.346, -0.268, wide), (0.391, -0.256, 0.4 * wide), (0.400, -0.262, 0.0)]
    lower = [(0.346, -0.272, wide), (0.381, -0.293, 0.4 * wide), (0.389, -0.297, 0.0)]
    patches = []
    for half, thick in ((upper, 0.019), (lower, 0.023)):
        line = half + [(x, y, -z) for x, y, z in half[-2::-1]]
        points = np.array([head.at(x, y + up, z) for x, y, z in line])
        radii = s * thick * np.array([0.4, 0.95, 1.0, 0.95, 0.4])
        patches.append(tube(points, radii, 6).follow("head"))
    return merge_patches(patches)


Style = Callable[[Head], Field]


def _hair_cap(head: Head, thick: float) -> Field:
    """Return hair on the skull, cut off along a line from the forehead to the nape."""
    s, at = head.size, head.at
    skull = ellipsoid(at(-0.060, 0.125, 0.0), s * (np.array([0.430, 0.385, 0.345]) + thick))
    line = half_space(at(0.345, 0.270, 0.0), (0.72, -0.66, 0.0))
    return smooth_intersection(skull, line, 0.05 * s)


def _short(head: Head) -> Field:
    s, at = head.size, head.at
    tuft = round_cone(at(0.21, 0.42, -0.12), at(0.21, 0.42, 0.12), 0.088 * s, 0.088 * s)
    nape = ellipsoid(at(-0.27, -0.12, 0.0), s * np.array([0.20, 0.26, 0.26]))
    return smooth_union([_hair_cap(head, 0.034), tuft, nape], 0.07 * s)


def _bob(head: Head) -> Field:
    s, at = head.size, head.at
    sides = [
        round_cone(at(-0.06, 0.12, 0.30 * m), at(-0.04, -0.36, 0.315 * m), 0.11 * s, 0.10 * s)
        for m in (1, -1)
    ]
    back = round_cone(
        at(-0.26, 0.10, 0.0), at(-0.24, -0.36, 0.0), 0.22 * s, 0.20 * s, (1.0, 1.0, 1.45)
    )
    return smooth_union([_hair_cap(head, 0.052), *sides, back], 0.09 * s)


def _bun(head: Head) -> Field:
    s, at = head.size, head.at
    nape = ellipsoid(at(-0.27, -0.10, 0.0), s * np.array([0.19, 0.25, 0.25]))
    return smooth_union(
        [_hair_cap(head, 0.026), nape, ellipsoid(at(-0.50, 0.24, 0.0), 0.155 * s)], 0.05 * s
    )


def _long(head: Head) -> Field:
    s, at = head.size, head.at
    sides = [
        round_cone(at(-0.08, 0.14, 0.29 * m), at(-0.17, -0.52, 0.27 * m), 0.115 * s, 0.085 * s)
        for m in (1, -1)
    ]
    back = round_cone(
        at(-0.27, 0.12, 0.0), at(-0.36, -0.72, 0.0), 0.21 * s, 0.11 * s, (1.0, 1.0, 1.7)
    )
    return smooth_union([_hair_cap(head, 0.048), *sides, back], 0.10 * s)


HAIR_STYLES: Mapping[str, Style] = {"short": _short, "bob": _bob, "bun": _bun, "long": _long}


@cached_part
def hair_patch(head: Head, style: str) -> SkinnedPatch:
    """Return the hair of a head; below the chin it follows the back."""
    s, c = head.size, head.centre
    low = (c[0] - 0.80 * s, c[1] - (0.95 if style == "long" else 0.62) * s, -0.54 * s)
    high = (c[0] + 0.50 * s, c[1] + 0.62 * s, 0.54 * s)
    net = polygonise(HAIR_STYLES[style](head), low, high, 0.084 * s, symmetric=True)
    share = ramp(net.vertices[:, 1], float(c[1] - 0.85 * s), float(c[1] - 0.30 * s))
    return net.follow("chest", "head", share)
