"""Cleared ways: ways of posed places around what stands in them."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.figure_frames import FigureFrames, Foresight, LimbParent
from pipeline.simulation.figures.kinematics import LimbBatch
from pipeline.simulation.figures.limb_goals import CLEARANCE
from pipeline.simulation.figures.pose_plan import PointRun
from pipeline.simulation.figures.skeleton import Limb
from pipeline.simulation.figures.surroundings import LimbSamples, Surroundings
from pipeline.simulation.keyframe_track import SAME_TIME, Lift, LiftedTrack, lift_share
from pipeline.simulation.spatial import Array, normalized, turn, turn_inverse

SAMPLED = (1 / 3, 2 / 3, 1.0)
"""Fractions of links whose points keep clear of obstacles."""

WAY = np.linspace(0.0, 1.0, 25)
"""Where the way of a place is searched for obstacles, in fractions of its time."""

LIFTS = np.arange(1, 25) * 0.05
"""Tried lifts of a way over obstacles, in lengths of the limb."""

MAX_LIFT_REACH = 0.97
"""Greatest distance of such a way from the base of the limb, in its length."""


def samples_of(figure: Figure, limb: Limb, points: Sequence[PointRun]) -> LimbSamples:
    """Return points along the links of a limb, but not those that its author places."""
    columns, places, radii = list[int](), list[Array](), list[float]()
    placed = [run.point.place for run in points if run.goal == "reach"]
    for number in limb.links:
        link = figure.skeleton.links[number]
        if link.joint not in limb.joints:
            continue
        for part in SAMPLED:
            place = link.ends[0] + part * (link.ends[1] - link.ends[0])
            if any(float(np.abs(place - other).max()) < 1e-9 for other in placed):
                continue
            columns.append(limb.joints.index(link.joint))
            places.append(place)
            radii.append(link.radii[0] + part * (link.radii[1] - link.radii[0]))
    return LimbSamples(np.array(columns), np.array(places), np.array(radii))


@dataclass(frozen=True, eq=False)
class WayClearer:
    """Leads the places of one limb around obstacles.

    Attributes:
        figure: the figure.
        limb: the limb.
        batch: the limb alone.
        surroundings: what it keeps clear of.
    """

    figure: Figure
    limb: Limb
    batch: LimbBatch
    surroundings: Surroundings

    def cleared(
        self, points: Sequence[PointRun], row: int, parent: LimbParent, foresight: Foresight
    ) -> list[PointRun]:
        """Return goals whose ways go around what is in them, as far as is foreseen in `row`."""
        result = list(points)
        for i, asked in enumerate(points):
            track = asked.run.track
            if asked.goal != "reach" or self.surroundings.is_empty:
                continue
            lifts = []
            for first, last in itertools.pairwise(track.times.tolist()):
                times = first + (last - first) * WAY
                moved = float(np.abs(np.ptp(track(times), axis=0)).max())
                if last - first > SAME_TIME and moved > CLEARANCE * float(self.batch.lengths[0]):
                    frames = foresight(row, times)
                    lift = self._lift(asked, frames, parent.repeated(row, len(times)))
                    if lift is not None:
                        lifts.append(Lift(first, last, lift))
            if lifts:
                around = LiftedTrack(track.times, track.values, track.eases, None, tuple(lifts))
                result[i] = replace(asked, run=replace(asked.run, track=around))
        return result

    def _lift(self, asked: PointRun, frames: FigureFrames, parent: LimbParent) -> Array | None:
        """Return by how much (3,) a way leads aside, in the frame of its places; None for none.

        The least of several: upward, to the sides, or towards the base of the limb [m].
        """
        size = float(self.batch.lengths[0])
        R_WG, p_WG = frames.frame(asked.frame)
        way = p_WG + turn(R_WG, asked.run.track(frames.times))
        base = frames.p_WB + turn(frames.R_WB, parent.p_BP)
        base = base + turn(frames.R_WB @ parent.R_BP, self.batch.places[0, 0])
        radius = float(self._radius_at(asked))
        keep = 2.0 * CLEARANCE * size

        def gaps(points: Array) -> Array:
            gap: Array = self.surroundings.gaps(frames.times, points[:, None])[0].min(axis=(1, 2))
            return gap - radius

        rise = lift_share(WAY)
        own = gaps(way)
        # Places that touch something are met as they are.
        needed = rise * keep + (1.0 - rise) * np.minimum(np.where(WAY < 0.5, own[0], own[-1]), keep)
        if (own >= needed - 1e-9).all():
            return None
        ahead = way[-1] - way[0]
        side = normalized(np.array([-ahead[2], 0.0, ahead[0]]) + 1e-12)
        back = normalized(base.mean(axis=0) - way.mean(axis=0))
        for amount in LIFTS * size:
            for aside in (np.array([0.0, 1.0, 0.0]), side, -side, back):
                there = way + amount * rise[:, None] * aside
                far = np.linalg.norm(there - base, axis=-1)
                if far.max() < MAX_LIFT_REACH * size and (gaps(there) >= needed - 1e-9).all():
                    return turn_inverse(R_WG[0], amount * aside)
        return None

    def _radius_at(self, asked: PointRun) -> float:
        links = (self.figure.skeleton.links[number] for number in self.limb.links)
        near = [link for link in links if np.abs(link.ends[1] - asked.point.place).max() < 1e-9]
        return near[0].radii[1] if near else 0.0
