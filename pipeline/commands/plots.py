"""`pronk plot`: what creatures do, over time. No logic; imports are made when they run."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pipeline.commands.options import (
    BackendName,
    BackendOption,
    JsonFlag,
    Out,
    QuietFlag,
    SceneName,
    Sets,
    VerboseFlag,
    order_of,
    reporter_of,
)

plots = typer.Typer(no_args_is_help=True, help="Draw what a scene's creatures do, over time.")


@plots.command("events")
def plot_events(
    scene: SceneName,
    out: Out = Path("out"),
    sets: Sets = None,
    pictures: Annotated[
        bool, typer.Option("--pictures/--no-pictures", help="Show frames of the film, or none.")
    ] = True,
    backend: BackendOption = BackendName.auto,
    json_lines: JsonFlag = False,
    quiet: QuietFlag = False,
    verbose: VerboseFlag = False,
) -> None:
    """Draw what is heard: a piano roll by causes, frames of the film, the waveform."""
    from pipeline.production.reports import event_plot

    reporter = reporter_of(json_lines, quiet, verbose)
    order = order_of(scene, sets, out, backend=backend)
    svg, png = event_plot.plot_events(order, reporter, pictures)
    reporter.result(f"{svg}, {png}")


@plots.command("gait")
def plot_gait(
    scene: SceneName,
    out: Out = Path("out"),
    sets: Sets = None,
    json_lines: JsonFlag = False,
    quiet: QuietFlag = False,
    verbose: VerboseFlag = False,
) -> None:
    """Draw when the feet of all walkers are down, as planned and as they were."""
    from pipeline.production.reports import gait_plot

    reporter = reporter_of(json_lines, quiet, verbose)
    svg, png = gait_plot.plot_gait(order_of(scene, sets, out), reporter)
    reporter.result(f"{svg}, {png}")


@plots.command("mind")
def plot_mind(
    scene: SceneName,
    out: Out = Path("out"),
    sets: Sets = None,
    json_lines: JsonFlag = False,
    quiet: QuietFlag = False,
    verbose: VerboseFlag = False,
) -> None:
    """Draw anxiety, distance, focus and behaviour of all who have a mind."""
    from pipeline.production.reports import mind_plot

    reporter = reporter_of(json_lines, quiet, verbose)
    svg, png = mind_plot.plot_mind(order_of(scene, sets, out), reporter)
    reporter.result(f"{svg}, {png}")
