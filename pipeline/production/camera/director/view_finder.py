"""View finder: the candidate views of a planned shot, measured against the take."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from pipeline.production.camera.auto_framing import AutoFraming
from pipeline.production.camera.camera_path import CameraPath
from pipeline.production.camera.camera_subjects import camera_subjects
from pipeline.production.camera.cuts import automatic_framing
from pipeline.production.camera.director.action_line import line_of
from pipeline.production.camera.director.candidate_view import CandidateView
from pipeline.production.camera.director.key_light import LEAST_ANGLE, KeyLight, light_cost
from pipeline.production.camera.director.performer_tracks import PerformerTracks
from pipeline.production.camera.director.planned_shot import (
    SIZES,
    WIDE_ROOM,
    PlannedShot,
    f_number,
)
from pipeline.production.camera.director.sight_loss import longest_run, lost_frames
from pipeline.production.camera.handheld import shaken
from pipeline.production.camera.visibility import Visibility
from pipeline.simulation.clock import Clock
from pipeline.simulation.spatial import Array, normalized
from render.config import Camera

VIEW_STEP_DEG = 20
"""Angle between neighbouring candidates [degrees]."""

LIGHT_MARGIN = math.radians(4.0)
"""Angle by which candidates keep away from flat light: lead room turns a camera slightly [rad]."""

COARSE_S, FINE_S = 0.3, 0.1
"""Time between the frames at which candidates, and the chosen views, are looked at [s]."""

BEST_VIEW_DEG, VIEW_RANGE_DEG = 42.0, 50.0
"""Azimuth from which one performer is shown best, and the change that costs 1 [degrees]."""

BEST_LINE_ANGLE, LINE_RANGE = math.radians(75.0), math.radians(45.0)
"""Angle between sight and line at which two are apart in the picture; change that costs 1 [rad]."""

FLAT_COST = 50.0
"""Cost of flat light, where no view is without."""


@dataclass(eq=False)
class ViewFinder:
    """Finds views for planned shots.

    Attributes:
        visibility: of the take that is filmed.
        tracks: of its performers.
        actors: performers that act.
        light: key light, None without any.
        aspect: width by height of the frame.
        handheld: shake of the cameras.
    """

    visibility: Visibility
    tracks: PerformerTracks
    actors: tuple[str, ...]
    light: KeyLight | None
    aspect: float
    handheld: float = 0.0
    _known: dict[PlannedShot, tuple[CandidateView, ...]] = field(default_factory=dict)
    _fine: dict[CandidateView, CandidateView] = field(default_factory=dict)

    @property
    def rate(self) -> float:
        """Frames per second."""
        return float(self.visibility.take.header.rate)

    def candidates(self, shot: PlannedShot) -> tuple[CandidateView, ...]:
        """Return the candidate views of a shot, looked at every `COARSE_S`."""
        if shot not in self._known:
            self._known[shot] = self._found(shot)
        return self._known[shot]

    def verified(self, shot: PlannedShot, view: CandidateView) -> CandidateView:
        """Return a view looked at every `FINE_S`."""
        if view not in self._fine:
            (fine,) = self._measured(shot, [view], FINE_S)
            self._fine[view] = self._fine[fine] = fine
        return self._fine[view]

    def known(self, view: CandidateView) -> CandidateView:
        """Return a view as it was verified, if it was."""
        return self._fine.get(view, view)

    def _rows(self, shot: PlannedShot) -> NDArray[np.int64]:
        header = self.visibility.take.header
        clock = Clock(header.rate, header.frames, header.steps, header.samples)
        frames = range(shot.first + 1, shot.end + 1)
        return np.array([clock.row_of_frame(frame) for frame in frames], dtype=np.int64)

    def _times(self, rows: NDArray[np.int64]) -> Array:
        return rows / (self.rate * self.visibility.take.header.samples)

    def _found(self, shot: PlannedShot) -> tuple[CandidateView, ...]:
        rows, rule = self._rows(shot), SIZES[shot.size]
        # The time of a cut is rounded down, so that it never falls behind its frame.
        start = math.floor(1000.0 * shot.first / self.rate + 1e-6) / 1000.0
        follow = shot.follow[0] if shot.follow and len(shot.follow) == 1 else shot.follow
        base = Camera(
            start=start,
            follow=follow,
            view=0.0,
            elevation_deg=rule.elevation_deg,
            fov_deg=rule.fov_deg,
            handheld=self.handheld,
        )
        framing = automatic_framing(self.visibility, base, rows, self.aspect)
        if shot.is_opening and not framing.followed.names.issuperset(self.actors):
            # Somebody who soon leaves is established all the same.
            base = base.model_copy(update={"follow": self.actors})
            framing = automatic_framing(self.visibility, base, rows, self.aspect)
        room = self._room(shot, framing)
        line = line_of(self.tracks, shot.line, float(np.mean(self._times(rows))))
        views = [
            self._view(shot, framing, angle, room, line)
            for angle in range(-180 + VIEW_STEP_DEG, 181, VIEW_STEP_DEG)
        ]
        lit = [view for view in views if view.cost < FLAT_COST]
        return tuple(self._measured(shot, lit or views, COARSE_S))

    def _room(self, shot: PlannedShot, framing: AutoFraming) -> float:
        """Return the distance of a shot, relative to the one at which the followed fit."""
        room = SIZES[shot.size].room
        if shot.size != "wide" or not framing.followed.names:
            return room
        numbers = [self.tracks.number(name) for name in framing.followed.names]
        told = [k for k in numbers if self.tracks.jointed[k]] or numbers
        one = float(np.median(self.tracks.radii[told]))
        return max(room, min(WIDE_ROOM, WIDE_ROOM * one / max(framing.followed.radius, 1e-6)))

    def _view(
        self,
        shot: PlannedShot,
        framing: AutoFraming,
        angle: int,
        room: float,
        line: Array | None,
    ) -> CandidateView:
        """Return a view by its angle, before it is looked at."""
        # The moves turn to the left, views count to the right.
        turned = replace(framing, moves=framing.moves.turned(-math.radians(angle)))
        path, camera = turned.path(), framing.cut.model_copy(update={"view": float(angle)})
        away = np.linalg.norm(path.eye - path.target, axis=-1)
        if room != 1.0:
            distance = float(f"{room * away.max():.3g}")
            camera = camera.model_copy(update={"distance": distance})
            moves = replace(turned.moves, distance=np.full(len(away), distance))
            path = replace(turned, cut=camera, moves=moves).path()
            away = np.linalg.norm(path.eye - path.target, axis=-1)
        depth = self._depth(shot, framing)
        aperture = f_number(shot.size, float(away.mean()), depth)
        camera = camera.model_copy(update={"aperture": aperture})
        header = self.visibility.take.header
        path = shaken(path, self._times(self._rows(shot)), self.handheld, header.seed)
        towards = (path.eye - path.target).mean(axis=0)
        level = normalized(towards * [1.0, 0.0, 1.0])
        height = 2.0 * float((away * path.tangent).mean())
        light = None if self.light is None else self.light.angle(towards)
        cost = _view_cost(angle, level, line, shot)
        if light is not None:
            cost += FLAT_COST if light < LEAST_ANGLE + LIGHT_MARGIN else light_cost(light)
        return CandidateView(camera, path, level, height, light, cost, 0.0, 0.0)

    def _depth(self, shot: PlannedShot, framing: AutoFraming) -> float:
        """Return how far the followed reach behind the plane of focus [m]."""
        if shot.follow is not None and len(shot.follow) == 1:
            return 0.5 * float(self.tracks.radii[self.tracks.number(shot.follow[0])])
        return framing.followed.radius

    def _measured(
        self, shot: PlannedShot, views: Sequence[CandidateView], interval: float
    ) -> list[CandidateView]:
        """Return views with what they do not show, looked at in an interval [s]."""
        rows = self._rows(shot)
        camera = views[0].camera
        subjects = camera_subjects(self.visibility.take, camera, rows)
        framing = automatic_framing(self.visibility, camera, rows, self.aspect)
        step = max(1, round(interval * self.rate))
        sampled = np.unique([*range(0, len(rows), step), len(rows) - 1])
        paths: list[CameraPath] = [view.path for view in views]
        lost = lost_frames(
            self.visibility, paths, rows, sampled, subjects, framing.followed.points, self.aspect
        )
        return [
            replace(
                view,
                lost_s=longest_run(lost[k]) * step / self.rate,
                lost_share=float(lost[k].mean()),
            )
            for k, view in enumerate(views)
        ]


def _view_cost(angle: int, towards: Array, line: Array | None, shot: PlannedShot) -> float:
    """Return how far a view is from the best one: by the side of the followed, and by the line."""
    away = (abs(angle) - BEST_VIEW_DEG) / VIEW_RANGE_DEG
    cost = away * away
    if len(shot.line) == 2 and line is not None:
        between = math.acos(min(1.0, abs(float(towards @ line))))
        missing = max(0.0, BEST_LINE_ANGLE - between) / LINE_RANGE
        cost = 0.1 * cost + 2.0 * missing * missing
    elif shot.size == "wide":
        cost *= 0.5
    return cost
