"""Builds the score from take and camera: events placed relative to the listener, and markers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from operator import attrgetter
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from audio.score import Bearing, Marker, Score, ScoreEvent
from pipeline.production.camera.cuts import first_frames
from pipeline.simulation.clock import Clock
from pipeline.simulation.sound_detection.sound_sources import rigid_parts
from pipeline.simulation.spatial import UP, Array, matrix, normalized, turn_inverse
from pipeline.simulation.take import Place, SoundEvent, Take
from pipeline.spec.scene import Scene
from render.config import Camera
from render.shot import CameraPose


class Listener:
    """Position and orientation of the listener over time.

    Between frames of one shot the listener moves in a straight line; at a cut it jumps.

    Args:
        at: "camera", or a fixed place [m].
        cuts: camera cuts in the order of time.
        clock: grid of frames and rows.
        poses: camera pose of each frame.
    """

    def __init__(
        self,
        at: Literal["camera"] | Place,
        cuts: Sequence[Camera],
        clock: Clock,
        poses: Sequence[CameraPose],
    ) -> None:
        eyes = np.array([pose.p_WC for pose in poses])
        self._clock = clock
        self._ears = eyes if at == "camera" else np.tile(np.array(at, dtype=float), (len(eyes), 1))
        self._forward = np.array([pose.p_WT for pose in poses]) - eyes
        self._up = np.array([pose.up for pose in poses])
        starts = np.array(first_frames(cuts, clock.rate))
        self._shots = np.searchsorted(starts, np.arange(1, len(poses) + 1), side="right")

    def bearing(self, frame: int, place: Place) -> Bearing:
        """Return the bearing of a place [m] at a frame."""
        row = float(self._clock.row_of_frame(frame))
        return self._bearings(np.array([row]), np.array([place], dtype=float))[0]

    def course(self, first: int, places: Sequence[Place]) -> tuple[Bearing, ...]:
        """Return the bearings of places [m], one for each row from `first` on."""
        if not places:
            return ()
        rows = np.arange(first, first + len(places), dtype=float)
        return self._bearings(rows, np.array(places, dtype=float))

    def _bearings(self, rows: Array, places: Array) -> tuple[Bearing, ...]:
        times = np.minimum(rows / self._clock.samples, len(self._ears) - 1.0)
        frames = times.astype(np.int64)
        following = np.minimum(frames + 1, len(self._ears) - 1)
        same_shot = self._shots[following] == self._shots[frames]
        fraction = np.where(same_shot, times - frames, 0.0)[:, None]
        ears = self._ears[frames] + fraction * (self._ears[following] - self._ears[frames])
        offsets = places - ears
        distances = np.linalg.norm(offsets, axis=1)
        approach = self._approach_speeds(distances, self._shots[frames])
        return tuple(
            Bearing(float(d), _azimuth(offset, self._forward[f], self._up[f]), float(v))
            for d, offset, f, v in zip(distances, offsets, frames, approach, strict=True)
        )

    def _approach_speeds(self, distances: Array, shots: NDArray[np.int64]) -> Array:
        """Return the rate at which distances shrink [m/s], without the jumps at cuts."""
        speeds = np.zeros_like(distances)
        dt = float(1 / (self._clock.rate * self._clock.samples))
        for shot in np.unique(shots):
            in_shot = shots == shot
            if np.count_nonzero(in_shot) > 1:
                speeds[in_shot] = -np.gradient(distances[in_shot], dt)
        return speeds


def _azimuth(offset: Array, forward: Array, up: Array) -> float:
    """Return the angle of `offset` from `forward` about `up` [rad], positive to the right."""
    right = normalized(np.cross(forward, up))
    if not right.any():
        right = normalized(np.cross(forward, UP))
    ahead = np.cross(up if right.any() else UP, right)
    return float(np.arctan2(offset @ right, offset @ normalized(ahead)))


# --- Strike positions: the point of impact on a part, along its longest axis ------


class StrikePositions:
    """Finds the point of impact of events on the rigid parts of a take."""

    def __init__(self, take: Take) -> None:
        self._take = take
        parts = rigid_parts(take.parts, take.meshes)
        self._parts = {take.nodes[node].name: part for node, part in parts.items()}
        self._axes: dict[str, tuple[Array, float, float]] = {}

    def position(self, event: SoundEvent) -> float | None:
        """Return the point of impact along the part that sounds, 0 to 1; None if unknown.

        A limb touches with its last link.
        """
        name = self._node_name(event)
        if name is None:
            return None
        take, part = self._take, self._parts[name]
        row = min(event.track[0], len(take.positions) - 1)
        R_WN = matrix(take.rotations[row, part.node])
        p_NC = turn_inverse(R_WN, np.array(event.place) - take.positions[row, part.node])
        axis, first, last = self._long_axis(name)
        along = float(((p_NC + take.nodes[part.node].rest) * axis).sum())
        if last <= first:
            return None
        return round(min(max((along - first) / (last - first), 0.0), 1.0), 4)

    def _node_name(self, event: SoundEvent) -> str | None:
        """Return the node of a rigid part that touches; None if there is none."""
        for name in (f"{event.who}.{event.part}", event.part, event.who):
            if name in self._parts:
                return name
            links = [n for n in self._parts if n.rpartition(".")[0] == name]
            last = max((n for n in links if n.rpartition(".")[2].isdecimal()), default=None)
            if last is not None:
                return last
        return None

    def _long_axis(self, name: str) -> tuple[Array, float, float]:
        """Return the longest axis of a part, and the range of its vertices along it [m]."""
        if name not in self._axes:
            part = self._parts[name]
            axis = part.principal_axes[:, -1]
            # Eigenvectors have no sign; fix one.
            axis = axis * np.copysign(1.0, axis[np.abs(axis).argmax()])
            along = (part.mesh.vertices.astype(float) * axis).sum(axis=1)
            self._axes[name] = axis, float(along.min()), float(along.max())
        return self._axes[name]


def build_score(
    scene: Scene, take: Take, poses: Sequence[CameraPose], subframe: bool = False
) -> tuple[Score, int]:
    """Return the score of a take, and the number of events after its last frame.

    Args:
        scene: its sound and camera configuration is used.
        take: the recorded motion and sound events.
        poses: camera pose of each frame.
        subframe: place sounds at the exact times of their causes instead of on frames.
    """
    header = take.header
    clock = Clock(header.rate, header.frames, header.steps, header.samples)
    listener = Listener(scene.sound.listener, scene.camera, clock, poses)
    strikes = StrikePositions(take)
    audible = [event for event in take.events if event.frame <= header.frames]
    score = Score(
        rate=header.rate,
        frames=header.frames,
        events=tuple(_score_event(event, clock, listener, strikes) for event in audible),
        sound=scene.sound,
        seed=header.seed,
        title=scene.title,
        markers=film_markers(scene, take),
        subframe=subframe,
    )
    return score, len(take.events) - len(audible)


def _score_event(
    event: SoundEvent, clock: Clock, listener: Listener, strikes: StrikePositions
) -> ScoreEvent:
    """Place an event at its start, or at the closest point of its path if it is sustained."""
    course = listener.course(event.track[0], event.places)
    start = listener.bearing(event.frame, event.place)
    nearest = min((start, *course), key=attrgetter("distance"))
    first, last = event.track
    return ScoreEvent(
        frame=event.frame,
        time=clock.time_of(event.step, event.fraction),
        cause=event.cause,
        who=event.who,
        # Tracks are named by performer, so the prefix is redundant.
        part=event.part.removeprefix(f"{event.who}."),
        other=event.other,
        material=event.material,
        surface=event.surface,
        strength=event.strength,
        energy=event.energy,
        size=event.size,
        distance=nearest.distance,
        azimuth=nearest.azimuth,
        duration=float((last - first) / (clock.rate * clock.samples)),
        speeds=event.strengths,
        course=course,
        spot=strikes.position(event) if first == last else None,
    )


def film_markers(scene: Scene, take: Take) -> tuple[Marker, ...]:
    """Return the cuts and script instructions of a film by frame, cuts first."""
    markers = [*_cut_markers(scene, take), *_script_markers(take)]
    return tuple(sorted(markers, key=lambda marker: marker.frame))


def _cut_markers(scene: Scene, take: Take) -> Iterator[Marker]:
    """Yield the cuts after the first frame and before the end."""
    starts = first_frames(scene.camera, take.header.rate)
    for cut, frame, following in zip(scene.camera, starts, [*starts[1:], None], strict=True):
        # Of several cuts on one frame only the last is visible.
        if 1 < frame <= take.header.frames and frame != following:
            yield Marker(frame, "cut", _cut_description(cut))


def _cut_description(cut: Camera) -> str:
    """Return view and target of a cut, such as "side of bug"."""
    target = cut.follow if isinstance(cut.follow, str) else ", ".join(cut.follow or ("all",))
    if cut.parent is not None:
        return f"from {cut.parent}"
    if cut.is_animated:
        return "moving camera"
    if cut.at is not None:
        return "standing camera" if cut.look_at is not None else f"standing camera, {target}"
    return f"{cut.view or 'three-quarter'} of {target}"


def _script_markers(take: Take) -> Iterator[Marker]:
    header = take.header
    clock = Clock(header.rate, header.frames, header.steps, header.samples)
    for told in take.told:
        frame = clock.frame_of(told.step, 0.0)
        if frame <= header.frames:
            yield Marker(frame, "script", f"{told.who}: {told.text}")
