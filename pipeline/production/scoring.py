"""Scoring: take and camera -> the score, its events placed as the listener hears them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from audio.score import Score, ScoreEvent
from pipeline.simulation.clock import Clock
from pipeline.simulation.spatial import UP, Array, normalized
from pipeline.simulation.take import Place, SoundEvent, Take
from pipeline.spec.scene import Scene
from render.shot import CameraPose


def score_of(scene: Scene, take: Take, poses: Sequence[CameraPose]) -> tuple[Score, int]:
    """Return the score of `take`, and how many events fell after its last frame.

    Args:
        scene: for its words on sound.
        take: what happened.
        poses: of the camera, by frame.
    """
    header = take.header
    clock = Clock(header.rate, header.frames, header.steps, header.samples)
    heard = [event for event in take.events if event.frame <= header.frames]
    events = tuple(_placed(scene, event, clock, poses) for event in heard)
    score = Score(header.rate, header.frames, events, scene.sound, header.seed, scene.title)
    return score, len(take.events) - len(heard)


def _placed(
    scene: Scene, event: SoundEvent, clock: Clock, poses: Sequence[CameraPose]
) -> ScoreEvent:
    """Return an event as it is heard: where it begins, or where what lasts comes nearest."""
    heard = [_heard(scene, event.place, poses[event.frame - 1])]
    for row, place in enumerate(event.places, event.track[0]):
        frame = min(row // clock.samples, len(poses) - 1)
        heard.append(_heard(scene, place, poses[frame]))
    distance, azimuth = min(heard)
    first, last = event.track
    return ScoreEvent(
        frame=event.frame,
        time=clock.time_of(event.step, event.fraction),
        cause=event.cause,
        who=event.who,
        # Within a performer its own name says nothing.
        part=event.part.removeprefix(f"{event.who}."),
        other=event.other,
        material=event.material,
        surface=event.surface,
        strength=event.strength,
        energy=event.energy,
        size=event.size,
        distance=distance,
        azimuth=azimuth,
        duration=float((last - first) / (clock.rate * clock.samples)),
    )


def _heard(scene: Scene, place: Place, pose: CameraPose) -> tuple[float, float]:
    """Return the distance [m] and the azimuth [rad] of a place."""
    eye, target = np.array(pose.p_WC), np.array(pose.p_WT)
    listener = scene.sound.listener
    ear = eye if listener == "camera" else np.array(listener, dtype=float)
    offset = np.array(place) - ear
    azimuth = _azimuth(offset, target - eye, np.array(pose.up))
    return float(np.linalg.norm(offset)), azimuth


def _azimuth(offset: Array, forward: Array, up: Array) -> float:
    """Return the direction of `offset` for one who looks `forward`, positive to the right."""
    right = normalized(np.cross(forward, up))
    if not right.any():
        right = normalized(np.cross(forward, UP))
    ahead = np.cross(up if right.any() else UP, right)
    return math.atan2(float(offset @ right), float(offset @ normalized(ahead)))
