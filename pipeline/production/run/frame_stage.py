"""Frame stage: the shots of a take, and the frames that are due."""

from __future__ import annotations

from collections.abc import Sequence

from pipeline.production.run.early_take import early_take
from pipeline.production.run.exposure_stage import expose
from pipeline.production.run.frame_ranges import counted
from pipeline.production.run.interrupts import held_back
from pipeline.production.run.picture_notes import level_notes, shooting_notes
from pipeline.production.run.progress import Stage, stage
from pipeline.production.run.scene_run import SceneRun
from pipeline.production.run.take_stage import take_of
from pipeline.production.run.workers import FrameJob, film_in_processes, with_gpu_fallback
from pipeline.production.shots.frame_rendering import (
    frame_levels,
    outdated_frames,
    render_frames,
)
from pipeline.production.shots.shot_builder import ShotBuilder
from render.backend import Backend
from render.renderer import Renderer, Timings


def shooting_of(run: SceneRun) -> ShotBuilder:
    """Return the shots of the scene's take, with notes on what its cameras do not show.

    Raises:
        NotesRefused: there are notes and the order is strict.
        SimulationError: the scene cannot be simulated.
    """
    shooting = ShotBuilder(run.order.scene, take_of(run))
    run.notes += shooting_notes(run.order.scene, shooting)
    run.refuse_notes()
    enter_cuts(run, shooting)
    return shooting


def early_shooting_of(run: SceneRun, number: int) -> ShotBuilder:
    """Return the shots for one frame, from a take of which only the start may be simulated.

    Then there are no notes on the film: what it does after the start is not known.

    Raises:
        NotesRefused: there are notes and the order is strict.
        SimulationError: the scene cannot be simulated.
    """
    take = None if run.order.strict else early_take(run, number)
    return shooting_of(run) if take is None else ShotBuilder(run.order.scene, take)


def enter_cuts(run: SceneRun, shooting: ShotBuilder) -> None:
    """Enter the cuts of the film into the manifest, those of a director with their reasons."""
    run.manifest.entries["cuts"] = [decision.facts for decision in shooting.decisions]


def note_levels(run: SceneRun, shooting: ShotBuilder, frames: Sequence[int]) -> None:
    """Note which of the frames, all of them written, are black or blown out."""
    levels = frame_levels(shooting, run.outputs, frames)
    run.notes += level_notes(run.order.scene, frames, levels)


def make_frames(run: SceneRun, shooting: ShotBuilder, frames: tuple[int, ...]) -> None:
    """Render the frames that are due."""
    with stage(run.reporter, "render", len(frames), "frames") as current:
        with_gpu_fallback(
            run.order.backend,
            run.reporter,
            lambda backend: _rendered_on(backend, run, shooting, frames, current),
        )


def _rendered_on(
    backend: Backend,
    run: SceneRun,
    shooting: ShotBuilder,
    frames: tuple[int, ...],
    current: Stage,
) -> None:
    """Render the frames that are due on one backend."""
    order, outputs = run.order, run.outputs
    for line in backend.describe():
        run.reporter.note(line, detail=True)
    with held_back():
        renderer = Renderer(backend)
    expose(run, shooting, renderer)
    keys, missing = outdated_frames(shooting, outputs, run.records, frames, renderer.key_extra)
    kept = len(frames) - len(missing)
    run.manifest.entries["renderer"] = renderer.key_extra
    current.keep(kept)
    if not missing:
        current.result = "frames are up to date"
        return
    wanted = {frame: keys[frame] for frame in missing}
    jobs = min(order.jobs, len(missing))
    if jobs > 1:
        job = FrameJob(
            shooting.scene, outputs.take, outputs, backend, wanted, shooting.tracks.tones
        )
        split = film_in_processes(
            job,
            jobs,
            run.records,
            lambda done, pace: current.advance_together(kept + done, pace),
        )
    else:
        written = render_frames(renderer, shooting, outputs, wanted)
        for done, (path, record) in enumerate(written, start=1):
            run.records.put(path, record)
            current.advance(kept + done)
        split = renderer.timings
    run.record_time(current)
    current.result = _render_summary(split, current.seconds * jobs, kept)


def _render_summary(split: Timings, seconds: float, kept: int) -> str:
    inside = split.build + split.update + split.trace + split.denoise
    return (
        f"{counted(split.frames)}, {seconds / split.frames:.2f} s each, "
        f"{100 * inside / seconds:.0f}% in Mitsuba and the denoiser "
        f"(trace {split.trace:.1f} s, denoise {split.denoise:.1f} s, build {split.build:.1f} s)"
    ) + (f", {kept} kept" if kept else "")
