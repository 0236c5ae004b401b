"""Push-offs: the boing of a creature that jumps off the ground.

A push ends where the body rises fastest, for from there on only its weight acts. It counts if the
body then falls freely, unlike one that walks up a slope, and if the feet leave the ground with it,
unlike those of one that gets up.

Source: Sims 1987, 13.1.2.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import count
from math import inf

import numpy as np

from audio.names import matches_pattern
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.sound_detection.active_intervals import ActiveInterval
from pipeline.simulation.sound_detection.motion_sounds import detects
from pipeline.simulation.sound_detection.sound_events import interval_event
from pipeline.simulation.sound_detection.sound_sources import (
    RigidPart,
    RowBatch,
    SoundSources,
)
from pipeline.simulation.take import SoundEvent
from pipeline.spec.sound_thresholds import Boing, Detect

MIN_FLIGHT = 0.08
"""Least duration of the flight after a push [s]."""

FALL_RANGE = (0.7, 1.5)
"""Deceleration in that flight, as a share of gravity; a greater one is caused by a hold."""

MIN_FOOT_RISE = 0.5
"""Least rise of the lowest joint in that flight, as a share of that of the body."""

LIFT_WINDOW = 2.0
"""Greatest distance of the last foot's lift from the push [rows]."""

REARM_SHARE = 0.5
"""Share of the threshold below which the rise must fall before the next push."""


@detects("boing")
class PushOffDetector:
    """Detects push-offs of creatures that are not attached to anything."""

    def __init__(self, sources: SoundSources, detect: Detect) -> None:
        self._clock, config = sources.clock, detect.boing
        roots = [
            sources.root(name) for name in sources.figures if matches_pattern(name, config.who)
        ]
        free = [n for n in roots if n in sources.parts and sources.nodes[n].parent < 0]
        self._trackers = [_PushTracker(sources, sources.parts[n], config) for n in free]
        self.is_idle = not self._trackers

    def detect(self, rows: RowBatch) -> list[SoundEvent]:
        """See `MotionDetector`."""
        return [
            interval_event(push, "boing", tracker.body, self._clock)
            for tracker in self._trackers
            for push in tracker.update(rows)
        ]


@dataclass(frozen=True, slots=True)
class _BodyState:
    """A creature at a row.

    Attributes:
        row: index.
        rise: upward speed of the body [m/s].
        lowest: height of the lowest joint [m].
        place: of the body [m].
    """

    row: int
    rise: float
    lowest: float
    place: list[float]


class _PushTracker:
    """Finds the pushes of one creature: maxima of its rise.

    Attributes:
        body: its root part.
    """

    def __init__(self, sources: SoundSources, body: RigidPart, config: Boing) -> None:
        self.body, self._dt = body, sources.dt
        self._nodes = np.array(sources.nodes_by_performer[body.performer], dtype=np.int64)
        self._above, self._pause = config.above, config.pause / self._dt
        self._min_flight = max(round(MIN_FLIGHT / self._dt), 1)
        self._top: _BodyState | None = None
        self._last_push, self._is_armed = -inf, False

    def update(self, rows: RowBatch) -> Iterator[ActiveInterval]:
        """Yield the pushes that are known now, each as an interval of one row."""
        body = rows.p[:, self.body.node]
        rises = rows.at_rows((body[1:, 1] - body[:-1, 1]) / self._dt).tolist()
        lowest = rows.p[rows.new][:, self._nodes, 1].min(axis=1).tolist()
        places = body[rows.new].tolist()
        lifts = rows.lifts.get(self.body.performer, ())
        states = zip(count(rows.first_new), rises, lowest, places, strict=False)
        for state in states:
            push = self._advance(_BodyState(*state), lifts)
            if push is not None:
                start = max(_lifts_near(push.row, lifts), default=float(push.row))
                values = [[push.rise, *push.place]]
                yield ActiveInterval(0, start, int(start), int(start), push.rise, values)

    def _advance(self, now: _BodyState, lifts: Sequence[float]) -> _BodyState | None:
        """Add a row; return the state at a push that this row confirms.

        Args:
            now: state at the row.
            lifts: times at which contacts report a foot that leaves the ground [rows].
        """
        top = self._top
        # One push per flight: the rise has to come up again.
        self._is_armed = self._is_armed or now.rise < REARM_SHARE * self._above
        if not self._is_armed:
            return None
        if top is None or now.rise >= top.rise:
            self._top = now
            return None
        has_lift = bool(_lifts_near(top.row, lifts))
        if now.row - top.row < self._min_flight and not has_lift:
            return None
        self._top = now
        is_repeated = top.row - self._last_push < self._pause
        if top.rise < self._above or is_repeated or not (has_lift or self._has_flown(top, now)):
            return None
        self._last_push, self._is_armed, self._top = top.row, False, None
        return top

    def _has_flown(self, top: _BodyState, now: _BodyState) -> bool:
        """Return whether a creature falls freely from one state to another with its feet."""
        fall = (top.rise - now.rise) / (GRAVITY * self._dt * (now.row - top.row))
        feet_rise = now.lowest - top.lowest >= MIN_FOOT_RISE * (now.place[1] - top.place[1])
        return FALL_RANGE[0] <= fall <= FALL_RANGE[1] and feet_rise


def _lifts_near(row: int, lifts: Sequence[float]) -> list[float]:
    return [lift for lift in lifts if abs(lift - row) <= LIFT_WINDOW]
