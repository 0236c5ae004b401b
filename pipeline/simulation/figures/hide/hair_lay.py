"""The lay of the hair: how an animal's coat is combed, and how long it is, by part of the hide.

A hair is a vector from its root to its tip. It lies along the flow of the coat: from head to tail
over the trunk, sinking on the flanks, down the limbs, and out along the tail. Where limbs grow from
the body the flows go over into each other.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pipeline.simulation.combed_hair import combed
from pipeline.simulation.figures.hide.coat import Coat, arc_share
from pipeline.simulation.figures.hide.stance import smoothstep
from pipeline.simulation.figures.network import ARM, HEAD, LEG, TAIL
from pipeline.simulation.figures.solids import Solid, vertex_normals
from pipeline.simulation.spatial import UP, Array
from pipeline.spec.skin import CoatName

COATS: Mapping[CoatName, tuple[float, float]] = {
    "none": (0.0, 0.0),
    "smooth": (0.0, 0.0),
    "sleek": (0.05, 7.0),
    "short": (0.16, 19.0),
    "long": (0.28, 25.0),
    "shaggy": (0.45, 30.0),
}
"""Length of the hair on the back, in the body's radius, and how far it stands off [degrees]. Smooth
coats are drawn by their paint alone, and have the long hair of manes and tails."""

DEFAULT_COATS: Mapping[str, CoatName] = {"hooves": "sleek", "paws": "short", "toes": "shaggy"}
"""By the feet of a figure without a word for its coat; others are sleek."""

SINKING = 0.7
"""How much the hair of the flanks goes down, for one that it goes back."""

MERGING = 0.22
"""Width over which the flows of neighbouring parts go over into each other, in the body radius."""

LOCK_LENGTH = 3.0
"""Length of the hair of manes, brushes and tails, in that of the back of a short coat."""


EAR_HAIR, EAR_TUFT = 0.42, 0.9
"""Length of the hair on the back of an ear, and of that of its rim near the root, in that of the
back."""

EAR_LIFT = np.radians(14.0)
"""How far the hair of an ear stands off [rad]."""

FEATURE_REACH = 0.7
"""Length of the hair beside eyes, nostrils and mouth, in its distance from them: it hides none."""

BRUSH = 2.2
"""Length of the hair of a bushy tail, in that of the back."""


class HairLay:
    """The hair on the surfaces of one animal.

    Attributes:
        coat: of the animal.
        length: of the hair on its back [m].
        lift: of the hair from the hide [rad].
        is_shorn: whether it has no mane of hair either.
    """

    def __init__(self, coat: Coat) -> None:
        self.coat = coat
        figure = coat.stance.figure
        name = figure.skin.coat or DEFAULT_COATS.get(figure.feet, "sleek")
        length, lift = COATS[name]
        self.length = length * figure.skin.coat_length * coat.girth
        self.lift = float(np.radians(lift))
        self.is_shorn = name == "none"

    def hair(self, solid: Solid, limbs: list[int], is_head: bool = False) -> Array | None:
        """Return the hair (V, 3) at the vertices of a surface [m], None for a bare one.

        Args:
            solid: as the figure stands.
            limbs: numbers of the limbs that it covers.
            is_head: whether it is the skull's.
        """
        if self.length == 0.0:
            return None
        places, normals = solid.vertices, vertex_normals(solid.vertices, solid.faces)
        body = self.coat.stance.body_distance(places)
        flows = [self._trunk_flow(normals)]
        lengths = [np.full(len(places), self.length)]
        away = [body]
        for i in limbs:
            chain = self.coat.stance.chains[i]
            distances = chain.distances(places)
            away.append(distances.min(axis=0))
            way = chain.ways[distances.argmin(axis=0)]
            along = arc_share(chain.points, places)
            kind = chain.limb.kind
            # The coat of a neck lies away from the head.
            flows.append(-way if kind == HEAD else way)
            lengths.append(self.length * self._length_along(kind, along))
        # The nearest part counts most.
        nearness = np.array(away)
        weights = np.exp(-(nearness - nearness.min(axis=0)) / (MERGING * self.coat.girth))
        weights /= weights.sum(axis=0)
        flow = (weights[..., None] * np.array(flows)).sum(axis=0)
        length = (weights * np.array(lengths)).sum(axis=0)
        if is_head:
            flow, length = self._face(places, normals)
        factors = self.coat.hair_factors(solid, limbs, is_head)
        # Longer hair lies down by its weight.
        lift = self.lift / np.sqrt(np.maximum(factors, 1.0))
        return combed(flow, normals, length * factors, lift)

    def locks(self, solid: Solid, limb: int) -> Array | None:
        """Return the long hair (V, 3) of a mane or of a tail of hair, which hangs down [m]."""
        if self.is_shorn:
            return None
        chain = self.coat.stance.chains[limb]
        way = chain.ways[chain.distances(solid.vertices).argmin(axis=0)]
        back = 0.35 if chain.limb.kind == HEAD else -1.0
        length = np.full(len(way), LOCK_LENGTH * COATS["short"][0] * self.coat.girth)
        if chain.limb.kind == TAIL:
            length *= np.interp(arc_share(chain.points, solid.vertices), [0.7, 1.0], [1.0, 0.4])
        return combed(
            -UP - back * way, vertex_normals(solid.vertices, solid.faces), length, np.radians(8.0)
        )

    def ear(self, solid: Solid, inner: Array) -> Array | None:
        """Return the hair (V, 3) of an ear, whose inner side is bare but for its rim [m].

        Args:
            solid: the ear as the figure stands.
            inner: (V,) share of its inner side.
        """
        if self.length == 0.0:
            return None
        root, tip = solid.vertices[[-2, -1]]
        way = tip - root
        along = np.clip(((solid.vertices - root) @ way) / float(way @ way), 0.0, 1.0)
        length = self.length * np.interp(along, [0.0, 0.5, 1.0], [EAR_TUFT, EAR_HAIR, EAR_HAIR])
        length *= 1.0 - smoothstep(inner / 0.8)
        flow = np.broadcast_to(way, solid.vertices.shape)
        return combed(flow, vertex_normals(solid.vertices, solid.faces), length, EAR_LIFT)

    @staticmethod
    def _trunk_flow(normals: Array) -> Array:
        level = 1.0 - np.abs(normals[:, 1:2])
        result: Array = np.array([-1.0, 0.0, 0.0]) - SINKING * level * UP
        return result

    def _length_along(self, kind: str, along: Array) -> Array:
        """Return the length of the hair along a limb, in that of the back."""
        if kind in (LEG, ARM):
            # Short on shanks and paws, none on hooves and soles.
            end = 0.22 if self.coat.stance.figure.feet == "paws" else 0.0
            return np.interp(along, [0.0, 0.35, 0.6, 0.88, 0.95], [1.0, 0.8, 0.4, 0.28, end])
        if kind == TAIL:
            brush = self.coat.stance.figure.skin.tail in ("brush", "tassel")
            ends = [1.0, BRUSH, BRUSH, 0.6] if brush else [1.0, 0.9, 0.8, 0.5]
            return np.interp(along, [0.0, 0.3, 0.85, 1.0], ends)
        return np.ones(len(along))

    def _face(self, places: Array, normals: Array) -> tuple[Array, Array]:
        """Return the flow and the length of the hair of a skull: none on nose, lips and lids."""
        head = self.coat.head
        assert head is not None
        x = ((places - head.back) @ head.axes[0]) / head.length
        share = np.interp(x, [-0.1, 0.25, 0.7, 1.0], [0.85, 0.5, 0.25, 0.15])
        bare = smoothstep(1.6 * head.paint(places)[:, 3])
        flow = -head.axes[0] - 0.5 * (1.0 - np.abs(normals[:, 1:2])) * UP
        length = self.length * share * (1.0 - bare)
        return flow, np.minimum(length, FEATURE_REACH * head.clearance(places))
