"""Commands that make films, frames and scores. No logic; imports are made when they run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pipeline.commands.completion import completion
from pipeline.commands.options import (
    BoundedFrameOptions,
    BoundedRunOptions,
    FrameOptions,
    FramesOption,
    NoSoundOption,
    Preset,
    PresetOption,
    SceneName,
    SceneNames,
    StrictOption,
    VerifyOptions,
    say,
    with_options,
)
from pipeline.errors import UsageError
from pipeline.production.sound.export_kind import ExportKind

if TYPE_CHECKING:
    from pipeline.production.run.order import Order
    from pipeline.production.run.progress import Reporter
    from pipeline.spec import Scene


@with_options
def render(
    scenes: SceneNames,
    options: BoundedFrameOptions,
    preset: PresetOption = None,
    frames: FramesOption = None,
    jobs: Annotated[int, typer.Option(min=1, max=256, help="Number of rendering processes.")] = 1,
    no_sound: NoSoundOption = False,
    strict: StrictOption = False,
) -> None:
    """Render films: simulate, write the score, render the frames, encode.

    A sequence joins clips of several scenes. Outputs that are still right are kept; a run that was
    stopped goes on where it was. Where one of several scenes fails, the others are rendered all the
    same.
    """
    from pipeline.production.run import production
    from pipeline.production.run.budget import job_of
    from pipeline.production.run.frame_ranges import read_frames
    from pipeline.production.run.order import Order
    from pipeline.spec import find_scene, is_sequence

    if frames is not None:
        read_frames(frames)

    settings: dict[str, Any] = {"jobs": jobs, "sound": not no_sound, "strict": strict}
    settings["backend"] = options.backend.value

    def join(name: str, reporter: Reporter) -> None:
        from pipeline.production.sequence.sequence_run import render_sequence

        if frames is not None:
            raise UsageError("--frames: a sequence is rendered whole; its clips have start and end")
        sequence = options.sequence(name, preset)

        def order_of(scene: Scene, clip: str, out: Path, stretch: str) -> Order:
            order = Order(scene, clip, out, stretch, **settings)
            options.budget.refuse(scene, job_of(order, "render"))
            return order

        reporter.result(f"{render_sequence(sequence, options.out, order_of, reporter).folder}")

    def make(name: str, reporter: Reporter) -> None:
        if is_sequence(find_scene(name), options.is_untrusted):
            join(name, reporter)
            return
        order = options.order(name, preset, frames=frames, **settings)
        options.budget.refuse(order.scene, job_of(order, "render"))
        reporter.result(f"{production.render(order, reporter).folder}")

    options.run_each(scenes, make)


@with_options
def frame(
    scene: SceneName,
    number: Annotated[int, typer.Argument(metavar="N", help="The frame, from 1.")],
    options: FrameOptions,
    preset: PresetOption = None,
    early: Annotated[
        bool,
        typer.Option(
            "--early",
            help="Simulate the film only up to the frame, for a quick look: plants, exposure and "
            "a camera that moves may differ a little from the film.",
        ),
    ] = False,
) -> None:
    """Render one frame, as it is in the film."""
    from pipeline.production.reports.stills import still

    reporter = options.reporter()
    order = options.frame_order(scene, preset)
    reporter.result(f"{still(order, number, reporter, early=early)}")


@with_options
def sheet(
    scenes: SceneNames,
    options: FrameOptions,
    count: Annotated[int, typer.Option(min=1, max=400, help="Number of frames.")] = 12,
    columns: Annotated[int, typer.Option(min=1, max=40, help="Frames per row.")] = 3,
    preset: PresetOption = None,
) -> None:
    """Render contact sheets: frames spread evenly over the film."""
    from pipeline.production.reports.stills import sheet as contact_sheet

    def make(name: str, reporter: Reporter) -> None:
        order = options.frame_order(name, preset)
        reporter.result(f"{contact_sheet(order, count, columns, reporter)}")

    options.run_each(scenes, make)


@with_options
def watch(
    scene: SceneName,
    options: FrameOptions,
    frame: Annotated[
        int | None, typer.Option(min=1, help="The frame to show; default: the middle one.")
    ] = None,
    film: Annotated[
        bool, typer.Option("--film", help="Render the whole film instead of one frame.")
    ] = False,
    preset: PresetOption = Preset.draft,
) -> None:
    """Render a frame again whenever the scene or a file it uses changes."""
    from pipeline.production.reports.stills import still
    from pipeline.production.run import production
    from pipeline.production.run import watch as watching
    from pipeline.spec import find_scene

    reporter = options.reporter()
    file = find_scene(scene)

    def order_now() -> Order:
        return options.frame_order(str(file), preset, out=options.out / watching.FOLDER)

    def make(order: Order) -> Path:
        if film:
            outputs = production.render(order, reporter)
            return outputs.film(suffix=order.scene.film.resolved().suffix)
        last = order.scene.n_frames
        return still(order, min(frame or (last + 1) // 2, last), reporter, early=True)

    watching.watch(file, order_now, make, reporter, say)


@with_options
def midi(
    scenes: SceneNames,
    options: BoundedRunOptions,
    subframe: Annotated[
        bool,
        typer.Option(
            "--subframe", help="Put notes and sounds at their exact times instead of on frames."
        ),
    ] = False,
    strict: StrictOption = False,
    export: Annotated[
        list[ExportKind] | None,
        typer.Option(help="Also write the score for other programs; may be given several times."),
    ] = None,
) -> None:
    """Write MIDI scores and sound tracks without rendering."""
    from pipeline.production.run import production
    from pipeline.production.run.budget import job_of

    def make(name: str, reporter: Reporter) -> None:
        order = options.order(name, subframe=subframe, strict=strict)
        options.budget.refuse(order.scene, job_of(order, "score"))
        reporter.result(f"{production.score_only(order, reporter, export or ()).midi}")

    options.run_each(scenes, make)


@with_options
def verify(
    targets: Annotated[
        list[str],
        typer.Argument(
            metavar="OUTPUT",
            help="Output folders of scenes, or files or names of scenes.",
            autocompletion=completion("scenes", with_files=True),
        ),
    ],
    options: VerifyOptions,
) -> None:
    """Check outputs: every file is as it was written, every film shows its frames.

    Ends with 1 if files are missing or damaged; rendering the scene makes them again.
    """
    from dataclasses import asdict

    from pipeline.production.verification.verification import outputs_of
    from pipeline.production.verification.verification import verify as verified

    def check(target: str, reporter: Reporter) -> None:
        outputs = outputs_of(target, options.out)
        verdict = verified(outputs, reporter)
        reporter.result(f"{outputs.folder}: {verdict}", **asdict(verdict))

    options.run_each(targets, check, "right")


@with_options
def bench(
    scene: SceneName,
    options: FrameOptions,
    preset: Annotated[
        list[Preset] | None, typer.Option(help="Preset to measure; may be repeated.")
    ] = None,
    frames: Annotated[
        int, typer.Option(min=1, max=100, help="Frames to render after the first.")
    ] = 2,
) -> None:
    """Measure the time of a frame with each preset; estimate the film."""
    from dataclasses import asdict

    from pipeline.production.reports import render_speed

    reporter = options.reporter()
    presets = [choice.value for choice in preset or Preset]
    speeds = render_speed.measure(options.frame_order(scene), presets, frames, reporter)
    reporter.result(render_speed.table(speeds), presets=[asdict(speed) for speed in speeds])
