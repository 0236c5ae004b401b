"""Looking: where creatures look: ahead on their way, or where their author has them look.

Who goes looks at a place a little beyond where it will be in a moment, from before a
curve or a turn on the spot begins.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import Problem, SceneError
from pipeline.simulation.curves import hinge
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.network import HEAD
from pipeline.simulation.locomotion.carriage.bearing import Bearing
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.ways.route import Route, direction
from pipeline.simulation.spatial import Array, heading, turn
from pipeline.spec.cast import Creature
from pipeline.spec.model_base import Target

LEAD = 0.8
"""How long before it is somewhere a creature looks there [s]."""

LEAST = 0.35
"""Part of its speed at which it looks ahead at least, so that it does where it brakes."""

BEYOND = 2.0
"""How far beyond its eyes' place there it looks, in half lengths of its stance."""

MOST_UP = math.radians(60.0)
"""How far heads look up or down."""

ROUNDS = 3
"""In which the eyes' own turning is taken into account."""

Look = Array | int
"""A place (3,) [m], or the number of a creature."""


@dataclass(frozen=True, eq=False)
class Rows:
    """What the carriage of a herd of C depends on, at n rows.

    Attributes:
        time: (n,) since the start [s].
        way: (n, C) way gone [m].
        phase, drive: (n, C) of the gaits.
        bearing: (n, C).
        routes: (n) lists of C, the same object as long as nobody is led elsewhere.
        looks: (n) what somebody is told to look at, by creature.
        R_WB, p_WB: (n, C, 3, 3) and (n, C, 3) of the bodies [m].
    """

    time: Array
    way: Array
    phase: Array
    drive: Array
    bearing: Bearing
    routes: Sequence[Sequence[Route]]
    looks: Sequence[Mapping[int, Look]]
    R_WB: Array
    p_WB: Array

    @cached_property
    def turned(self) -> Array:
        """(n, C) headings of the bodies [rad]."""
        result: Array = np.arctan2(-self.R_WB[..., 2, 0], self.R_WB[..., 0, 0])
        return result

    @cached_property
    def spans(self) -> Sequence[slice]:
        """The rows during which nobody is led elsewhere, one after the other."""
        count = len(self.routes)
        led = [k for k in range(1, count) if self.routes[k] is not self.routes[k - 1]]
        return [slice(a, b) for a, b in itertools.pairwise([0, *led, count])] if count else []


def look_of(herd: Herd, c: int, words: Target) -> Look:
    """Return what the creature `c` of a herd is told to look at.

    Raises:
        ValueError: it cannot; says why.
    """
    if all(limb.kind != HEAD for limb in herd.figures[c].skeleton.limbs):
        raise ValueError(f"'{herd.names[c]}' has no head to turn")
    if not isinstance(words, str):
        return np.array(words)
    if words not in herd.names:
        raise ValueError(f"'{words}' is not on the same ground on legs; give a place, [x, y, z]")
    return herd.names.index(words)


def told_to_look(
    looks: Mapping[int, Look], herd: Herd, c: int, words: Target | None
) -> Mapping[int, Look]:
    """Return what creatures look at once `c` is told to, ahead again where `words` is None.

    Raises:
        ValueError: see `look_of`.
    """
    others = {who: look for who, look in looks.items() if who != c}
    return others if words is None else {**others, c: look_of(herd, c, words)}


def looks_in(herd: Herd, cast: Sequence[tuple[int, Creature, Figure]]) -> Mapping[int, Look]:
    """Return what the creatures of a herd are told to look at, by creature.

    Args:
        herd: of the cast.
        cast: place in the scene's cast, words and figure of each.

    Raises:
        SceneError: one cannot.
    """
    looks, problems = dict[int, Look](), []
    for c, (number, member, _) in enumerate(cast):
        try:
            if member.look_at is not None:
                looks[c] = look_of(herd, c, member.look_at)
        except ValueError as error:
            problems.append(Problem(f"cast[{number}].look_at", str(error)))
    if problems:
        raise SceneError(problems)
    return looks


def looks_ahead(rows: Rows, c: int) -> bool:
    """Tell whether a creature goes straight on in all rows, and is told to look at nothing."""
    if any(c in looks for looks in rows.looks):
        return False
    return all(rows.routes[span.start][c].goes_straight for span in rows.spans)


def sight_of(
    herd: Herd, rows: Rows, c: int, head: tuple[Array, Array], most: float, eyes: Array | None
) -> tuple[Array, Array]:
    """Return where a head is to look (n,): left of its body's heading, and up [rad].

    Args:
        herd: the creatures.
        rows: what is known of them.
        c: whose head.
        head: base of its neck (3,) and the neck's end at rest (3,), relative to the body [m].
        most: how far it turns [rad].
        eyes: (n, 3) where the neck's end is, if that is known [m].
    """
    azimuth, elevation = np.zeros((2, len(rows.time)))
    told = np.array([c in looks for looks in rows.looks], dtype=bool)
    out = float(np.hypot(*head[1][[0, 2]]))
    for span in rows.spans:
        route = rows.routes[span.start][c]
        own = np.arange(span.start, span.stop)[~told[span]]
        if not route.goes_straight and len(own):
            targets = _ahead(herd, rows, c, route, own, out)
            aside = _seen(rows, c, own, targets, *head)[0]
            azimuth[own] = rows.bearing.head_turn[own, c] * aside
    if told.any():
        own = np.flatnonzero(told)
        targets = np.array([_place(rows, k, rows.looks[k][c]) for k in own.tolist()])
        if eyes is None:
            azimuth[own], up = _seen(rows, c, own, targets, *head)
        else:
            from_eyes = targets - rows.p_WB[own, c] - turn(rows.R_WB[own, c], eyes[own])
            azimuth[own], up = _angles(from_eyes, rows.turned[own, c])
        elevation[own] = within(up, MOST_UP)
    return within(azimuth, most), elevation


def within(angle: Array, most: float) -> Array:
    """Return angles as they are up to 0.7 of `most`, and then ever less, up to `most` [rad]."""
    width = max(0.15 * most, 1e-6)
    result: Array = angle - np.sign(angle) * hinge(np.abs(angle) - (most - width), width)
    return np.clip(result, -most, most)


def _ahead(
    herd: Herd, rows: Rows, c: int, route: Route, own: NDArray[np.int64], out: float
) -> Array:
    """Return places (n, 3) to which who follows its way looks, its eyes `out` before it [m]."""
    speed = herd.stride[c] / herd.cycle[c] * np.maximum(rows.drive[own, c], LEAST)
    xz, turned = route.at(rows.way[own, c] + LEAD * speed)
    xz = xz + (out + BEYOND * herd.footprint[c, 0]) * direction(turned)
    return np.stack([xz[:, 0], rows.p_WB[own, c, 1], xz[:, 1]], axis=-1)


def _place(rows: Rows, k: int, look: Look) -> Array:
    """Return the place (3,) of what is looked at in row `k` [m]."""
    return rows.p_WB[k, look] if isinstance(look, int) else look


def _seen(
    rows: Rows, c: int, own: NDArray[np.int64], targets: Array, base: Array, eye: Array
) -> tuple[Array, Array]:
    """Return azimuths and elevations (n,) of places (n, 3) from the eyes that look at them."""
    R, p, turned = rows.R_WB[own, c], rows.p_WB[own, c], rows.turned[own, c]
    azimuth = elevation = np.zeros(len(own))
    for _ in range(ROUNDS):
        out = turn(heading(azimuth), np.broadcast_to(eye - base, p.shape))
        azimuth, elevation = _angles(targets - p - turn(R, base + out), turned)
    return azimuth, elevation


def _angles(way: Array, turned: Array) -> tuple[Array, Array]:
    """Return azimuths from headings `turned` (n,), and elevations (n,), of ways (n, 3) [rad]."""
    x, y, z = way.T
    azimuth = np.remainder(np.arctan2(-z, x) - turned + np.pi, 2.0 * np.pi) - np.pi
    return azimuth, np.arctan2(y, np.hypot(x, z))
