"""`pronk report`: what is measured of a scene. No logic; imports are made when commands run."""

from __future__ import annotations

from pathlib import Path

import typer

from pipeline.commands.options import (
    JsonFlag,
    Out,
    QuietFlag,
    SceneName,
    Sets,
    VerboseFlag,
    order_of,
    reporter_of,
)

reports = typer.Typer(no_args_is_help=True, help="Say what is measured of a scene.")


@reports.callback()
def about() -> None:
    """Say what is measured of a scene."""


@reports.command()
def jerk(
    scene: SceneName,
    out: Out = Path("out"),
    sets: Sets = None,
    json_lines: JsonFlag = False,
    quiet: QuietFlag = False,
    verbose: VerboseFlag = False,
) -> None:
    """Say how smoothly the first dancer moves its hands, by both controllers."""
    from pipeline.production.reports.jerk_report import report_jerk

    reporter = reporter_of(json_lines, quiet, verbose)
    told = report_jerk(order_of(scene, sets, out), reporter)
    reporter.result(told.text, jerk=told.facts)
