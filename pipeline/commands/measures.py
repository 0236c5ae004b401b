"""Takes and what is measured of them. No logic; imports are made when commands run."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

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


def simulate(
    scene: SceneName,
    out: Out = Path("out"),
    sets: Sets = None,
    json_lines: JsonFlag = False,
    quiet: QuietFlag = False,
    verbose: VerboseFlag = False,
) -> None:
    """Simulate a scene and keep its take, rendering nothing."""
    from pipeline.production.run import production

    reporter = reporter_of(json_lines, quiet, verbose)
    outputs, take = production.simulate_only(order_of(scene, sets, out), reporter)
    reporter.result(f"{outputs.take}: digest {take.digest}")


def effort(
    scene: SceneName,
    out: Out = Path("out"),
    sets: Sets = None,
    csv: Annotated[
        bool, typer.Option("--csv", help="Write the torques of all joints over time as well.")
    ] = False,
    json_lines: JsonFlag = False,
    quiet: QuietFlag = False,
    verbose: VerboseFlag = False,
) -> None:
    """Say what walking takes: power, energy, cost of transport, torques of the joints."""
    from pipeline.production.reports.effort_report import report_effort

    reporter = reporter_of(json_lines, quiet, verbose)
    told = report_effort(order_of(scene, sets, out), reporter, csv)
    reporter.result(told.text, effort=told.facts)


def jumps(
    scene: SceneName,
    sets: Sets = None,
    json_lines: JsonFlag = False,
    quiet: QuietFlag = False,
    verbose: VerboseFlag = False,
) -> None:
    """Say how creatures hop: what was asked for, what was resolved, and what a jump takes."""
    from pipeline.production.reports.jump_report import report_jumps
    from pipeline.spec import find_scene, load_scene

    reporter = reporter_of(json_lines, quiet, verbose)
    told = report_jumps(load_scene(find_scene(scene), sets or []))
    reporter.result(told.text, jumps=told.facts)


def fit(
    scene: SceneName,
    sets: Sets = None,
    json_lines: JsonFlag = False,
    quiet: QuietFlag = False,
    verbose: VerboseFlag = False,
) -> None:
    """Find gains with which the first dancer of a scene moves its hands more smoothly."""
    from pipeline.production.reports.jerk_fit import fit_jerk
    from pipeline.spec import find_scene, load_scene

    reporter = reporter_of(json_lines, quiet, verbose)
    fitted = fit_jerk(load_scene(find_scene(scene), sets or []), reporter)
    reporter.result(fitted.text, fit=fitted.facts[0])
