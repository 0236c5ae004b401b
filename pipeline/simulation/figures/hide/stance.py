"""Stances: a figure in its preferred pose, in which its hide is meshed, and what the hide follows.

A vertex follows two neighbouring links of one chain from the body through a limb. Its place on
that chain, 0 on the body, 1 on the first link, 2 on the second, is continuous over the hide, so
that no crease opens. Between two limbs it is 0. The mesh goes back to the creation frame by the
inverse of the blend that poses it, which is a rigid motion: as it stands, a figure has exactly the
shape that was meshed.

Source: Kavan et al. 2007 (dual quaternion blending of two motions).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.kinematics import JointTree
from pipeline.simulation.figures.skeleton import BODY, Limb
from pipeline.simulation.figures.skins import Skin
from pipeline.simulation.figures.solids import Solid
from pipeline.simulation.spatial import Array, cross, normalized, quaternion

ROOT_WIDTH = 1.1
"""Width of the change from body to limb, in the limb's radius at its root."""

JOINT_WIDTH = 1.3
"""Half the width of the change from link to link, in the radius there."""

MAX_JOINT_WIDTH = 0.42
"""The same at most, in the length of the shorter link."""

STRAIGHTENED = 0.6
"""How far the flesh of a foreleg goes from its bones to a straight line between hip and fetlock.

Limbs are drawn bent, so that they fold the right way; forelegs and columns stand straight.
"""

HIND_STRAIGHTENED = 0.32
"""The same of the hind legs of a mammal, whose stifle and hock stay bent."""

SPRAWL = 0.75
"""How much lower the elbow of a short spread leg is than its joint, in the rise of that."""

FOLDED, HEEL_DOWN = 0.72, 0.85
"""How much lower the knee of a spread leg with a heel is than its joint, in the rise of that, and
how far its heel comes down to the ground."""

_CONJUGATE = np.array([1.0, -1.0, -1.0, -1.0])


def smoothstep(s: Array) -> Array:
    """Return a smooth step from 0 at 0 to 1 at 1."""
    s = np.clip(s, 0.0, 1.0)
    return np.asarray(s * s * (3.0 - 2.0 * s), dtype=float)


@dataclass(frozen=True, eq=False)
class Chain:
    """A limb as it stands.

    Attributes:
        limb: of the figure.
        points: (n + 1, 3) its nodes [m].
        radii: (n + 1,) drawn at the nodes [m].
    """

    limb: Limb
    points: Array
    radii: Array

    @cached_property
    def spans(self) -> Array:
        """(n, 3) from node to node [m]."""
        return np.diff(self.points, axis=0)

    @cached_property
    def lengths(self) -> Array:
        """(n,) of the links [m]."""
        return np.maximum(np.linalg.norm(self.spans, axis=-1), 1e-9)

    @cached_property
    def ways(self) -> Array:
        """(n, 3) directions of the links."""
        return self.spans / self.lengths[:, None]

    def distances(self, places: Array) -> Array:
        """Return the distances (n, N) of places (N, 3) from the surfaces of the links [m]."""
        found = [
            segment_distance(places, a, b, r_a, r_b)
            for a, b, r_a, r_b in zip(
                self.points[:-1], self.points[1:], self.radii[:-1], self.radii[1:], strict=True
            )
        ]
        return np.array(found)

    def coordinates(self, places: Array, distances: Array) -> Array:
        """Return the places (N,) along the chain, 1 on its first link, of places (N, 3)."""
        nearest = distances.argmin(axis=0)
        result = np.ones(len(places))
        for i in range(len(self.spans) - 1):
            shortest = MAX_JOINT_WIDTH * float(min(self.lengths[i], self.lengths[i + 1]))
            width = min(JOINT_WIDTH * float(self.radii[i + 1]), shortest)
            across = normalized(self.ways[i] + self.ways[i + 1])
            beyond = ((places - self.points[i + 1]) * across).sum(axis=-1)
            share = smoothstep(0.5 + 0.5 * beyond / width)
            result += np.where(nearest < i, 0.0, np.where(nearest > i + 1, 1.0, share))
        return result


def segment_distance(places: Array, a: Array, b: Array, r_a: float, r_b: float) -> Array:
    """Return the distances (N,) of places (N, 3) from a round cone, about [m]."""
    span = b - a
    square = max(float((span * span).sum()), 1e-18)
    along = np.clip(((places - a) * span).sum(axis=-1) / square, 0.0, 1.0)
    off = places - a - along[:, None] * span
    return np.asarray(np.sqrt((off * off).sum(axis=-1)) - (r_a + along * (r_b - r_a)))


@dataclass(frozen=True, eq=False)
class Stance:
    """A figure as it stands, in the frame of its body: X ahead, Y up, Z to the right.

    Attributes:
        figure: any figure.
    """

    figure: Figure

    @cached_property
    def _motions(self) -> tuple[Array, Array]:
        """Rotations (L, 3, 3) and shifts (L, 3) of the links from the creation frame [m]."""
        skeleton = self.figure.skeleton
        X_BJ = JointTree.of(skeleton).pose(skeleton.preferred)
        turns, shifts = [], []
        for link in skeleton.links:
            if link.joint == BODY:
                turns.append(np.eye(3))
                shifts.append(np.zeros(3))
                continue
            R = X_BJ[link.joint][:3, :3]
            turns.append(R)
            place = skeleton.places[link.joint]
            shifts.append(X_BJ[link.joint][:3, 3] - (R * place).sum(axis=1))
        return np.array(turns), np.array(shifts)

    @cached_property
    def ground(self) -> float:
        """Height of the soles [m]."""
        legs = [self.chain(limb) for limb in self.figure.skeleton.legs]
        if not legs:
            return -self.figure.belly
        return min(float(leg.points[-1, 1] - leg.radii[-1]) for leg in legs)

    @cached_property
    def chains(self) -> tuple[Chain, ...]:
        """All limbs."""
        return tuple(self.chain(limb) for limb in self.figure.skeleton.limbs)

    def chain(self, limb: Limb) -> Chain:
        """Return a limb as it stands."""
        skeleton = self.figure.skeleton
        number = skeleton.limbs.index(limb)
        nodes = self.figure.anatomy.appendages[number].nodes
        links = [skeleton.links[i] for i in limb.links]
        points = [self.placed(limb.links[0], links[0].ends[0])]
        points += [self.placed(i, link.ends[1]) for i, link in zip(limb.links, links, strict=True)]
        radii = self.figure.drawing.radii[list(nodes)] * self.figure.scale
        placed = np.array(points)
        if limb in self.straight_legs and len(placed) > 3:
            placed = _straightened(placed, STRAIGHTENED)
        elif self._is_hind(limb) and len(placed) > 3:
            placed = _straightened(placed, HIND_STRAIGHTENED)
        elif self._sprawls(limb):
            rise = max(float(placed[1, 1] - placed[0, 1]), 0.0)
            placed[1, 1] -= SPRAWL * rise
        elif self._folds(limb):
            # Thigh and shank lie beside the body, and the heel on the ground.
            rise = max(float(placed[1, 1] - placed[0, 1]), 0.0)
            placed[1, 1] -= FOLDED * rise
            heel = float(placed[3, 1] + radii[2] - radii[3])
            placed[2, 1] += HEEL_DOWN * min(heel - float(placed[2, 1]), 0.0)
        return Chain(limb, placed, radii)

    def _sprawls(self, limb: Limb) -> bool:
        """Return whether a limb is a short spread leg of an animal, as of a lizard."""
        figure = self.figure
        is_spread = figure.style != "mammal" and figure.skin.shell == "plain"
        return is_spread and limb in figure.skeleton.legs and len(limb.links) == 2

    def _folds(self, limb: Limb) -> bool:
        """Return whether a limb is a spread leg of an animal with a heel, as a frog's hind leg."""
        figure = self.figure
        is_spread = figure.style != "mammal" and figure.skin.shell == "plain"
        return is_spread and limb in figure.skeleton.legs and len(limb.links) == 3

    def _is_hind(self, limb: Limb) -> bool:
        """Return whether a limb is a bent leg of a mammal on four legs."""
        legs = self.figure.skeleton.legs
        return bool(self.straight_legs) and limb in legs and limb not in self.straight_legs

    @cached_property
    def straight_legs(self) -> tuple[Limb, ...]:
        """The front pair of a mammal on four legs; all of them where they are columns."""
        skeleton = self.figure.skeleton
        if self.figure.style != "mammal" or len(skeleton.legs) < 4:
            return ()
        if self.figure.feet == "plain":
            return tuple(skeleton.legs)
        ahead = [
            float(self.placed(leg.links[0], skeleton.links[leg.links[0]].ends[0])[0])
            for leg in skeleton.legs
        ]
        middle = float(np.median(ahead))
        return tuple(leg for leg, x in zip(skeleton.legs, ahead, strict=True) if x >= middle)

    def placed(self, link: int, points: Array) -> Array:
        """Return points (..., 3) of the creation frame as they stand on a link [m]."""
        R, shift = (values[link] for values in self._motions)
        result: Array = (points[..., None, :] * R).sum(axis=-1) + shift
        return result

    def follow(self, places: Array, limbs: Sequence[int]) -> tuple[NDArray[np.int64], Array]:
        """Return the links (N, 2) that places (N, 3) follow, and the share of the second (N,).

        Args:
            places: as the figure stands [m].
            limbs: numbers of the limbs that may be followed.
        """
        links, share = np.zeros((len(places), 2), dtype=np.int64), np.zeros(len(places))
        chains = [self.chains[i] for i in limbs]
        if not chains:
            return links, share
        body = self.body_distance(places)
        each = [chain.distances(places) for chain in chains]
        near = np.array([distances.min(axis=0) for distances in each])
        best = near.argmin(axis=0)
        rows = np.arange(len(places))
        own = near[best, rows]
        if len(chains) > 1:
            other = np.sort(near, axis=0)[1]
        for k, (chain, distances) in enumerate(zip(chains, each, strict=True)):
            mine = np.flatnonzero(best == k)
            width = ROOT_WIDTH * float(chain.radii[:2].mean())
            off = smoothstep(0.5 + 0.5 * (body[mine] - own[mine]) / width)
            if len(chains) > 1:
                # Less far from the body: feet side by side follow their own legs.
                clear = smoothstep((body[mine] - own[mine]) / width - 0.5)
                between = (0.5 - 0.26 * clear) * width
                off *= smoothstep((other[mine] - own[mine]) / between)
            at = off * chain.coordinates(places[mine], distances[:, mine])
            numbers = np.array([0, *chain.limb.links])
            lower = np.clip(np.floor(at).astype(int), 0, len(numbers) - 2)
            links[mine] = np.stack([numbers[lower], numbers[lower + 1]], axis=-1)
            share[mine] = at - lower
        return links, share

    def body_distance(self, places: Array) -> Array:
        """Return the distances (N,) of places from the body [m]."""
        figure, nodes = self.figure, list(self.figure.anatomy.body)
        bones = list(figure.anatomy.bones) or [(nodes[0], nodes[0])]
        radii = figure.drawing.radii * figure.scale
        found = [
            segment_distance(
                places, figure.points[a], figure.points[b], float(radii[a]), float(radii[b])
            )
            for a, b in bones
        ]
        return np.asarray(np.min(found, axis=0))

    def hide(
        self,
        solid: Solid,
        limbs: Sequence[int],
        paint: Array | None = None,
        hair: Array | None = None,
    ) -> Skin:
        """Return a surface that was meshed as the figure stands, in the creation frame."""
        links, share = self.follow(solid.vertices, limbs)
        places = self.unposed(solid.vertices, links, share)
        if hair is not None:
            # What a vertex follows moves it rigidly, and its hair with it.
            hair = self.unposed(solid.vertices + hair, links, share) - places
        return Skin(places, solid.faces, links, share, paint, hair)

    def rigid(
        self, solid: Solid, link: int, paint: Array | None = None, hair: Array | None = None
    ) -> Skin:
        """Return a surface that was meshed as the figure stands and follows one link."""
        links = np.full((len(solid.vertices), 2), link, dtype=np.int64)
        share = np.zeros(len(links))
        places = self.unposed(solid.vertices, links, share)
        if hair is not None:
            hair = self.unposed(solid.vertices + hair, links, share) - places
        return Skin(places, solid.faces, links, share, paint, hair)

    def chained(self, solid: Solid, chain: Chain, root: int, paint: Array | None = None) -> Skin:
        """Return a surface along a chain that grows from link `root`, in the creation frame."""
        places = solid.vertices
        at = chain.coordinates(places, chain.distances(places))
        along = ((places - chain.points[0]) * chain.ways[0]).sum(axis=-1)
        at -= 1.0 - smoothstep(along / (0.5 * float(chain.lengths[0])))
        numbers = np.array([root, *chain.limb.links])
        lower = np.clip(np.floor(at).astype(int), 0, len(numbers) - 2)
        links, share = np.stack([numbers[lower], numbers[lower + 1]], axis=-1), at - lower
        return Skin(self.unposed(places, links, share), solid.faces, links, share, paint)

    def unposed(self, places: Array, links: NDArray[np.int64], share: Array) -> Array:
        """Return places (N, 3) as they stand in the creation frame [m]."""
        turns, shifts = self._motions
        q = quaternion(turns)
        a, b = links.T
        turned = _product(q[b], q[a] * _CONJUGATE)
        turned = turned * np.where(turned[:, :1] < 0.0, -1.0, 1.0)
        # The motion from the first link's frame to the second's: there = turned (here) + shift.
        shift = shifts[b] - _turned(turned, shifts[a])
        part = share[:, None]
        dual = 0.5 * _product(np.concatenate([np.zeros_like(part), shift], axis=-1), turned)
        real = part * turned
        real[:, :1] += 1.0 - part
        norm = np.maximum(np.sqrt((real * real).sum(axis=-1, keepdims=True)), 1e-12)
        real, dual = real / norm, part * dual / norm
        moved = 2.0 * _product(dual, real * _CONJUGATE)[:, 1:]
        here = _turned(real * _CONJUGATE, places - moved)
        return _turned(q[a] * _CONJUGATE, here - shifts[a])


def _straightened(points: Array, share: float) -> Array:
    """Return the nodes (n, 3) of a leg with its inner joints but the last nearer to a line."""
    result = points.copy()
    last = len(points) - (2 if len(points) > 4 else 1)
    a, b = points[0], points[last]
    for k in range(1, last):
        t = (points[k, 1] - a[1]) / min(b[1] - a[1], -1e-9)
        on_line = a + t * (b - a)
        result[k] += share * (on_line - points[k])
    return result


def _product(a: Array, b: Array) -> Array:
    """Return the products (n, 4) of quaternions wxyz."""
    w = a[:, :1] * b[:, :1] - (a[:, 1:] * b[:, 1:]).sum(axis=-1, keepdims=True)
    v = a[:, :1] * b[:, 1:] + b[:, :1] * a[:, 1:] + cross(a[:, 1:], b[:, 1:])
    return np.concatenate([w, v], axis=-1)


def _turned(q: Array, v: Array) -> Array:
    """Return vectors (n, 3) turned by unit quaternions (n, 4)."""
    w, u = q[:, :1], q[:, 1:]
    once = cross(u, v)
    return np.asarray(v + 2.0 * (w * once + cross(u, once)))
