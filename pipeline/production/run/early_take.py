"""Early take: the simulated start of a scene, with which one frame of it is looked at.

A film needs the whole take. One frame needs its own rows and those just after it, because a camera
that follows is smooth in both directions. Where cameras, plants and exposures look at more of the
film, its rows after the early take repeat the last one.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.production.run.compile_progress import compile_progress
from pipeline.production.run.frame_ranges import counted
from pipeline.production.run.progress import stage
from pipeline.production.run.scene_run import SceneRun
from pipeline.production.run.take_stage import kept_take, stored_take, take_key, write_stored
from pipeline.simulation.row_storage import allocate_rows, row_chunks
from pipeline.simulation.simulate import Simulation
from pipeline.simulation.take import Take
from pipeline.spec import Scene

AHEAD_S = 2.0
"""Time after a frame that is simulated with it [s]; filters of cameras hardly reach farther."""

WORTH = 0.8
"""Share of the film up to which an early take is worth while: the whole one is kept for it."""

PROGRESS_FRAMES = 8
"""Frames after which the simulation reports its progress."""


def early_frames(scene: Scene, number: int) -> int | None:
    """Return how many frames to simulate for one frame of a scene, None for all."""
    if any(camera.auto is not None for camera in scene.camera):
        return None
    frames = number + math.ceil(AHEAD_S * scene.rate)
    return None if frames > WORTH * scene.n_frames else frames


def early_take(run: SceneRun, number: int) -> Take | None:
    """Return a take for one frame of a scene, of which only its start is simulated.

    Args:
        run: on the scene.
        number: of the frame, 1-based.

    Returns:
        A take as long as the film; None where the whole take is stored or the frame needs it.

    Raises:
        SimulationError: the scene cannot be simulated.
    """
    scene, key = run.order.scene, take_key(run.order.scene)
    if kept_take(run, key):
        return None
    frames = early_frames(scene, number)
    if frames is None:
        if any(camera.auto is not None for camera in scene.camera):
            run.reporter.note("the director of `camera: auto` needs the whole take")
        return None
    place = run.outputs.early_take
    with stage(run.reporter, "simulate", frames, "s", float(1 / scene.rate)) as current:
        take = stored_take(run, key, (place,))
        if take is not None and take.header.frames >= frames:
            current.keep(frames)
            current.result = f"the take of {_share(take, scene)} is up to date"
        else:
            with compile_progress(run.reporter, current) as compiling:
                simulation = Simulation(scene, key)
                steps = simulation.world.clock.steps
                # One step more, whose row the last frame ends with.
                while simulation.step_number <= frames * steps and not simulation.finished:
                    simulation.step()
                    if simulation.step_number % (PROGRESS_FRAMES * steps) == 0:
                        compiling.close()
                        current.advance(min(simulation.step_number // steps, frames))
            take = simulation.take_so_far()
            assert take is not None  # Of at least one frame.
            write_stored(take, place)
            run.records.add(place, key)
            current.done = frames
            current.result = _share(take, scene)
            run.record_time(current)
    run.reporter.note(
        "plants, exposure and a camera that moves may differ a little in the film, which knows "
        "what comes later"
    )
    return lengthened(take, scene.n_frames)


def _share(take: Take, scene: Scene) -> str:
    return f"the first {take.header.frames} of {counted(scene.n_frames)}"


def lengthened(take: Take, frames: int) -> Take:
    """Return a take of more frames, in which the rows that are missing repeat the last one."""
    rows = frames * take.header.samples + 1
    return replace(
        take,
        header=replace(take.header, frames=frames),
        positions=_repeated(take.positions, rows),
        rotations=_repeated(take.rotations, rows),
        alive=_repeated(take.alive, rows),
        scales=_repeated(take.scales, rows),
        values=_repeated(take.values, rows),
        expressions=_repeated(take.expressions, rows),
    )


def _repeated(array: NDArray[Any], rows: int) -> NDArray[Any]:
    """Return an array (K, ...) with some rows, those that are missing like the last."""
    if not array.size:
        return np.zeros((rows, *array.shape[1:]), array.dtype)
    longer = allocate_rows((rows, *array.shape[1:]), array.dtype)
    longer[: len(array)] = array
    rest = longer[len(array) :]
    for some in row_chunks(rest):
        rest[some] = array[-1]
    return longer
