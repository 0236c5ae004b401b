"""Chain: a figure of one chain without a branch, as an inchworm sees it.

Its two end links are its feet. Between them runs a limb whose base and tip can be
swapped: the same joints, counted from the other end.

Source: Sims 1987, 5.3 and figure 5.7.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.base_change import limb_between
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.kinematics import LimbBatch
from pipeline.simulation.figures.network import HEAD, TAIL
from pipeline.simulation.figures.skeleton import FORWARD, Limb, Link, Skeleton
from pipeline.simulation.spatial import Array

REAR, FRONT = 0, 1
"""The two ends."""

STRAIGHTNESS = 1e-3
"""How far from one line the joints of a chain may be drawn, as a part of its length."""

MIN_BENDS = 3
"""Places at which a chain must bend to carry one end to any place in any direction."""

SIDEWAYS = np.array([0.0, 0.0, 1.0])


def is_inchworm(figure: Figure) -> bool:
    """Tell whether a figure is one straight chain that can put one end before the other.

    It has a head and a tail and no other limb, lies along its own X as it was drawn, and
    bends up and down in three places or more.
    """
    skeleton = figure.skeleton
    if [limb.kind for limb in skeleton.limbs] != [HEAD, TAIL] or skeleton.prismatic.any():
        return False
    head, tail = skeleton.limbs
    bends = np.abs(skeleton.axes @ SIDEWAYS) > 1.0 - STRAIGHTNESS
    places = len(np.unique(np.round(skeleton.places[bends, 0] / (STRAIGHTNESS * head.length))))
    points = np.concatenate([skeleton.places, [head.tip, tail.tip]])
    astray = np.abs(points[:, 1:] - points[0, 1:]).max()
    straight = float(head.tip[0] - tail.tip[0]) > 0.0
    return places >= MIN_BENDS and straight and bool(astray <= STRAIGHTNESS * head.length)


@dataclass(frozen=True, eq=False)
class EndFoot:
    """An end link, which lies on the ground while the worm stands on it.

    Attributes:
        link: the link.
        number: of it in the skeleton.
        limb: the limb, head or tail, that ends in it.
        solid: (V, 3) its surface in the creation frame [m].
    """

    link: Link
    number: int
    limb: Limb
    solid: Array

    @property
    def length(self) -> float:
        """From node to node [m]."""
        return float(np.linalg.norm(self.link.ends[1] - self.link.ends[0]))

    @property
    def middle(self) -> Array:
        """(3,) in the creation frame [m]."""
        result: Array = self.link.ends.mean(axis=0)
        return result

    @property
    def taper(self) -> float:
        """Angle by which its axis rises to the front when its underside lies level [rad]."""
        inner, outer = self.link.radii
        towards = float(np.sign(self.link.ends[1, 0] - self.link.ends[0, 0]))
        return towards * (outer - inner) / self.length


@dataclass(frozen=True, eq=False)
class InchwormChain:
    """One worm's joints and links.

    Attributes:
        figure: whose they are.
        feet: the rear and the front end.
        rooted: the skeleton with either end as its base.
        limbs: from either end to the other, tip in the middle of the other foot.
    """

    figure: Figure
    feet: tuple[EndFoot, EndFoot]
    rooted: tuple[Skeleton, Skeleton]
    limbs: tuple[Limb, Limb]

    @staticmethod
    def of(figure: Figure) -> InchwormChain:
        """Find both ends of a figure that `is_inchworm`."""
        skeleton = figure.skeleton
        pieces = figure.pieces
        feet = []
        for limb in (skeleton.limbs[1], skeleton.limbs[0]):
            number = limb.links[-1]
            solid = next(p.solid.vertices for p in pieces if p.link == number)
            feet.append(EndFoot(skeleton.links[number], number, limb, solid))
        rear, front = feet
        ways = [
            limb_between(skeleton, base.link.name, tip.link.name, tip.middle)
            for base, tip in ((rear, front), (front, rear))
        ]
        (one, there), (other, back) = ways
        return InchwormChain(figure, (rear, front), (one, other), (there, back))

    @cached_property
    def batches(self) -> tuple[LimbBatch, LimbBatch]:
        """The limb from the rear end to the front end, and the one back."""
        one, other = (
            LimbBatch.of([(s, limb)]) for s, limb in zip(self.rooted, self.limbs, strict=True)
        )
        return one, other

    @cached_property
    def _from_rear(self) -> tuple[Array, Array, NDArray[np.int64]]:
        """Joint by joint from the rear: x [m], how it raises the front, and its place's number."""
        joints = list(self.limbs[REAR].joints)
        x = self.rooted[REAR].places[joints] @ FORWARD
        lift = np.round(self.rooted[REAR].axes[joints] @ SIDEWAYS)
        apart = np.diff(x, prepend=x[0]) > STRAIGHTNESS * self.length
        return x, lift, np.cumsum(apart)

    @cached_property
    def spans(self) -> Array:
        """(m,) lengths of the links between the feet, from the rear [m]."""
        x, _, _ = self._from_rear
        steps = np.diff(x)
        result: Array = steps[steps > STRAIGHTNESS * self.length]
        return result

    @cached_property
    def along(self) -> Array:
        """(m,) where the middles of these links are, 0 at the rear foot and 1 at the front one."""
        ends = np.cumsum(self.spans)
        result: Array = (ends - 0.5 * self.spans) / ends[-1]
        return result

    @property
    def length(self) -> float:
        """From tip to tip, stretched out [m]."""
        head, tail = self.figure.skeleton.limbs
        return float(head.tip[0] - tail.tip[0])

    @property
    def free(self) -> float:
        """Length of what is between the feet [m]."""
        return float(self.spans.sum())

    @property
    def thickness(self) -> float:
        """Greatest radius of any link [m]."""
        return max(max(link.radii) for link in self.figure.skeleton.links)

    @property
    def outside(self) -> float:
        """From the middle of one foot to that of the other, less what is between them [m]."""
        return 0.5 * (self.feet[REAR].length + self.feet[FRONT].length)

    def joint_values(self, bends: Array) -> Array:
        """Return the joint values (n, J), from the rear, that bend the chain upward.

        Joints at one place share its bend; those that turn sideways or roll are at zero.

        Args:
            bends: (n, m + 1) how each link points higher than the one behind it [rad].
        """
        _, lift, place = self._from_rear
        sharing = np.bincount(place, weights=np.abs(lift), minlength=bends.shape[1])
        share = lift / np.maximum(sharing, 1.0)[place]
        result: Array = bends[:, place] * share
        return result


MAX_AMPLITUDE = 2.0
"""Amplitude A of the tightest loop [rad]; at 2.4 its two sides would meet."""

MIN_AMPLITUDE = 0.05
"""Least amplitude: below it a chord hardly depends on the amplitude."""

NEWTON_STEPS = 12
"""Iterations; eight are enough for the last bit anywhere between the bounds."""

END_FALLOFF = 3.0
"""How fast the direction of a foot is forgotten along the chain."""


def loop_chord(chain: InchwormChain, loop_amplitude: Array | float) -> Array:
    """Return how far apart the feet's inner ends are in loops of `loop_amplitude` (...) [m]."""
    wave = np.sin(2.0 * np.pi * chain.along)
    θ = np.asarray(loop_amplitude)[..., None] * wave
    # By rows: a BLAS would let the last bit depend on how many there are.
    result: Array = (np.cos(θ) * chain.spans).sum(axis=-1)
    return result


def loop_neck(chain: InchwormChain, loop_amplitude: Array) -> Array:
    """Return how far apart the two sides of loops of `loop_amplitude` (n,) come [m].

    Where they lean over, A > π/2, that is where they stand upright.
    """
    s = chain.along
    θ = loop_amplitude[:, None] * np.sin(2.0 * np.pi * s)
    sides = np.where(np.abs(s - 0.5) > 0.25, np.maximum(np.cos(θ), 0.0), 0.0)
    result: Array = loop_chord(chain, loop_amplitude) - (sides * chain.spans).sum(axis=1)
    return result


def loop_amplitude(chain: InchwormChain, chords: Array) -> Array:
    """Return the amplitudes (n,) of loops over `chords` (n,) [m]; see `loop_chord`."""
    wave = np.sin(2.0 * np.pi * chain.along)
    low, high = loop_chord(chain, np.array([MAX_AMPLITUDE, MIN_AMPLITUDE]))
    wanted = np.clip(chords, low, high)
    # J₀(A) = 1 - A²/4 + ..., a bound from above on a curve without a turning point between.
    A = np.clip(2.0 * np.sqrt(1.0 - wanted / chain.free), MIN_AMPLITUDE, MAX_AMPLITUDE)
    for _ in range(NEWTON_STEPS):
        slope = -(np.sin(A[:, None] * wave) * wave * chain.spans).sum(axis=-1)
        A = np.clip(A - (loop_chord(chain, A) - wanted) / slope, MIN_AMPLITUDE, MAX_AMPLITUDE)
    return A


def loop_bends(
    chain: InchwormChain, chords: Array, slope: Array, rear: Array, front: Array
) -> Array:
    """Return how each link points higher than the one behind it (n, m + 1) [rad].

    Args:
        chain: the worm.
        chords: (n,) from one foot's inner end to the other's [m].
        slope: (n,) elevation of that way [rad].
        rear: (n,) elevation of the rear foot [rad].
        front: (n,) of the front foot [rad].
    """
    s = chain.along
    θ = slope[:, None] + loop_amplitude(chain, chords)[:, None] * np.sin(2.0 * np.pi * s)
    θ += (rear - slope)[:, None] * (1.0 - s) ** END_FALLOFF + (front - slope)[
        :, None
    ] * s**END_FALLOFF
    result: Array = np.diff(np.column_stack([rear, θ, front]), axis=1)
    return result
