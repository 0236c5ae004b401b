"""Commands that simulate and measure: takes, plots and reports. No logic; imports when they run."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from pipeline.commands.option_suggestions import SuggestingCommand
from pipeline.commands.options import (
    BackendName,
    BackendOption,
    BoundedRunOptions,
    RunOptions,
    SceneName,
    SceneNames,
    SceneOptions,
    StrictOption,
    with_options,
)

if TYPE_CHECKING:
    from pipeline.production.run.progress import Reporter

plots = typer.Typer(
    no_args_is_help=True, help="Draw plots over time: gait, events, minds, stories."
)
reports = typer.Typer(no_args_is_help=True, help="Print measurements of a scene.")


@with_options
def simulate(scenes: SceneNames, options: BoundedRunOptions, strict: StrictOption = False) -> None:
    """Simulate scenes and store their takes without rendering."""
    from pipeline.production.run import production
    from pipeline.production.run.budget import job_of

    def make(name: str, reporter: Reporter) -> None:
        order = options.order(name, strict=strict)
        options.budget.refuse(order.scene, job_of(order, "simulate"))
        outputs, take = production.simulate_only(order, reporter)
        reporter.result(f"{outputs.take}: digest {take.digest}")

    options.run_each(scenes, make)


@with_options
def effort(
    scene: SceneName,
    options: RunOptions,
    csv: Annotated[
        bool, typer.Option("--csv", help="Also write the torques of all joints over time.")
    ] = False,
) -> None:
    """Report power, energy, cost of transport and joint torques of walkers."""
    from pipeline.production.reports.effort_report import report_effort

    reporter = options.reporter()
    report = report_effort(options.order(scene), reporter, csv)
    reporter.result(report.text, effort=report.facts)


@with_options
def cuts(scene: SceneName, options: RunOptions) -> None:
    """Print the cuts of a film as the block `camera` of a scene, with the reason of each."""
    from pipeline.production.reports.cut_list import report_cuts

    reporter = options.reporter()
    report = report_cuts(options.order(scene), reporter)
    reporter.result(report.text, cuts=report.facts)


@with_options
def jumps(scene: SceneName, options: SceneOptions) -> None:
    """Report requested, resolved and actual values of hops."""
    from pipeline.production.reports.jump_report import report_jumps

    reporter = options.reporter()
    report = report_jumps(options.scene(scene))
    reporter.result(report.text, jumps=report.facts)


@with_options
def fit(scene: SceneName, options: SceneOptions) -> None:
    """Find gains that make the first dancer move its hands more smoothly."""
    from pipeline.production.reports.jerk_fit import fit_jerk

    reporter = options.reporter()
    fitted = fit_jerk(options.scene(scene), reporter)
    reporter.result(fitted.text, fit=fitted.facts[0])


@plots.command("events", cls=SuggestingCommand)
@with_options
def plot_events(
    scene: SceneName,
    options: RunOptions,
    pictures: Annotated[
        bool, typer.Option("--pictures/--no-pictures", help="Show frames of the film.")
    ] = True,
    backend: BackendOption = BackendName.auto,
) -> None:
    """Draw sound events: piano roll by cause, frames, waveform."""
    from pipeline.production.reports import event_plot

    reporter = options.reporter()
    order = options.order(scene, backend=backend.value)
    svg, png = event_plot.plot_events(order, reporter, pictures)
    reporter.result(f"{svg}, {png}")


@plots.command("gait", cls=SuggestingCommand)
@with_options
def plot_gait(scene: SceneName, options: RunOptions) -> None:
    """Draw planned and actual foot contacts of all walkers."""
    from pipeline.production.reports import gait_plot

    reporter = options.reporter()
    svg, png = gait_plot.plot_gait(options.order(scene), reporter)
    reporter.result(f"{svg}, {png}")


@plots.command("mind", cls=SuggestingCommand)
@with_options
def plot_mind(scene: SceneName, options: RunOptions) -> None:
    """Draw anxiety, distance, focus and behaviour of autonomous characters."""
    from pipeline.production.reports import mind_plot

    reporter = options.reporter()
    svg, png = mind_plot.plot_mind(options.order(scene), reporter)
    reporter.result(f"{svg}, {png}")


@plots.command("story", cls=SuggestingCommand)
@with_options
def plot_story(scene: SceneName, options: RunOptions) -> None:
    """Draw wanted and played tension of a story, its beats, and anxiety of people."""
    from pipeline.production.reports import story_plot

    reporter = options.reporter()
    svg, png = story_plot.plot_story(options.order(scene), reporter)
    reporter.result(f"{svg}, {png}")


@reports.callback()
def about() -> None:
    """Print measurements of a scene."""


@reports.command(cls=SuggestingCommand)
@with_options
def jerk(scene: SceneName, options: RunOptions) -> None:
    """Report how smoothly the first dancer moves its hands with both controllers."""
    from pipeline.production.reports.jerk_report import report_jerk

    reporter = options.reporter()
    report = report_jerk(options.order(scene), reporter)
    reporter.result(report.text, jerk=report.facts)
