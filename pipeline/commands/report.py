"""`pronk report`: what is measured of a scene. No logic; imports are made when commands run."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from pipeline.production.order import Order
    from pipeline.production.reporting import Reporter

Flags = Callable[[bool, bool, bool], "Reporter"]
"""Sets the flags that every command has, and returns the reporter that suits them."""

Orders = Callable[[str, list[str] | None, Path], "Order"]
"""Returns what is asked of a run on a scene, by its name, changes and folder."""

SceneName = Annotated[
    str, typer.Argument(metavar="SCENE", help="A file, or the name of a shipped scene.")
]
Out = Annotated[Path, typer.Option(help="Folder that the scenes' folders are made in.")]
Sets = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="PATH=VALUE", help="Change a word of the scene: fps=30."),
]
Json = Annotated[bool, typer.Option("--json", help="Say everything as lines of JSON.")]
Quiet = Annotated[bool, typer.Option("-q", "--quiet", help="Say nothing but errors.")]
Verbose = Annotated[bool, typer.Option("-v", "--verbose", help="Say more.")]


def report_commands(flags: Flags, order_of: Orders) -> typer.Typer:
    """Return the group of commands, which say things where `flags` want it."""
    group = typer.Typer(no_args_is_help=True, help="Say what is measured of a scene.")

    @group.callback()
    def about() -> None:
        """Say what is measured of a scene."""

    @group.command()
    def jerk(
        scene: SceneName,
        out: Out = Path("out"),
        sets: Sets = None,
        json_lines: Json = False,
        quiet: Quiet = False,
        verbose: Verbose = False,
    ) -> None:
        """Say how smoothly the first dancer moves its hands, by both controllers."""
        from pipeline.production.jerk_report import report_jerk

        reporter = flags(json_lines, quiet, verbose)
        told = report_jerk(order_of(scene, sets, out), reporter)
        reporter.result(told.text, jerk=told.facts)

    return group
