"""Curve limits: how fast creatures go round curves.

The feet on the outside of a curve go farther than the body, and so do those of a long body far
before its middle and behind it. Where their legs cannot make such strides, a creature takes shorter
steps, as often as before, and it slows down before the curve. So it does where its feet would slip.

Source: Tan and Wilson 2011, whose horses turn as fast as the grip of their hooves lets them.
"""

from __future__ import annotations

import bisect
import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.locomotion.routes.route import Route
from pipeline.simulation.spatial import Array

LEAST_PART = 0.002
"""Least part of a stride, in the narrowest curves."""

AVERAGED = 0.5
"""Way over which the curvature is averaged, in the ways that feet stand through."""

SAMPLES = 9
"""Samples of that way."""

GRIP = 0.6
"""Coefficient of friction of feet on the ground, of soles and hooves on dry soil."""

PASSES = 3
"""Times that it is worked out how long these ways are: short strides stand through short ones."""


@dataclass(frozen=True, eq=False)
class CurveLimits:
    """The limits on one route.

    Attributes:
        s: (n,) distances along it [m].
        parts: (n,) greatest parts of a stride in a cycle.
        fractions: (n,) greatest speed fractions from which it slows down in time.
    """

    s: Array
    parts: Array
    fractions: Array

    @staticmethod
    def of(
        route: Route, feet: Array, reach: float, stance: float, braking: float, speed: float = 0.0
    ) -> CurveLimits | None:
        """Return the limits of a creature, None if it needs none.

        Args:
            route: that it goes.
            feet: (n, 2) x and z of its feet at rest, relative to the body [m].
            reach: longest stride that they can do, in strides.
            stance: way that they stand through [m].
            braking: distance from full speed to rest [m].
            speed: full speed, at which feet may slip [m/s].
        """
        if len(route.s) < 2:
            return None
        around = 0.5 * AVERAGED * stance * np.linspace(-1.0, 1.0, SAMPLES)
        parts, (x, z) = np.ones(len(route.s)), feet.T
        for _ in range(PASSES):
            places = route.s[:, None] + np.minimum(parts, 1.0)[:, None] * around
            bend = route.curvature(places.ravel()).reshape(places.shape)
            turn = bend.mean(axis=1)[:, None]
            way = np.hypot(1.0 + turn * z, turn * x).max(axis=1)
            parts = np.maximum(reach / way, LEAST_PART)
        slip = np.abs(turn[:, 0]) * speed**2 / (GRIP * GRAVITY)
        fractions = np.minimum(parts, 1.0 / np.sqrt(np.maximum(slip, 1.0)))
        if (fractions >= 1.0).all():
            return None
        for k in range(len(fractions) - 2, -1, -1):
            faster = fractions[k + 1] ** 2 + (route.s[k + 1] - route.s[k]) / max(braking, 1e-9)
            fractions[k] = min(fractions[k], np.sqrt(faster))
        return CurveLimits(route.s, parts, fractions)

    def at(self, s: float) -> tuple[float, float]:
        """Return the greatest part of a stride and speed fraction at a distance [m]."""
        along, parts, fractions = self._rows
        k = min(max(bisect.bisect_right(along, s) - 1, 0), len(along) - 2)
        t = min(max((s - along[k]) / (along[k + 1] - along[k]), 0.0), 1.0)
        part = parts[k] + t * (parts[k + 1] - parts[k])
        fraction = fractions[k] + t * (fractions[k + 1] - fractions[k])
        return (part if part < 1.0 else math.inf), (fraction if fraction < 1.0 else math.inf)

    @cached_property
    def _rows(self) -> tuple[list[float], list[float], list[float]]:
        return self.s.tolist(), self.parts.tolist(), self.fractions.tolist()

    def bind(self, first: float, last: float) -> bool:
        """Return whether a creature slows down between two distances [m]."""
        here = np.linspace(first, last, 2 * SAMPLES)
        inside = (self.s > first) & (self.s < last)
        found = np.append(np.interp(here, self.s, self.fractions), self.fractions[inside])
        return bool((found < 1.0).any())
