"""`pronk golden`: a film's regression tests. No logic; imports are made when commands run."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from pipeline.commands.completion import completion
from pipeline.commands.option_suggestions import SuggestingCommand
from pipeline.commands.options import (
    Assignments,
    BackendName,
    BackendOption,
    Reporting,
    SceneNames,
    with_options,
)
from pipeline.text_stream import print_text

Scenes = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="SCENE",
        help="Files or names of shipped scenes; default: all with a golden.",
        autocompletion=completion("scenes", with_files=True),
    ),
]
Goldens = Annotated[
    Path | None, typer.Option(help="Folder of the goldens; default: 'goldens' beside the scene.")
]
ReportOut = Annotated[Path, typer.Option(help="Folder of the report and the differing pictures.")]
Layers = Annotated[
    str | None, typer.Option(metavar="LAYERS", help="For example motion,frames; default: all.")
]
Seeds = Annotated[
    int, typer.Option(min=0, max=100, help="Number of seeds to derive limits from; 0 for none.")
]


golden = typer.Typer(no_args_is_help=True, help="Regression tests of films: motion, frames, sound.")


@golden.command(cls=SuggestingCommand)
@with_options
def record(
    scenes: SceneNames,
    options: Reporting,
    goldens: Goldens = None,
    layers: Layers = None,
    seeds: Seeds = 4,
    again: Annotated[bool, typer.Option("--again", help="Replace an existing golden.")] = False,
    sets: Assignments = None,
    backend: BackendOption = BackendName.auto,
) -> None:
    """Record goldens of scenes without one."""
    from pipeline.production.goldens import golden_record
    from pipeline.production.goldens.golden_case import GoldenRenderer, cases_of, layers_of

    reporter = options.reporter()
    renderer = GoldenRenderer(backend.value)
    for case in cases_of(scenes, goldens, Path("out"), sets or []):
        reporter.result(
            golden_record.record(case, renderer, reporter, layers_of(layers), seeds, again)
        )


@golden.command(cls=SuggestingCommand)
@with_options
def check(
    options: Reporting,
    scenes: Scenes = None,
    goldens: Goldens = None,
    out: ReportOut = Path("out"),
    layers: Layers = None,
    sets: Assignments = None,
    jobs: Annotated[
        int, typer.Option(min=1, max=256, help="Number of scenes checked in parallel.")
    ] = 1,
    backend: BackendOption = BackendName.auto,
) -> None:
    """Compare scenes with their goldens and write a report.

    Ends with 0 if all hold, 1 if something changed, 5 if a golden is missing, 6 if this
    machine cannot judge.
    """
    from pipeline.production.goldens.golden_case import cases_of, layers_of
    from pipeline.production.goldens.golden_check import run_checks
    from pipeline.production.goldens.verdict import exit_code

    reporter = options.reporter()
    cases = cases_of(scenes or [], goldens, out, sets or [])
    verdicts = run_checks(cases, out, layers_of(layers), backend.value, jobs, reporter)
    if options.quiet and not options.as_json:
        for verdict in verdicts:
            if not verdict.passed:
                print_text(sys.stderr, str(verdict))
    if code := exit_code(verdicts):
        raise typer.Exit(code)


@golden.command(cls=SuggestingCommand)
@with_options
def approve(
    scenes: SceneNames,
    options: Reporting,
    goldens: Goldens = None,
    out: ReportOut = Path("out"),
    layers: Layers = None,
) -> None:
    """Accept the differences of the last check as the new golden."""
    from pipeline.production.goldens import golden_record
    from pipeline.production.goldens.golden_case import cases_of, layers_of

    reporter = options.reporter()
    for case in cases_of(scenes, goldens, out):
        reporter.result(golden_record.approve(case, layers_of(layers)))


@golden.command(name="list", cls=SuggestingCommand)
@with_options
def list_(
    options: Reporting,
    goldens: Goldens = None,
) -> None:
    """List goldens with contents and sizes."""
    from pipeline.production.goldens.golden_case import GOLDENS_FOLDER, golden_list

    text, facts = golden_list(goldens or Path(GOLDENS_FOLDER))
    options.reporter().result(text, goldens=facts)


@golden.command(cls=SuggestingCommand)
@with_options
def calibrate(
    options: Reporting,
    scenes: Scenes = None,
    goldens: Goldens = None,
    seeds: Seeds = 8,
    write: Annotated[
        bool, typer.Option("--write", help="Write the limits into the golden.")
    ] = False,
    backend: BackendOption = BackendName.auto,
) -> None:
    """Propose limits from pictures that differ only in noise."""
    from pipeline.production.goldens import golden_record
    from pipeline.production.goldens.golden_case import GoldenRenderer, cases_of

    reporter = options.reporter()
    renderer = GoldenRenderer(backend.value)
    for case in cases_of(scenes or [], goldens, Path("out")):
        reporter.result(golden_record.calibrate(case, renderer, reporter, seeds, write))
