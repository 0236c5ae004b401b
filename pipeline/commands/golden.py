"""`pronk golden`: a film's regression tests. No logic; imports are made when commands run."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pipeline.commands.options import (
    BackendName,
    BackendOption,
    JsonFlag,
    QuietFlag,
    SceneNames,
    Sets,
    VerboseFlag,
    reporter_of,
)

Scenes = Annotated[
    list[str] | None,
    typer.Argument(metavar="SCENE", help="Files, or names of shipped scenes; all with a golden."),
]
Goldens = Annotated[
    Path | None, typer.Option(help="Folder of the goldens; 'goldens' beside the scene if left out.")
]
ReportOut = Annotated[Path, typer.Option(help="Folder for the report and for what differs.")]
Layers = Annotated[
    str | None, typer.Option(metavar="LAYERS", help="Such as motion,frames; all if left out.")
]
Seeds = Annotated[
    int, typer.Option(min=0, max=100, help="Seeds to propose limits from; 0 for none.")
]


golden = typer.Typer(no_args_is_help=True, help="Keep a film as it is: its regression tests.")


@golden.command()
def record(
    scenes: SceneNames,
    goldens: Goldens = None,
    layers: Layers = None,
    seeds: Seeds = 4,
    again: Annotated[bool, typer.Option("--again", help="Although there is one.")] = False,
    sets: Sets = None,
    backend: BackendOption = BackendName.auto,
    json_lines: JsonFlag = False,
    quiet: QuietFlag = False,
    verbose: VerboseFlag = False,
) -> None:
    """Write the goldens of scenes that have none."""
    from pipeline.production.goldens import golden_record
    from pipeline.production.goldens.golden_case import GoldenRenderer, cases_of, layers_of

    reporter = reporter_of(json_lines, quiet, verbose)
    renderer = GoldenRenderer(backend.value)
    for case in cases_of(scenes, goldens, Path("out"), sets or []):
        told = golden_record.record(case, renderer, reporter, layers_of(layers), seeds, again)
        reporter.result(told)


@golden.command()
def check(
    scenes: Scenes = None,
    goldens: Goldens = None,
    out: ReportOut = Path("out"),
    layers: Layers = None,
    sets: Sets = None,
    jobs: Annotated[int, typer.Option(min=1, max=256, help="Scenes checked at once.")] = 1,
    backend: BackendOption = BackendName.auto,
    json_lines: JsonFlag = False,
    quiet: QuietFlag = False,
    verbose: VerboseFlag = False,
) -> None:
    """Compare scenes with their goldens; write a report, and never a golden.

    Ends with 0 if all hold, 1 if something changed, 5 if a golden is missing, 6 if this
    machine cannot judge.
    """
    from pipeline.production.goldens.golden_case import cases_of, layers_of
    from pipeline.production.goldens.golden_check import run_checks

    reporter = reporter_of(json_lines, quiet, verbose)
    cases = cases_of(scenes or [], goldens, out, sets or [])
    code = run_checks(cases, out, layers_of(layers), backend.value, jobs, reporter)
    if code:
        raise typer.Exit(code)


@golden.command()
def approve(
    scenes: SceneNames,
    goldens: Goldens = None,
    out: ReportOut = Path("out"),
    layers: Layers = None,
    json_lines: JsonFlag = False,
    quiet: QuietFlag = False,
    verbose: VerboseFlag = False,
) -> None:
    """Make what the last check found to differ the golden, as it was looked at."""
    from pipeline.production.goldens import golden_record
    from pipeline.production.goldens.golden_case import cases_of, layers_of

    reporter = reporter_of(json_lines, quiet, verbose)
    for case in cases_of(scenes, goldens, out):
        reporter.result(golden_record.approve(case, layers_of(layers)))


@golden.command(name="list")
def list_(
    goldens: Goldens = None,
    json_lines: JsonFlag = False,
    quiet: QuietFlag = False,
    verbose: VerboseFlag = False,
) -> None:
    """Say which goldens there are, what they hold and what they weigh."""
    from pipeline.production.goldens.golden_case import GOLDENS_FOLDER, golden_list

    text, facts = golden_list(goldens or Path(GOLDENS_FOLDER))
    reporter_of(json_lines, quiet, verbose).result(text, goldens=facts)


@golden.command()
def calibrate(
    scenes: Scenes = None,
    goldens: Goldens = None,
    seeds: Seeds = 8,
    write: Annotated[bool, typer.Option("--write", help="Write them into the golden.")] = False,
    backend: BackendOption = BackendName.auto,
    json_lines: JsonFlag = False,
    quiet: QuietFlag = False,
    verbose: VerboseFlag = False,
) -> None:
    """Propose limits from pictures that differ in noise alone."""
    from pipeline.production.goldens import golden_record
    from pipeline.production.goldens.golden_case import GoldenRenderer, cases_of

    reporter = reporter_of(json_lines, quiet, verbose)
    renderer = GoldenRenderer(backend.value)
    for case in cases_of(scenes or [], goldens, Path("out")):
        reporter.result(golden_record.calibrate(case, renderer, reporter, seeds, write))
