"""Foothold planner: chooses the next foothold of every foot of a herd.

Most feet come down at the first candidate that their legs are long enough for, without lowering
the body. These steps are predicted together, before the feet lift, from where their bodies will be.
A prediction counts only if its request holds to the last bit, so it does not matter when it was
made. All other steps are searched one by one, see `FootholdSearch`; where both apply they agree.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.locomotion.foot_placement.foothold_search import (
    EASY_LENGTH,
    MAX_SWING_HEIGHT,
    SWING_FRACTIONS,
    Foothold,
    FootholdSearch,
)
from pipeline.simulation.locomotion.foot_placement.leg_reachability import EASY_SWING_HEIGHT
from pipeline.simulation.locomotion.foot_placement.step_batch import Stances, StepBatch, StepRequest
from pipeline.simulation.locomotion.gaits.moods import MotionStyle
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.routes.body_trajectory import BodyTrajectory
from pipeline.simulation.locomotion.routes.route import Route
from pipeline.simulation.locomotion.swing.swing_trajectory import (
    clearance_heights,
    lowest_standing_height,
    part_of_path,
    quickness,
    swing_positions,
)
from pipeline.simulation.spatial import Array, turn_inverse
from pipeline.simulation.terrain import Ground


@dataclass(frozen=True, eq=False)
class Prediction:
    """The predicted foothold of one request.

    Attributes:
        request: the step.
        foothold: None if it needs a search.
        route: of its body when it was made.
        style: of all bodies when it was made.
    """

    request: StepRequest
    foothold: Foothold | None
    route: Route
    style: MotionStyle


class FootholdPlanner:
    """Plans footholds: predicts them in batches where it can, and searches the others."""

    def __init__(self, herd: Herd, ground: Ground, trajectory: BodyTrajectory) -> None:
        self.herd, self.ground, self.trajectory = herd, ground, trajectory
        self.search = FootholdSearch(herd, ground, trajectory)
        self._predictions = dict[int, Prediction]()
        self._current = dict[int, Prediction]()
        self._searched = dict[int, Foothold | None]()

    def next_foothold(self, leg: int, request: Callable[[], StepRequest]) -> Foothold | None:
        """Return where a foot that lifts now comes down, None if it has no foothold within reach.

        Args:
            leg: its number.
            request: returns its step, if a search needs it.
        """
        predicted = self.predicted(leg)
        if predicted is not None:
            return predicted
        if leg not in self._searched:
            self._searched[leg] = self.search.find(request())
        return self._searched[leg]

    def forget(self, c: int) -> None:
        """Forget what was found for feet of creature `c`, whose body goes on otherwise."""
        for found in (self._searched, self._current):
            for leg in [leg for leg in found if self.herd.owner[leg] == c]:
                del found[leg]

    def predict(
        self,
        requests: Sequence[StepRequest],
        upcoming: Callable[[], Sequence[StepRequest]] = tuple,
    ) -> None:
        """Predict the footholds of `requests`, and forget all others.

        Args:
            requests: steps of feet that lift now, without braking or lowering.
            upcoming: returns steps that are expected soon, which are predicted together with those
                of `requests` that were not expected.
        """
        self._searched.clear()
        requests = [r for r in requests if self._keeps_pace(r)]
        new = [r for r in requests if not self._is_predicted(r)]
        if new:
            legs = {r.leg for r in requests}
            soon = [r for r in upcoming() if r.leg not in legs and self._keeps_pace(r)]
            new += [r for r in soon if not self._is_predicted(r)]
            for r, hold in zip(new, self._predict_together(new), strict=True):
                style = self.trajectory.style
                self._predictions[r.leg] = Prediction(r, hold, self._route(r.leg), style)
        self._current = {r.leg: self._predictions[r.leg] for r in requests}

    def predicted(self, leg: int) -> Foothold | None:
        """Return the foothold that was predicted for a foot that lifts now, if there is one."""
        prediction = self._current.get(leg)
        # Its creature may have been given another route since.
        if prediction is None or prediction.route is not self._route(leg):
            return None
        return prediction.foothold

    def _keeps_pace(self, request: StepRequest) -> bool:
        return int(self.herd.owner[request.leg]) not in self.trajectory.paces.changes

    def _is_predicted(self, request: StepRequest) -> bool:
        known = self._predictions.get(request.leg)
        if known is None or known.route is not self._route(request.leg):
            return False
        return known.style is self.trajectory.style and known.request.key == request.key

    def _route(self, leg: int) -> Route:
        return self.trajectory.routes[int(self.herd.owner[leg])]

    def _predict_together(self, requests: Sequence[StepRequest]) -> list[Foothold | None]:
        herd, search = self.herd, self.search
        batch = StepBatch.of(herd, requests)
        legs, stances = batch.legs, batch.stances(self.trajectory)
        xz, good = self._first_in_reach(requests, batch, stances)
        heights, normals = self.ground.surface(xz[:, 0], xz[:, 1])
        places = np.stack([xz[:, 0], heights, xz[:, 1]], axis=-1)
        tips = places + herd.foot_radius[legs, None] * normals
        rows = np.flatnonzero(good)
        goals = turn_inverse(stances.R[rows], tips[rows, None] - stances.p[rows])
        good[rows] = search.reachability.reaches(legs[rows], goals).all(axis=-1)
        lowest = lowest_standing_height(self.ground, tips[:, 0], tips[:, 2], herd.foot_radius[legs])
        tips[:, 1] = np.maximum(tips[:, 1], lowest)
        swing_height = np.zeros(len(requests))
        rows = np.flatnonzero(good & [r.present is not None for r in requests])
        if len(rows):
            start = np.array([requests[i].present for i in rows.tolist()])
            swing_height[rows], good[rows] = self._swings(batch, rows, stances, start, tips[rows])
        return [
            Foothold(places[i], normals[i], tips[i], 0.0, float(swing_height[i]))
            if good[i]
            else None
            for i in range(len(requests))
        ]

    def _first_in_reach(
        self, requests: Sequence[StepRequest], batch: StepBatch, stances: Stances
    ) -> tuple[Array, NDArray[np.bool_]]:
        """Return the first candidate (N, 2) [m] that each leg is long enough for, and if any is."""
        neutral, search = stances.neutral, self.search
        every = np.arange(len(requests))
        xz, good = neutral.copy(), self._in_reach(batch, stances, every, neutral[:, None])[:, 0]
        rows = [i for i in np.flatnonzero(~good).tolist() if requests[i].present is not None]
        if rows:
            present = [np.asarray(requests[i].present)[[0, 2]] for i in rows]
            backward = [search.retreat(neutral[i], xz) for i, xz in zip(rows, present, strict=True)]
            self._take_first(batch, stances, np.array(rows), np.array(backward), (xz, good))
        rows = np.flatnonzero(~good).tolist()
        if rows:
            around = [search.rings(requests[i].leg, neutral[i]) for i in rows]
            self._take_first(batch, stances, np.array(rows), np.array(around), (xz, good))
        return xz, good

    def _take_first(
        self,
        batch: StepBatch,
        stances: Stances,
        rows: NDArray[np.int64],
        candidates: Array,
        chosen: tuple[Array, NDArray[np.bool_]],
    ) -> None:
        """Put the first of `candidates` (n, k, 2) in reach of each row into `chosen`."""
        xz, good = chosen
        fits = self._in_reach(batch, stances, rows, candidates)
        good[rows] = fits.any(axis=1)
        xz[rows] = candidates[np.arange(len(rows)), fits.argmax(axis=1)]

    def _in_reach(
        self, batch: StepBatch, stances: Stances, rows: NDArray[np.int64], xz: Array
    ) -> NDArray[np.bool_]:
        """Return which places (n, k, 2) are allowed and within the leg length of some rows."""
        legs, owner = batch.legs[rows], np.repeat(batch.owner[rows], xz.shape[1])
        tips = self.search.tip_positions(legs, xz)
        lowering = self.search.reachability.required_lowering(
            legs, tips, stances.R[rows], stances.p[rows]
        )
        x, z = xz[..., 0].ravel(), xz[..., 1].ravel()
        allowed = self.trajectory.surface.is_allowed(owner, x, z).reshape(lowering.shape)
        return (lowering == 0.0) & allowed

    def _swings(
        self,
        batch: StepBatch,
        rows: NDArray[np.int64],
        stances: Stances,
        start: Array,
        end: Array,
    ) -> tuple[Array, NDArray[np.bool_]]:
        """Return the heights (n,) of the swings of some rows [m], and which legs can swing so.

        Args:
            batch: all steps.
            rows: (n,) of the batch.
            stances: of all steps.
            start: (n, 3) and
            end: (n, 3), tips [m].
        """
        herd, search, batch = self.herd, self.search, batch.rows(rows)
        legs, reachability = batch.legs, search.reachability
        step_height, stride = herd.step_height[legs], herd.stride[batch.owner]
        swing_height = clearance_heights(
            self.ground, start, end, herd.foot_radius[legs], step_height
        )
        good = swing_height <= MAX_SWING_HEIGHT * herd.legs.lengths[legs]
        across = end - start
        easy = (swing_height < EASY_SWING_HEIGHT * step_height) & (
            np.abs(across[:, 1]) < step_height
        )
        easy &= np.hypot(across[:, 0], across[:, 2]) <= EASY_LENGTH * stride
        easy &= reachability.can_lift_usual[legs]
        lift = turn_inverse(stances.lift_R[rows], start - stances.lift_p[rows])
        landing = turn_inverse(stances.R[rows, 0], end - stances.p[rows, 0])
        easy &= reachability.near_neutral(legs, lift) & reachability.near_neutral(legs, landing)
        asked = np.flatnonzero(good & ~easy)
        if len(asked):
            some = batch.rows(asked)
            phases = some.up[:, None] + some.swing[:, None] * SWING_FRACTIONS
            R, p = some.body_poses(self.trajectory, phases)
            n = len(SWING_FRACTIONS)
            first, last, height = (
                np.repeat(f[asked], n, axis=0) for f in (start, end, swing_height)
            )
            parts = part_of_path(SWING_FRACTIONS, some.swing[:, None]).ravel()
            path = swing_positions(first, last, height, parts)
            paths = turn_inverse(R, path.reshape(p.shape) - p)
            drawn_in = reachability.within_reach(some.legs, paths)
            quick = quickness(some.swing)[:, None, None] > 0.0
            good[asked] = reachability.follows(some.legs, np.where(quick, drawn_in, paths))
        return swing_height, good
