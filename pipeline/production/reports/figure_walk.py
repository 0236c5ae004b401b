"""Figure walk: a contact sheet of one cycle of a figure's gait on level ground, from two sides.

A figure that cannot walk stands, sways and looks about for a while instead.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pipeline.atomic_file import make_folder
from pipeline.errors import FilmingError, SceneError, StoreError
from pipeline.production.reports.stills import laid_out
from pipeline.production.run.interrupts import held_back
from pipeline.production.run.progress import Reporter, stage
from pipeline.production.run.workers import with_gpu_fallback
from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.simulation.figure_analysis import Figure
from pipeline.simulation.simulate import simulate
from pipeline.simulation.take import Take
from pipeline.spec import Figure as FigureConfig
from pipeline.spec import Scene
from render.backend import Backend, Choice
from render.config import Material
from render.errors import DeviceMemoryShort, RenderError
from render.image_files import write_png
from render.renderer import Renderer

FPS = 30
"""Frames per second of the film from which the pictures are taken, so that moments are met."""

SECONDS = 5.0
"""Length of that film: almost two cycles of the largest animals."""

COUNT, COLUMNS = 8, 4
"""Pictures of a view, and pictures in a row."""

VIEWS = ("side", "three-quarter")

SIZE = (240, 180)
"""Of a picture [pixels]."""

MIN_GROUND, GROUND = 20.0, 40.0
"""Least side of the ground [m], and its side in the figure's size."""

SIZES, USUAL_SIZE = (0.2, 10.0), 2.0
"""Sizes of figures that are shown as drawn, and size at which others are shown: a cycle of theirs
takes far less or far more time than the film [m]."""


@dataclass(frozen=True, slots=True)
class WalkSheet:
    """A contact sheet.

    Attributes:
        file: the picture.
        text: what the figure does in it.
    """

    file: Path
    text: str

    @property
    def facts(self) -> dict[str, str]:
        """The same as plain values."""
        return {"file": str(self.file), "text": self.text}


def walk_sheet(
    figure: Figure, home: Scene, out: Path, backend: Choice, reporter: Reporter
) -> WalkSheet:
    """Render a figure walking on level ground onto one sheet.

    Args:
        figure: as drawn.
        home: the scene that holds it, for its materials.
        out: folder of the sheet.
        backend: variant of Mitsuba.
        reporter: of progress.

    Raises:
        PronkError: the sheet cannot be made.
    """
    scene, take, text = _simulated(figure, home, reporter)
    frames, cycle = _cycle_frames(take)
    pictures = _rendered(scene, take, frames, backend, reporter)
    file = out / f"{figure.name.replace(' ', '_')}_walk.png"
    try:
        make_folder(out)
        write_png(file, laid_out(pictures, COLUMNS), "walk")
    except RenderError as error:
        raise FilmingError(str(error)) from error
    except OSError as error:
        raise StoreError(f"{out}: cannot be written ({error.strerror})") from error
    moments = f"{len(frames)} moments of {cycle:.2g} s, from the side and from ahead"
    if (scale := _scale(figure)) != 1.0:
        moments += f", at {scale:.3g} times its size of {_size(figure):.3g} m"
    return WalkSheet(file, f"{text}; {moments}")


def _simulated(figure: Figure, home: Scene, reporter: Reporter) -> tuple[Scene, Take, str]:
    """Return the scene and take of a figure that walks, or stands if it cannot, and which."""
    with stage(reporter, "simulate", 1) as current:
        config = home.figures[figure.name]
        scene, take, reason = walk_or_stand(figure, config, home.materials, simulate)
        text = "walks" if figure.skeleton.legs else "crawls as an inchworm"
        if reason:
            text = f"stands, because it cannot walk ({reason})"
        current.result = text
    return scene, take, text


def walk_or_stand(
    figure: Figure,
    config: FigureConfig,
    materials: Mapping[str, Material],
    run: Callable[[Scene], Take],
    seconds: float = SECONDS,
) -> tuple[Scene, Take, str]:
    """Return the scene and take of a figure that walks, or stands if it cannot, and why not.

    Args:
        figure: as drawn.
        config: its drawing as it is written.
        materials: of its scene, by name.
        run: simulates a scene.
        seconds: length of the scene.
    """
    try:
        scene = walk_scene(figure, config, materials, True, seconds)
        return scene, run(scene), ""
    except SceneError as error:
        scene = walk_scene(figure, config, materials, False, seconds)
        return scene, run(scene), "; ".join(problem.message for problem in error.problems)


def _size(figure: Figure) -> float:
    """Return the size that a figure is drawn in [m]."""
    return float(np.ptp(figure.drawing.places, axis=0).max())


def _scale(figure: Figure) -> float:
    """Return the scale that a figure is shown at."""
    size = _size(figure)
    return 1.0 if SIZES[0] <= size <= SIZES[1] else USUAL_SIZE / max(size, 1e-9)


def walk_scene(
    figure: Figure,
    config: FigureConfig,
    materials: Mapping[str, Material],
    walks: bool,
    seconds: float = SECONDS,
) -> Scene:
    """Return a scene of a figure alone on level ground.

    Args:
        figure: as drawn.
        config: its drawing as it is written.
        materials: of its scene, by name.
        walks: whether it walks or stands.
        seconds: length of the scene.
    """
    scale = _scale(figure)
    size = max(MIN_GROUND, GROUND * scale * _size(figure))
    member: dict[str, object] = {"name": "it", "figure": "it", "scale": scale}
    if walks:
        member["walk"] = {}
    return Scene.model_validate(
        {
            "pronk": 1,
            "fps": FPS,
            "duration": seconds,
            "terrain": {"kind": "flat", "size": [size, size], "cells": [80, 80]},
            "figures": {"it": config},
            "materials": materials,
            "cast": [member],
            "film": {"preset": "draft", "size": SIZE},
        }
    )


def _cycle_frames(take: Take) -> tuple[list[int], float]:
    """Return the frames of one cycle from the middle of a film on, and its duration [s].

    Without a gait the whole film counts as one cycle.
    """
    names = [channel.name for channel in take.channels]
    last = take.header.frames
    span = last - 1.0
    rows = take.header.samples
    if "it.gait_phase" in names:
        phase = np.unwrap(take.values[:, names.index("it.gait_phase")], period=1.0)
        per_frame = float(phase[-1] - phase[0]) / (len(phase) - 1) * rows
        if per_frame > 0.0:
            span = min(1.0 / per_frame, span)
    first = 1 + math.floor((last - 1 - span) / 2)
    frames = [first + round(i * span / COUNT) for i in range(COUNT)]
    return frames, span / FPS


def _rendered(
    scene: Scene, take: Take, frames: list[int], backend: Choice, reporter: Reporter
) -> list[NDArray[np.uint8]]:
    """Return the pictures of both views."""
    builders = []
    for view in VIEWS:
        camera: dict[str, object] = {"camera": {"follow": "it", "view": view}}
        builders.append(ShotBuilder(_with(scene, camera), take))
    with stage(reporter, "render", len(VIEWS) * len(frames)) as current:

        def rendered(variant: Backend) -> list[NDArray[np.uint8]]:
            with held_back():
                renderer = Renderer(variant)
            pictures = []
            for builder in builders:
                for frame in frames:
                    with held_back():
                        pictures.append(renderer.render(builder.shot(frame)).srgb8)
                    current.advance(len(pictures))
            return pictures

        try:
            return with_gpu_fallback(backend, reporter, rendered)
        except DeviceMemoryShort:
            raise
        except RenderError as error:
            raise FilmingError(str(error)) from error


def _with(scene: Scene, changes: dict[str, object]) -> Scene:
    """Return a scene with some keys changed."""
    fields = {key: getattr(scene, key) for key in scene.model_fields_set}
    return Scene.model_validate(fields | changes)
