"""Scoring: take and camera -> the score, its events placed as the listener hears them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from audio.score import Score, ScoreEvent
from pipeline.production.markers import markers_of
from pipeline.production.speeds import speeds_of
from pipeline.simulation.clock import Clock
from pipeline.simulation.spatial import UP, Array, normalized
from pipeline.simulation.take import SoundEvent, Take
from pipeline.spec.scene import Scene
from render.shot import CameraPose


def score_of(
    scene: Scene, take: Take, poses: Sequence[CameraPose], subframe: bool = False
) -> tuple[Score, int]:
    """Return the score of `take`, and how many events fell after its last frame.

    Args:
        scene: for its words on sound.
        take: what happened.
        poses: of the camera, by frame.
        subframe: whether sounds stand at the exact times of their causes.
    """
    header = take.header
    clock = Clock(header.rate, header.frames, header.steps, header.samples)
    heard = [event for event in take.events if event.frame <= header.frames]
    nodes = {node.name: number for number, node in enumerate(take.nodes)}
    events = tuple(
        replace(
            _placed(scene, event, clock, poses[event.frame - 1]),
            speeds=speeds_of(take, event, nodes),
        )
        for event in heard
    )
    score = Score(
        rate=header.rate,
        frames=header.frames,
        events=events,
        sound=scene.sound,
        seed=header.seed,
        title=scene.title,
        markers=markers_of(scene, take),
        subframe=subframe,
    )
    return score, len(take.events) - len(heard)


def _placed(scene: Scene, event: SoundEvent, clock: Clock, pose: CameraPose) -> ScoreEvent:
    eye, target = np.array(pose.p_WC), np.array(pose.p_WT)
    listener = scene.sound.listener
    ear = eye if listener == "camera" else np.array(listener, dtype=float)
    offset = np.array(event.place) - ear
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
        distance=float(np.linalg.norm(offset)),
        azimuth=_azimuth(offset, target - eye, np.array(pose.up)),
        duration=float((last - first) / (clock.rate * clock.samples)),
    )


def _azimuth(offset: Array, forward: Array, up: Array) -> float:
    """Return the direction of `offset` for one who looks `forward`, positive to the right."""
    right = normalized(np.cross(forward, up))
    if not right.any():
        right = normalized(np.cross(forward, UP))
    ahead = np.cross(up if right.any() else UP, right)
    return math.atan2(float(offset @ right), float(offset @ normalized(ahead)))
