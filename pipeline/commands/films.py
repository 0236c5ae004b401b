"""Films, frames and scores. No logic; imports are made when commands run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pipeline.commands.options import (
    BackendName,
    BackendOption,
    JsonFlag,
    Out,
    Preset,
    PresetOption,
    QuietFlag,
    SamplesOption,
    SceneName,
    SceneNames,
    Sets,
    SizeOption,
    VerboseFlag,
    changes_of,
    order_of,
    reporter_of,
    say,
)

if TYPE_CHECKING:
    from pipeline.production.run.order import Order


def render(
    scenes: SceneNames,
    out: Out = Path("out"),
    preset: PresetOption = None,
    frames: Annotated[
        str | None, typer.Option(help="Frames to render, such as 1-48,60-90x5; all if left out.")
    ] = None,
    sets: Sets = None,
    jobs: Annotated[int, typer.Option(min=1, max=256, help="Processes that render at once.")] = 1,
    no_sound: Annotated[bool, typer.Option("--no-sound", help="Make no sound, no MIDI.")] = False,
    size: SizeOption = None,
    samples: SamplesOption = None,
    backend: BackendOption = BackendName.auto,
    json_lines: JsonFlag = False,
    quiet: QuietFlag = False,
    verbose: VerboseFlag = False,
) -> None:
    """Make films: simulate, write the score, render the frames, encode.

    What is there and still right is kept; a run that was stopped goes on where it was.
    """
    from pipeline.production.run import production
    from pipeline.production.run.order import refuse_clashes

    reporter = reporter_of(json_lines, quiet, verbose)
    changes = changes_of(sets, size, samples)
    orders = [
        order_of(name, changes, out, preset, backend, frames=frames, jobs=jobs, sound=not no_sound)
        for name in scenes
    ]
    refuse_clashes(orders)
    for order in orders:
        reporter.result(f"{production.render(order, reporter).folder}")


def frame(
    scene: SceneName,
    number: Annotated[int, typer.Argument(metavar="N", help="The frame, from 1.")],
    out: Out = Path("out"),
    preset: PresetOption = None,
    sets: Sets = None,
    size: SizeOption = None,
    samples: SamplesOption = None,
    backend: BackendOption = BackendName.auto,
    json_lines: JsonFlag = False,
    quiet: QuietFlag = False,
    verbose: VerboseFlag = False,
) -> None:
    """Render one frame."""
    from pipeline.production.reports.stills import still

    reporter = reporter_of(json_lines, quiet, verbose)
    order = order_of(scene, changes_of(sets, size, samples), out, preset, backend)
    reporter.result(f"{still(order, number, reporter)}")


def sheet(
    scene: SceneName,
    count: Annotated[int, typer.Option(min=1, max=400, help="How many frames.")] = 12,
    columns: Annotated[int, typer.Option(min=1, max=40, help="How many side by side.")] = 3,
    out: Out = Path("out"),
    preset: PresetOption = None,
    sets: Sets = None,
    size: SizeOption = None,
    samples: SamplesOption = None,
    backend: BackendOption = BackendName.auto,
    json_lines: JsonFlag = False,
    quiet: QuietFlag = False,
    verbose: VerboseFlag = False,
) -> None:
    """Render a contact sheet: frames spread evenly over the film."""
    from pipeline.production.reports.stills import sheet as contact_sheet

    reporter = reporter_of(json_lines, quiet, verbose)
    order = order_of(scene, changes_of(sets, size, samples), out, preset, backend)
    reporter.result(f"{contact_sheet(order, count, columns, reporter)}")


def watch(
    scene: SceneName,
    frame: Annotated[
        int | None, typer.Option(min=1, help="The frame to show; the middle one if left out.")
    ] = None,
    film: Annotated[
        bool, typer.Option("--film", help="Make the film with its sound instead of one frame.")
    ] = False,
    out: Out = Path("out"),
    preset: PresetOption = Preset.draft,
    sets: Sets = None,
    size: SizeOption = None,
    samples: SamplesOption = None,
    backend: BackendOption = BackendName.auto,
    json_lines: JsonFlag = False,
    quiet: QuietFlag = False,
    verbose: VerboseFlag = False,
) -> None:
    """Show a scene, and again whenever its file or what it names has changed."""
    from pipeline.production.reports.stills import still
    from pipeline.production.run import production, watch
    from pipeline.spec import find_scene

    reporter = reporter_of(json_lines, quiet, verbose)
    file = find_scene(scene)

    def order_now() -> Order:
        changes = changes_of(sets, size, samples)
        return order_of(str(file), changes, out / watch.FOLDER, preset, backend)

    def make(order: Order) -> Path:
        if film:
            return production.render(order, reporter).film(
                suffix=order.scene.film.resolved().suffix
            )
        last = order.scene.n_frames
        return still(order, min(frame or (last + 1) // 2, last), reporter)

    watch.watch(file, order_now, make, reporter, say)


def midi(
    scene: SceneName,
    out: Out = Path("out"),
    sets: Sets = None,
    subframe: Annotated[
        bool,
        typer.Option("--subframe", help="Notes and sounds at their exact times, not on frames."),
    ] = False,
    json_lines: JsonFlag = False,
    quiet: QuietFlag = False,
    verbose: VerboseFlag = False,
) -> None:
    """Write a scene's score as MIDI and as sound, rendering nothing."""
    from pipeline.production.run import production

    reporter = reporter_of(json_lines, quiet, verbose)
    outputs = production.score_only(order_of(scene, sets, out, subframe=subframe), reporter)
    reporter.result(f"{outputs.midi}")


def bench(
    scene: SceneName,
    preset: Annotated[
        list[Preset] | None, typer.Option(help="A preset to measure; may be said again.")
    ] = None,
    frames: Annotated[
        int, typer.Option(min=1, max=100, help="Frames to render after the first.")
    ] = 2,
    out: Out = Path("out"),
    sets: Sets = None,
    size: SizeOption = None,
    samples: SamplesOption = None,
    backend: BackendOption = BackendName.auto,
    json_lines: JsonFlag = False,
    quiet: QuietFlag = False,
    verbose: VerboseFlag = False,
) -> None:
    """Say how long a frame takes with each preset, and the whole film."""
    from dataclasses import asdict

    from pipeline.production.reports import render_speed

    reporter = reporter_of(json_lines, quiet, verbose)
    order = order_of(scene, changes_of(sets, size, samples), out, backend=backend)
    presets = [one.value for one in preset or Preset]
    speeds = render_speed.measure(order, presets, frames, reporter)
    reporter.result(render_speed.table(speeds), presets=[asdict(speed) for speed in speeds])
