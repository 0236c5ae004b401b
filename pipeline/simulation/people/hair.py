"""Hair: a cap over the skull down to the hairline, and what hangs or is tied behind."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from pipeline.simulation.people.face import Head
from pipeline.simulation.people.fields import Field, ball, cone, half_space, united, within
from pipeline.simulation.people.patches import Patch, kept, polygonised, ramp

Style = Callable[[Head], Field]


def _cap(head: Head, thick: float) -> Field:
    """Return hair on the skull, cut off along a line from the forehead to the nape."""
    s, at = head.size, head.at
    skull = ball(at(-0.060, 0.125, 0.0), s * (np.array([0.430, 0.385, 0.345]) + thick))
    line = half_space(at(0.345, 0.270, 0.0), (0.72, -0.66, 0.0))
    return within(skull, line, 0.05 * s)


def _short(head: Head) -> Field:
    s, at = head.size, head.at
    tuft = cone(at(0.21, 0.42, -0.12), at(0.21, 0.42, 0.12), 0.088 * s, 0.088 * s)
    nape = ball(at(-0.27, -0.12, 0.0), s * np.array([0.20, 0.26, 0.26]))
    return united([_cap(head, 0.034), tuft, nape], 0.07 * s)


def _bob(head: Head) -> Field:
    s, at = head.size, head.at
    sides = [
        cone(at(-0.06, 0.12, 0.30 * m), at(-0.04, -0.36, 0.315 * m), 0.11 * s, 0.10 * s)
        for m in (1, -1)
    ]
    back = cone(at(-0.26, 0.10, 0.0), at(-0.24, -0.36, 0.0), 0.22 * s, 0.20 * s, (1.0, 1.0, 1.45))
    return united([_cap(head, 0.052), *sides, back], 0.09 * s)


def _bun(head: Head) -> Field:
    s, at = head.size, head.at
    nape = ball(at(-0.27, -0.10, 0.0), s * np.array([0.19, 0.25, 0.25]))
    return united([_cap(head, 0.026), nape, ball(at(-0.50, 0.24, 0.0), 0.155 * s)], 0.05 * s)


def _long(head: Head) -> Field:
    s, at = head.size, head.at
    sides = [
        cone(at(-0.08, 0.14, 0.29 * m), at(-0.17, -0.52, 0.27 * m), 0.115 * s, 0.085 * s)
        for m in (1, -1)
    ]
    back = cone(at(-0.27, 0.12, 0.0), at(-0.36, -0.72, 0.0), 0.21 * s, 0.11 * s, (1.0, 1.0, 1.7))
    return united([_cap(head, 0.048), *sides, back], 0.10 * s)


STYLES: Mapping[str, Style] = {"short": _short, "bob": _bob, "bun": _bun, "long": _long}
"""All hair."""


@kept
def hair(head: Head, style: str) -> Patch:
    """Return the hair of a head; what hangs below the chin lies on the back."""
    s, c = head.size, head.centre
    low = (c[0] - 0.80 * s, c[1] - (0.95 if style == "long" else 0.62) * s, -0.54 * s)
    high = (c[0] + 0.50 * s, c[1] + 0.62 * s, 0.54 * s)
    net = polygonised(STYLES[style](head), low, high, 0.084 * s, symmetric=True)
    share = ramp(net.vertices[:, 1], float(c[1] - 0.85 * s), float(c[1] - 0.30 * s))
    return net.follow("chest", "head", share)
