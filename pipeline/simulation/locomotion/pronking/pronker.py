"""Pronker: the constants of one creature that hops."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import Problem, SceneError
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.mass import MassProperties
from pipeline.simulation.figures.inertia import Inertia as Masses
from pipeline.simulation.locomotion.footing.folds import folds_of
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.pronking.attitude import Inertia
from pipeline.simulation.locomotion.pronking.legs import Legs
from pipeline.simulation.locomotion.pronking.parameters import Jump, above, below, jump_of
from pipeline.simulation.locomotion.pronking.silhouette import Silhouette
from pipeline.simulation.locomotion.pronking.spin import Rows
from pipeline.simulation.spatial import Array
from pipeline.spec.creature import Pronk

LIFTS, LANDS, HOLDS = 0.955, 0.93, 0.975
"""How far a leg is stretched where it leaves the ground and where it comes down, and at most
while it is down, as parts of its length."""

LOW = 0.36
"""Of a crouch that nobody asked for, between the lowest and standing."""

CLEAR = 1.08
"""Lowest height of a body, in the depth of its belly."""

STRONG = 1.7
"""Greatest force of legs, in what an ordinary jump takes, if nobody says."""

ABLE, SHALLOW = 1.0001, 0.9999
"""Force of all legs that lifts a body, in its weight, and height of the highest crouch, in that
of standing: what is said to who asks for less or more."""

SLACK = 1.0
"""Moment that is left for bumps, in body weights times leg length, if nobody says."""

TWIST = 2.0
"""Greatest moment about the vertical, in body weights times leg length."""

DIRECTIONS = np.array(
    [(x, y, z) for x in (-1.0, -0.4, 0.0, 0.4, 1.0) for y in (-1.0, -0.4) for z in (-1.0, 0.0, 1.0)]
)
"""In which the points of a body are looked for that meet the ground first."""


@dataclass(frozen=True, eq=False)
class Pronker:
    """A creature that hops.

    Attributes:
        name: of it.
        number: its place in the scene's cast.
        words: how it was asked to hop.
        mass: of all of it, in its preferred pose, in the frame of the body.
        inertia: the same, as numbers.
        hips: (n, 3) in the frame of the body [m].
        rest: (n, 3) feet at rest likewise, whose heights do not count [m].
        lengths: (n,) of the legs [m].
        folds: (n,) least distances from hips to feet [m].
        soles: (n,) radii of the feet [m].
        leg_mass: (n,) [kg].
        belly: (k, 3) points of the body that meet the ground first [m].
        stand, crouch, low: heights of the body above the ground: standing, where landings end,
            and the lowest there is [m].
        jump: that it was asked for.
        most: force of one leg [N].
        balance, twist: greatest moments [N m].
        heading: where it looks at the begin [rad].
        start: (x, z) where it begins [m].
        wide: (2,) half extents of its feet along and across [m].
        legs: how far they come.
        silhouette: by which it passes over things.
    """

    name: str
    number: int
    words: Pronk
    mass: MassProperties
    inertia: Inertia
    hips: Array
    rest: Array
    lengths: Array
    folds: Array
    soles: Array
    leg_mass: Array
    belly: Array
    stand: float
    crouch: float
    low: float
    jump: Jump
    most: float
    balance: float
    twist: float
    heading: float
    start: Array
    wide: Array
    legs: Legs
    silhouette: Silhouette

    @property
    def leg(self) -> float:
        """Mean length of the legs [m]."""
        return float(self.lengths.mean())

    @property
    def weight(self) -> float:
        """[N]."""
        return self.mass.mass * GRAVITY

    def tallest(self, stretch: float, ahead: float, aside: float = 0.0) -> float:
        """Return the greatest height at which all feet reach level ground [m].

        Args:
            stretch: of the legs, as a part of their lengths.
            ahead: how far feet are before their places at rest [m].
            aside: how far to the right of them [m].
        """
        rest = self.rest + np.array([ahead, 0.0, aside])
        return float(_tall(stretch * self.lengths, self.hips, rest, self.soles).min())


def pronkers_of(herd: Herd, numbers: Sequence[int], words: Sequence[Pronk]) -> list[Pronker]:
    """Return the creatures of a herd as they hop.

    Raises:
        SceneError: one cannot hop as it is asked to.
    """
    folds = folds_of(herd)
    problems, found = list[Problem](), list[Pronker]()
    for c, (number, one) in enumerate(zip(numbers, words, strict=True)):
        try:
            found.append(pronker_of(herd, c, number, one, folds))
        except SceneError as error:
            problems += error.problems
    if problems:
        raise SceneError(problems)
    return found


def pronker_of(herd: Herd, c: int, number: int, words: Pronk, folds: Array) -> Pronker:
    """Return one creature of a herd as it hops.

    Args:
        herd: that it belongs to.
        c: its number there.
        number: its place in the scene's cast.
        words: how it was asked to hop.
        folds: least distances from hips to feet of all legs of the herd (L,) [m].

    Raises:
        SceneError: it cannot hop so.
    """
    where, figure = f"cast[{number}].pronk", herd.figures[c]
    own = np.flatnonzero(herd.owner == c)
    if not len(own):
        message = f"figure '{figure.name}' has no legs to hop on; take `pronk` away"
        raise SceneError([Problem(where, message)])
    masses = Masses(figure)
    mass = masses.at_rest
    hips, lengths, soles = herd.hips[own], herd.legs.lengths[own], herd.sole[own]
    rest = np.stack([herd.rest[own, 0], np.zeros(len(own)), herd.rest[own, 1]], axis=-1)
    leg = float(lengths.mean())
    jump = jump_of(where, words, float(_tall(LIFTS * lengths, hips, rest, soles).min()))
    low = _lowest(figure.belly, hips, rest, folds[own], soles)
    stand = float(herd.body_height[c])
    crouch = _crouch(where, words, low, stand)
    weight = mass.mass * GRAVITY
    # Uneven ground may leave half of the rise.
    most = _most(where, words, jump, max(0.5 * (stand - crouch), 0.06 * leg), len(own))
    aside = float(np.hypot(mass.centre[0], mass.centre[2])) / leg
    enough = SLACK + aside * (most * len(own))
    balance = enough if words.balance is None else words.balance
    return Pronker(
        name=herd.names[c],
        number=number,
        words=words,
        mass=mass,
        inertia=Inertia(_rows(mass.inertia), _rows(np.linalg.inv(mass.inertia))),
        hips=hips,
        rest=rest,
        lengths=lengths,
        folds=folds[own],
        soles=soles,
        leg_mass=np.array([masses.mass_of(limb.links) for limb in figure.skeleton.legs]),
        belly=_extremes(figure.body.vertices),
        stand=stand,
        crouch=crouch,
        low=low,
        jump=jump,
        most=most * weight,
        balance=balance * weight * leg,
        twist=TWIST * weight * leg,
        heading=float(herd.headings[c]),
        start=herd.starts[c],
        wide=np.maximum(herd.footprint[c], 0.2 * leg),
        legs=Legs(herd, own, folds[own]),
        silhouette=Silhouette(herd, own),
    )


def _most(where: str, words: Pronk, jump: Jump, rise: float, legs: int) -> float:
    """Return the greatest force of each of so many legs [body weights]."""
    # A push takes h / rise + 1 body weights.
    pushes = STRONG * (jump.height / rise + 1.0) * math.hypot(1.0, 0.5 * jump.forward / jump.up)
    most = pushes / legs if words.max_force is None else words.max_force
    if most * legs <= 1.0:
        message = (
            f"{legs} legs of {most:g} body weights give {most * legs:.3g} together, and "
            f"it takes more than 1 to leave the ground; take {above(ABLE / legs)} or more"
        )
        raise SceneError([Problem(f"{where}.max_force", message)])
    return most


def _crouch(where: str, words: Pronk, low: float, stand: float) -> float:
    if words.crouch is None:
        return low + LOW * (stand - low)
    if not low <= words.crouch < stand:
        deep, high = above(low), below(SHALLOW * stand)
        nearest = deep if words.crouch < low else high
        message = (
            f"from a crouch of {words.crouch:g} it cannot land or push: its body stands "
            f"{stand:.3g} above the ground and comes down to {low:.3g} at this scale; take "
            f"{nearest}, or another one from {deep} to {high}"
        )
        raise SceneError([Problem(f"{where}.crouch", message)])
    return words.crouch


def _tall(lengths: Array, hips: Array, rest: Array, soles: Array) -> Array:
    """Return the heights (n,) from which legs of such lengths just reach the ground [m]."""
    across = ((rest - hips)[:, [0, 2]] ** 2).sum(axis=-1)
    result: Array = np.sqrt(np.maximum(lengths**2 - across, 0.0)) - hips[:, 1] + soles
    return result


def _lowest(belly: float, hips: Array, rest: Array, folds: Array, soles: Array) -> float:
    """Return the least height of a body whose belly and knees have room [m]."""
    across = ((rest - hips)[:, [0, 2]] ** 2).sum(axis=-1)
    folded = np.sqrt(np.maximum(folds**2 - across, 0.0)) - hips[:, 1] + soles
    return max(CLEAR * belly, 1.03 * float(folded.max()))


def _extremes(vertices: Array) -> Array:
    """Return the points of a body farthest out in some directions (k, 3)."""
    found = np.unique((vertices @ DIRECTIONS.T).argmax(axis=0))
    result: Array = np.asarray(vertices[found], dtype=float)
    return result


def _rows(m: NDArray[np.floating[Any]]) -> Rows:
    (a, b, c), (d, e, f), (g, h, i) = m.tolist()
    return (a, b, c), (d, e, f), (g, h, i)
