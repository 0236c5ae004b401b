"""View choice: the views of all shots together, so that every cut between them is right.

The cheapest chain of candidates is found by dynamic programming: a view costs what it shows badly,
a cut costs where it jumps or crosses the line of action. A shot that cannot be taken shows more, or
is left out, and the shot before it goes on.

Source: Bellman 1957. Christie et al. 2008.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.production.camera.director.action_line import crossing, line_of
from pipeline.production.camera.director.candidate_view import CandidateView
from pipeline.production.camera.director.planned_shot import PlannedShot
from pipeline.production.camera.director.sight_loss import MAX_LOST_S
from pipeline.production.camera.director.view_finder import ViewFinder
from pipeline.simulation.spatial import Array

LOST_COST = 1e4
"""Cost of a view that loses the followed for too long, for each second [1/s]."""

BROKEN_COST = 1e3
"""Cost of a cut that breaks a rule."""

SHARE_COST = 20.0
"""Cost of the share of a shot in which the followed are lost."""

LOST_MARGIN_S = 0.05
"""Time by which a view must lose the followed for less than is allowed [s]."""

MAX_LOST_SHARE = 0.08
"""Share of a shot in which the followed may be lost: from a tenth the view would be turned."""

USUAL_TURN, TURN_RANGE = math.radians(50.0), math.radians(90.0)
"""Turn of the camera at a cut that reads best, and the change that costs `TURN_COST` [rad]."""

TURN_COST = 1.0
"""Cost of a turn that differs from it by `TURN_RANGE`."""

NEUTRAL_COST = 4.0
"""Cost of a cut that crosses a line; half of it that of a view along the line."""

Chosen = list[tuple[PlannedShot, CandidateView]]


@dataclass(frozen=True, eq=False)
class ViewChoice:
    """Chooses views by the candidates of a finder."""

    finder: ViewFinder

    def chosen(self, shots: Sequence[PlannedShot]) -> Chosen:
        """Return shots with their views; what cannot be taken is shown larger or left out."""
        left = list(shots)
        while True:
            views = self._cheapest(left)
            wrong = self._wrong(left, views)
            if wrong is None:
                return list(zip(left, views, strict=True))
            left = self._repaired(left, wrong)

    def _cheapest(self, shots: Sequence[PlannedShot]) -> list[CandidateView]:
        """Return the cheapest chain of views, the verified ones among them."""
        while True:
            options = [self.finder.candidates(shot) for shot in shots]
            options = [tuple(self.finder.known(view) for view in views) for views in options]
            views = self._chain(shots, options)
            fresh = [
                self.finder.verified(shot, view) for shot, view in zip(shots, views, strict=True)
            ]
            if all(a is b for a, b in zip(views, fresh, strict=True)):
                return views

    def _chain(
        self, shots: Sequence[PlannedShot], options: Sequence[Sequence[CandidateView]]
    ) -> list[CandidateView]:
        costs = [np.array([_own_cost(view) for view in views]) for views in options]
        total, backs = costs[0], []
        for k in range(1, len(shots)):
            steps = np.array(
                [
                    [self._cut_cost(shots[k - 1], a, shots[k], b) for a in options[k - 1]]
                    for b in options[k]
                ]
            )
            # Rounded, so that the last bits of a processor's arithmetic decide nothing.
            ways = np.round(steps + total[None], 6)
            backs.append(ways.argmin(axis=1))
            total = ways.min(axis=1) + costs[k]
        best = [int(np.round(total, 6).argmin())]
        for back in reversed(backs):
            best.append(int(back[best[-1]]))
        return [views[i] for views, i in zip(options, reversed(best), strict=True)]

    def _cut_cost(
        self, shot: PlannedShot, view: CandidateView, following: PlannedShot, later: CandidateView
    ) -> float:
        turn = (view.turn_from(later) - USUAL_TURN) / TURN_RANGE
        crossed = self._crossing(shot, view, following, later)
        broken = crossed == 1.0 or not view.differs_from(later)
        return TURN_COST * turn * turn + NEUTRAL_COST * crossed + BROKEN_COST * broken

    def _is_broken(
        self, shot: PlannedShot, view: CandidateView, following: PlannedShot, later: CandidateView
    ) -> bool:
        """Return whether a cut jumps, or crosses a line of action."""
        crossed = self._crossing(shot, view, following, later) == 1.0
        return crossed or not view.differs_from(later)

    def _crossing(
        self, shot: PlannedShot, view: CandidateView, following: PlannedShot, later: CandidateView
    ) -> float:
        """Return how far a cut crosses the lines of its shots, see `crossing`."""
        time = following.first / self.finder.rate
        lines = [line_of(self.finder.tracks, s.line, time) for s in (shot, following)]
        sides = _right(view, -1), _right(later, 0)
        return max((crossing(line, *sides) for line in lines if line is not None), default=0.0)

    def _wrong(
        self, shots: Sequence[PlannedShot], views: Sequence[CandidateView]
    ) -> tuple[int, bool] | None:
        """Return the first shot that cannot be taken, and whether its cut is at fault."""
        for k, view in enumerate(views):
            if _is_lost(view) and not (len(shots) == 1 and shots[0].size == "wide"):
                return k, False
            if k and self._is_broken(shots[k - 1], views[k - 1], shots[k], view):
                return k, True
        return None

    def _repaired(self, shots: list[PlannedShot], wrong: tuple[int, bool]) -> list[PlannedShot]:
        """Return the shots with one larger or left out."""
        k, is_cut = wrong
        shot, larger = shots[k], shots[k].larger()
        if not is_cut and larger is not None:
            return [
                *shots[:k],
                replace(larger, reason=f"{shot.reason}, wider for a clear sight"),
                *shots[k + 1 :],
            ]
        if is_cut and shot.is_event and k > 1 and not shots[k - 1].is_event:
            # The filler before an event gives way to it.
            k -= 1
        if k == 0:
            # Whatever hides the cast in the first shot may be gone in a longer one.
            return [replace(shots[0], end=shots[1].end), *shots[2:]]
        return [*shots[: k - 1], replace(shots[k - 1], end=shots[k].end), *shots[k + 1 :]]


def _own_cost(view: CandidateView) -> float:
    lost = LOST_COST * (view.lost_s + 1.0) if _is_lost(view) else 0.0
    return round(view.cost + SHARE_COST * view.lost_share + lost, 6)


def _is_lost(view: CandidateView) -> bool:
    return view.lost_s > MAX_LOST_S - LOST_MARGIN_S or view.lost_share > MAX_LOST_SHARE


def _right(view: CandidateView, frame: int) -> Array:
    """Return the direction to the right (3,) at the first frame, 0, or the last, -1."""
    _, right, _ = view.path.axes
    return np.asarray(right[frame])
