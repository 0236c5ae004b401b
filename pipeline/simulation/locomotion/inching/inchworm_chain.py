"""The chain of an inchworm, and the loop that it takes between its feet.

The two end links of a figure without branches are its feet. The limb between them can be used from
either end: the same joints, with base and tip swapped.

The loop: let s run from 0 at the rear foot to 1 at the front one. A chain whose links are inclined
by θ(s) = A sin 2πs leaves the ground along it, rises into a loop and returns along it; its ends
are Σ l cos θ apart, which tends to J₀(A) of its length for many links. This is close to the
elastica, the shape of least bending of a rod with clamped ends: a low arch while the ends are far
apart, an omega when they meet. Feet that are inclined themselves bend θ near them.

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
"""Numbers of the two ends."""

STRAIGHTNESS = 1e-3
"""Greatest offset of joints from one line, as a fraction of the chain's length."""

MIN_BENDS = 3
"""Bending places that a chain needs to carry one end anywhere in any orientation."""

SIDEWAYS = np.array([0.0, 0.0, 1.0])


MAX_AMPLITUDE = 2.0
"""Amplitude A of the tightest loop [rad]; at 2.4 its two sides would meet."""

MIN_AMPLITUDE = 0.05
"""Least amplitude: below it the chord hardly depends on the amplitude [rad]."""

NEWTON_STEPS = 12
"""Iterations; eight reach the last bit anywhere between the bounds."""

END_FALLOFF = 3.0
"""Exponent of the decay of a foot's inclination along the chain."""


def is_inchworm(figure: Figure) -> bool:
    """Return whether a figure is one straight chain that can put one end before the other.

    It has a head, a tail and no other limb, lies along its X as drawn, and bends up and down in
    three places or more.
    """
    skeleton = figure.skeleton
    if [limb.kind for limb in skeleton.limbs] != [HEAD, TAIL] or skeleton.prismatic.any():
        return False
    head, tail = skeleton.limbs
    bends = np.abs(skeleton.axes @ SIDEWAYS) > 1.0 - STRAIGHTNESS
    places = len(np.unique(np.round(skeleton.places[bends, 0] / (STRAIGHTNESS * head.length))))
    points = np.concatenate([skeleton.places, [head.tip, tail.tip]])
    offset = np.abs(points[:, 1:] - points[0, 1:]).max()
    straight = float(head.tip[0] - tail.tip[0]) > 0.0
    return places >= MIN_BENDS and straight and bool(offset <= STRAIGHTNESS * head.length)


@dataclass(frozen=True, eq=False)
class EndFoot:
    """An end link, which lies on the ground while the worm stands on it.

    Attributes:
        link: the link.
        number: of the link in the skeleton.
        limb: head or tail, which ends in the link.
        solid: (V, 3) its vertices in the creation frame [m].
    """

    link: Link
    number: int
    limb: Limb
    solid: Array

    @property
    def length(self) -> float:
        """Length between its nodes [m]."""
        return float(np.linalg.norm(self.link.ends[1] - self.link.ends[0]))

    @property
    def middle(self) -> Array:
        """(3,) in the creation frame [m]."""
        return self.link.ends.mean(axis=0)

    @property
    def taper(self) -> float:
        """Inclination of its axis while its underside is level [rad]."""
        inner, outer = self.link.radii
        towards = float(np.sign(self.link.ends[1, 0] - self.link.ends[0, 0]))
        return towards * (outer - inner) / self.length


@dataclass(frozen=True, eq=False)
class InchwormChain:
    """Joints and links of one worm.

    Attributes:
        figure: of the worm.
        feet: rear and front end.
        rooted: the skeleton with either end as its base.
        limbs: from either end to the other, with the tip in the middle of the other foot.
    """

    figure: Figure
    feet: tuple[EndFoot, EndFoot]
    rooted: tuple[Skeleton, Skeleton]
    limbs: tuple[Limb, Limb]

    @staticmethod
    def of(figure: Figure) -> InchwormChain:
        """Return the chain of a figure that `is_inchworm`."""
        skeleton = figure.skeleton
        pieces = figure.pieces
        feet = []
        for limb in (skeleton.limbs[1], skeleton.limbs[0]):
            number = limb.links[-1]
            solid = next(p.solid.vertices for p in pieces if p.link == number)
            feet.append(EndFoot(skeleton.links[number], number, limb, solid))
        rear, front = feet
        rooted_limbs = [
            limb_between(skeleton, base.link.name, tip.link.name, tip.middle)
            for base, tip in ((rear, front), (front, rear))
        ]
        (from_rear, forward), (from_front, backward) = rooted_limbs
        return InchwormChain(figure, (rear, front), (from_rear, from_front), (forward, backward))

    @cached_property
    def batches(self) -> tuple[LimbBatch, LimbBatch]:
        """The limb from the rear end to the front end, and its reverse."""
        forward, backward = (
            LimbBatch.of([(s, limb)]) for s, limb in zip(self.rooted, self.limbs, strict=True)
        )
        return forward, backward

    @cached_property
    def _from_rear(self) -> tuple[Array, Array, NDArray[np.int64]]:
        """Joints from the rear: x [m], sign of raising the front, number of their place."""
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
        return steps[steps > STRAIGHTNESS * self.length]

    @cached_property
    def along(self) -> Array:
        """(m,) middles of these links, 0 at the rear foot and 1 at the front one."""
        ends = np.cumsum(self.spans)
        return (ends - 0.5 * self.spans) / ends[-1]

    @property
    def length(self) -> float:
        """Length from tip to tip, stretched [m]."""
        head, tail = self.figure.skeleton.limbs
        return float(head.tip[0] - tail.tip[0])

    @property
    def free(self) -> float:
        """Length between the feet, stretched [m]."""
        return float(self.spans.sum())

    @property
    def thickness(self) -> float:
        """Greatest radius of any link [m]."""
        return max(max(link.radii) for link in self.figure.skeleton.links)

    @property
    def outside(self) -> float:
        """Distance between the middles of the feet, less the length between the feet [m]."""
        return 0.5 * (self.feet[REAR].length + self.feet[FRONT].length)

    def joint_values(self, bends: Array) -> Array:
        """Return the joint values (n, J), from the rear, that bend the chain upward.

        Joints at one place share its bend; those that turn sideways or roll are zero.

        Args:
            bends: (n, m + 1) change of inclination at each place [rad].
        """
        _, lift, place = self._from_rear
        sharing = np.bincount(place, weights=np.abs(lift), minlength=bends.shape[1])
        share = lift / np.maximum(sharing, 1.0)[place]
        return bends[:, place] * share


def loop_chord(chain: InchwormChain, amplitude: Array | float) -> Array:
    """Return the distance between the feet's inner ends in loops of `amplitude` (...) [m]."""
    wave = np.sin(2.0 * np.pi * chain.along)
    θ = np.asarray(amplitude)[..., None] * wave
    # Not by matmul: a BLAS result depends on the number of rows in the last bit.
    return (np.cos(θ) * chain.spans).sum(axis=-1)


def loop_neck(chain: InchwormChain, amplitude: Array) -> Array:
    """Return the least distance between the two sides of loops of `amplitude` (n,) [m].

    Where the sides lean over, A > π/2, it is at their upright parts.
    """
    s = chain.along
    θ = amplitude[:, None] * np.sin(2.0 * np.pi * s)
    sides = np.where(np.abs(s - 0.5) > 0.25, np.maximum(np.cos(θ), 0.0), 0.0)
    return loop_chord(chain, amplitude) - (sides * chain.spans).sum(axis=1)


def loop_amplitude(chain: InchwormChain, chords: Array) -> Array:
    """Return the amplitudes (n,) of loops over `chords` (n,) [m]; inverse of `loop_chord`."""
    wave = np.sin(2.0 * np.pi * chain.along)
    low, high = loop_chord(chain, np.array([MAX_AMPLITUDE, MIN_AMPLITUDE]))
    wanted = np.clip(chords, low, high)
    # J₀(A) = 1 - A²/4 + ... bounds the monotone curve from above.
    A = np.clip(2.0 * np.sqrt(1.0 - wanted / chain.free), MIN_AMPLITUDE, MAX_AMPLITUDE)
    for _ in range(NEWTON_STEPS):
        slope = -(np.sin(A[:, None] * wave) * wave * chain.spans).sum(axis=-1)
        A = np.clip(A - (loop_chord(chain, A) - wanted) / slope, MIN_AMPLITUDE, MAX_AMPLITUDE)
    return A


def loop_bends(
    chain: InchwormChain, chords: Array, slope: Array, rear: Array, front: Array
) -> Array:
    """Return the change of inclination at each place of the chain (n, m + 1) [rad].

    Args:
        chain: the worm.
        chords: (n,) between the feet's inner ends [m].
        slope: (n,) inclination of the chord [rad].
        rear: (n,) inclination of the rear foot [rad].
        front: (n,) inclination of the front foot [rad].
    """
    s = chain.along
    θ = slope[:, None] + loop_amplitude(chain, chords)[:, None] * np.sin(2.0 * np.pi * s)
    θ += (rear - slope)[:, None] * (1.0 - s) ** END_FALLOFF + (front - slope)[
        :, None
    ] * s**END_FALLOFF
    return np.diff(np.column_stack([rear, θ, front]), axis=1)
