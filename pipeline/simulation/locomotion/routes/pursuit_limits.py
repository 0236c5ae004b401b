"""Pursuit limits: when pursuing creatures plan their routes again, and when they give up."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class PursuitLimits:
    """When routes are planned again, and where they end.

    Attributes:
        interval: least time between two plans [s].
        shift: of the target from which on a route is planned again, in strides.
        share: of the distance to the target that counts as a stride where that is more.
        tolerance: distance from its goal at which a creature has arrived, in strides.
        slack: by which the gap of a follower may grow before it sets out again, in strides.
        prediction: longest time for which the target's motion is predicted [s].
        closing: speed beyond that of a chased target at which it is touched at least, as a fraction
            of the pace's speed; nobody brakes to less before it.
        overrun: distance beyond the place for that to which a route is planned, in strides.
        escape: distance of the next goal of a creature that flees, in strides.
        edge: distance from the edge of the terrain that goals keep, in footprints.
        reserve: factor on the distance at which an avoided member is far enough again.
        patience: time without getting nearer after which a creature gives up [s].
        progress: by which it has to get nearer within that time, in strides.
    """

    interval: float = 0.25
    shift: float = 0.25
    share: float = 0.5
    tolerance: float = 0.1
    slack: float = 0.3
    prediction: float = 1.0
    closing: float = 1.0
    overrun: float = 0.25
    escape: float = 4.0
    edge: float = 1.5
    reserve: float = 1.15
    patience: float = 8.0
    progress: float = 0.25


LIMITS = PursuitLimits()
