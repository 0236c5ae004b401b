"""Random scenes for a director, and what its cuts show.

Cropping, lines of action, light and sizes are measured by code of their own, on every frame; what
hides somebody is told by `Visibility`, as the notes on pictures tell it.
"""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from random import Random
from typing import Any

import numpy as np

from pipeline.production.camera.clearance import VisibleGround
from pipeline.production.camera.visibility import Visibility
from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.production.shots.skinning import Skin, visible_parts
from pipeline.production.surroundings.land import Land
from pipeline.simulation.simulate import simulate
from pipeline.simulation.take import Take
from pipeline.spec import Scene, read_scene
from render.config import Camera, Light
from render.lights.sun_position import sun_direction
from render.shot import CameraPose

Block = dict[str, Any]

WALKERS = ("beetle", "spider", "horse", "antelope", "ostrich", "person", "camel")
HOPPERS = ("hopper", "kangaroo", "antelope")

LIGHTS: tuple[Any, ...] = (
    "day",
    "noon",
    "golden hour",
    "studio",
    "night",
    "overcast",
    {"sun": {"hour": 8.5}},
    {"sun": {"hour": 7.0, "north_deg": 40}},
    {"studio": {"heading_deg": 70}},
)

STRIDE = 1
"""Frames between those that are looked at."""

NEUTRAL = math.sin(math.radians(12.0))
"""Sine between line and sight below which a view is along the line."""

TRAVELLING = 0.35
"""Speed of one that has a line of motion, relative to its radius [1/s]."""


def directed_scene(seed: int) -> Scene:
    """Return a scene of walkers, pairs that meet, and hoppers, with a director's camera."""
    rng = Random(seed)
    places = [(x, z) for x in (-4.5, -1.5, 1.5, 4.5) for z in (-4.5, -1.5, 1.5, 4.5)]
    rng.shuffle(places)
    cast: list[Block] = []
    script: list[Block] = []

    def add(name: str, figure: str, **more: Any) -> None:
        x, z = places.pop()
        turn = round(rng.uniform(-180, 180), 1)
        scale = round(rng.uniform(0.4, 0.7), 2)
        member = {"name": name, "figure": figure, "at": [x, z], "heading_deg": turn}
        cast.append({**member, "scale": scale, **more})

    for k in range(rng.randint(0, 2)):
        goals = [[round(rng.uniform(-5, 5), 1) for _ in range(2)] for _ in range(2)]
        add(f"walker{k}", rng.choice(WALKERS), walk={"path": goals} if rng.random() < 0.6 else {})
    if rng.random() < 0.6 or not cast:
        for name in ("one", "other"):
            add(name, rng.choice(WALKERS), walk={})
        script.append({"at": 0.2, "who": "one", "do": {"go_to": "other"}})
        script.append({"at": 0.2, "who": "other", "do": "stop"})
    if rng.random() < 0.4:
        add("hopper", rng.choice(HOPPERS), pronk={"distance": 0.8, "height": 0.4})
    for k in range(rng.randint(0, 3)):
        x, z = places.pop()
        size = [round(rng.uniform(0.3, 1.5), 1) for _ in range(3)]
        block = {"shape": "box", "size": size}
        cast.append({"name": f"block{k}", "prop": block, "at": [x, z]})
    scene = {
        "pronk": 1,
        "fps": 12,
        "duration": rng.choice([3.0, 5.0, 6.0, 7.0]),
        "seed": seed,
        "terrain": {"kind": "flat", "size": [40, 40], "surroundings": "plain"},
        "cast": cast,
        "script": script,
        "camera": {
            "auto": rng.choice(["calm", "natural", "quick"]),
            "handheld": rng.choice([0, 0.3]),
        },
        "light": rng.choice(LIGHTS),
        "film": {"preset": "draft", "size": [96, 54]},
    }
    if rng.random() < 0.4:
        scene["terrain"] = {"preset": "hills", "height": 0.5, "size": [40, 40], "cells": [80, 80]}
    return read_scene("\n".join(f"{key}: {json.dumps(value)}" for key, value in scene.items()))


@dataclass(frozen=True)
class DirectedFilm:
    """What the cuts of a film show.

    Attributes:
        shots: seconds of each.
        lost: longest time in which somebody followed is blocked, cropped or out of the frame [s].
        crossed: cuts that cross a line of action.
        lines: cuts at which there is one.
        light: least angle between camera and key light [degrees], None without one.
        jumps: cuts between views of less than 30 degrees and less than a step of size.
    """

    shots: tuple[float, ...]
    lost: float
    crossed: int
    lines: int
    light: float | None
    jumps: int


def directed(scene: Scene) -> ShotBuilder:
    """Simulate and direct a scene."""
    return ShotBuilder(scene, simulate(scene))


def directed_film(shooting: ShotBuilder) -> DirectedFilm:
    """Measure what the cuts of a film show."""
    take, scene = shooting.take, shooting.scene
    cameras = [decision.camera for decision in shooting.decisions]
    rate = float(take.header.rate)
    cuts = shooting.cuts
    poses = shooting.poses
    aspect = shooting.film.size[0] / shooting.film.size[1]
    visibility = Visibility(take, VisibleGround(Land(take.terrain)))
    lost = max(
        _longest_loss(visibility, camera, [*frames], poses, aspect) / rate
        for camera, frames in zip(cameras, cuts, strict=True)
    )
    key = _key_direction(scene.light)
    angles = [] if key is None else [_angle(key, pose) for pose in poses]
    crossed = lines = jumps = 0
    for (a, before), (b, after) in itertools.pairwise(zip(cameras, cuts, strict=True)):
        sides = _sides(take, (a, b), poses[before[-1] - 1], poses[after[0] - 1], after[0])
        lines += len(sides)
        crossed += sum(x * y < 0 for x, y in sides)
        jumps += _jumps(poses[before[-1] - 1], poses[after[0] - 1])
    shots = tuple(len(frames) / rate for frames in cuts)
    return DirectedFilm(shots, lost, crossed, lines, min(angles, default=None), jumps)


def _longest_loss(
    visibility: Visibility,
    camera: Camera,
    frames: Sequence[int],
    poses: Sequence[CameraPose],
    aspect: float,
) -> int:
    """Return for how many successive frames somebody whom a camera follows cannot be seen."""
    take = visibility.take
    named = (camera.follow,) if isinstance(camera.follow, str) else camera.follow
    skin, parts = Skin.of(take), visible_parts(take)
    longest = run = 0
    for frame in frames[::STRIDE]:
        row, pose = (frame - 1) * take.header.samples, poses[frame - 1]
        cast = visibility.at(row)
        bad = cast is not None and bool(cast.surrounding(np.array(pose.p_WC)))
        for name in named or ():
            own = [i for i, part in enumerate(parts) if part.performer == name]
            vertices = skin.posed(take, row)
            points = np.concatenate([vertices[skin.starts[i] : skin.starts[i + 1]] for i in own])
            bad |= _is_cropped(points, pose, aspect)
        groups = [{name} for name in named] if named else [{part.performer for part in parts}]
        for group in groups:
            sight = cast.sight(group, pose, aspect) if cast is not None else None
            bad |= sight is not None and (sight.is_blocked or not sight.framed)
        run = run + STRIDE if bad else 0
        longest = max(longest, run)
    return longest


def _is_cropped(points: np.ndarray, pose: CameraPose, aspect: float) -> bool:
    ahead, right, upward = _axes(pose)
    offset = points - np.array(pose.p_WC)
    depth = offset @ ahead
    high = math.tan(math.radians(pose.fov_deg) / 2) * depth
    return bool(
        (depth <= 0).any()
        or (np.abs(offset @ right) > high * aspect).any()
        or (np.abs(offset @ upward) > high).any()
    )


def _axes(pose: CameraPose) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    ahead = np.array(pose.p_WT) - np.array(pose.p_WC)
    ahead /= np.linalg.norm(ahead)
    right = np.cross(ahead, np.array(pose.up))
    right /= np.linalg.norm(right)
    return ahead, right, np.cross(right, ahead)


def _key_direction(light: Light) -> np.ndarray | None:
    if light.studio is not None:
        heading, rise = (
            math.radians(a) for a in (light.studio.heading_deg, light.studio.elevation_deg)
        )
        level = math.cos(rise)
        return np.array([level * math.cos(heading), math.sin(rise), -level * math.sin(heading)])
    if light.sun is None or light.sun.clouds.overcast >= 0.5:
        return None
    direction = np.array(sun_direction(light.sun))
    return direction if direction[1] > math.sin(math.radians(1.0)) else None


def _angle(key: np.ndarray, pose: CameraPose) -> float:
    away = np.array(pose.p_WC) - np.array(pose.p_WT)
    return math.degrees(math.acos(float(key @ away) / float(np.linalg.norm(away))))


def _jumps(before: CameraPose, after: CameraPose) -> bool:
    away = [np.array(p.p_WC) - np.array(p.p_WT) for p in (before, after)]
    level = [a * [1, 0, 1] / np.linalg.norm(a * [1, 0, 1]) for a in away]
    turn = math.degrees(math.acos(max(-1.0, min(1.0, float(level[0] @ level[1])))))
    high = [
        float(np.linalg.norm(a)) * math.tan(math.radians(p.fov_deg) / 2)
        for a, p in zip(away, (before, after), strict=True)
    ]
    return turn < 28.0 and max(high) / min(high) < 1.2


def _sides(
    take: Take, cameras: Sequence[Camera], before: CameraPose, after: CameraPose, frame: int
) -> list[tuple[int, int]]:
    """Return where lines of action run in the picture before and after a cut, 1 to the right."""
    result = []
    named = {
        (c.follow,) if isinstance(c.follow, str) else tuple(sorted(c.follow or ())) for c in cameras
    }
    for names in named:
        if len(names) == 2:
            way = _center(take, names[1], frame) - _center(take, names[0], frame)
        elif len(names) == 1:
            way = _velocity(take, names[0], frame)
            if np.linalg.norm(way) < TRAVELLING * _radius(take, names[0]):
                continue
        else:
            continue
        way = way * [1, 0, 1]
        length = float(np.linalg.norm(way))
        if length < 1e-6:
            continue
        across = [float(way @ _axes(pose)[1]) / length for pose in (before, after)]
        if min(map(abs, across)) > NEUTRAL:
            result.append((1 if across[0] > 0 else -1, 1 if across[1] > 0 else -1))
    return result


def _nodes(take: Take, name: str) -> list[int]:
    return [i for i, node in enumerate(take.nodes) if node.performer == name]


def _center(take: Take, name: str, frame: int) -> np.ndarray:
    row = max(0, min((frame - 1) * take.header.samples, len(take.positions) - 1))
    places = take.positions[row, _nodes(take, name)]
    return np.asarray(0.5 * (places.min(axis=0) + places.max(axis=0)))


def _velocity(take: Take, name: str, frame: int) -> np.ndarray:
    """Return the mean velocity over half a second around a frame."""
    half = round(0.25 * float(take.header.rate))
    first, last = max(1, frame - half), min(take.header.frames, frame + half)
    way = _center(take, name, last) - _center(take, name, first)
    return np.asarray(way * float(take.header.rate) / max(last - first, 1))


def _radius(take: Take, name: str) -> float:
    places = take.positions[0, _nodes(take, name)]
    return 0.5 * float(np.linalg.norm(np.ptp(places, axis=0)))
