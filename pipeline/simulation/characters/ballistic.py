"""Ballistic: motions that go to where they are sent and stop there by themselves.

A critically damped spring, of which each sub-step is exact: it never overshoots, whatever the
sub-step, and may be sent elsewhere on its way without a jerk.
"""

from __future__ import annotations

import math

from pipeline.simulation.dynamics.compiled import compiled


@compiled
def sprung(x: float, rate: float, target: float, quick: float, dt: float) -> tuple[float, float]:
    """Return where something is after `dt`, and its rate.

    Args:
        x: where it is.
        rate: of x.
        target: where it goes to.
        quick: ω; it is there after about 5/ω [rad/s].
        dt: [s].
    """
    away = x - target
    both = rate + quick * away
    decay = math.exp(-quick * dt)
    return target + (away + both * dt) * decay, (rate - quick * both * dt) * decay
