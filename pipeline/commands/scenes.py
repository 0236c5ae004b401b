"""The files that authors write: scenes and figures. No logic; imports are made when they run."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pipeline.commands.options import (
    JsonFlag,
    QuietFlag,
    SceneNames,
    Sets,
    VerboseFlag,
    reporter_of,
)
from pipeline.errors import Problem, SceneError, UsageError


def new(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Of the scene.")],
) -> None:
    """Write a commented starter scene, NAME.yaml, into this folder."""
    import shlex

    from pipeline.production.run.starter_scene import write_starter

    path = write_starter(name, Path())
    typer.echo(f"{path}: written; try: pronk render {shlex.quote(str(path))} --preset draft")


def check(
    scenes: SceneNames,
    sets: Sets = None,
    json_lines: JsonFlag = False,
    quiet: QuietFlag = False,
    verbose: VerboseFlag = False,
) -> None:
    """Say whether scenes are right; every mistake at once, with its line."""
    from pipeline.production.run.scene_check import check_scene, figure_remarks
    from pipeline.spec import find_scene, load_scene

    reporter = reporter_of(json_lines, quiet, verbose)
    problems: list[Problem] = []
    missing: list[UsageError] = []
    for name in scenes:
        try:
            scene = load_scene(find_scene(name), sets or [])
            reporter.result(f"{name}: {check_scene(scene)}")
            for remark in figure_remarks(scene):
                reporter.note(f"note: {remark}", detail=True)
        except SceneError as error:
            problems.extend(error.problems)
        except UsageError as error:
            missing.append(error)
    if problems:
        raise SceneError([*problems, *(Problem("", str(error)) for error in missing)])
    if missing:
        raise missing[0]


def figure(
    names: Annotated[
        list[str],
        typer.Argument(
            metavar="FIGURE...",
            help="Figure files, names of shipped figures, scenes, or SCENE:FIGURE.",
        ),
    ],
    out: Annotated[Path, typer.Option(help="Folder for the pictures.")] = Path("out"),
    denavit: Annotated[
        bool, typer.Option("--dh", help="Say the Denavit-Hartenberg parameters of all limbs.")
    ] = False,
    json_lines: JsonFlag = False,
    quiet: QuietFlag = False,
    verbose: VerboseFlag = False,
) -> None:
    """Say which parts a figure's drawing has and what they weigh, and picture it as it stands."""
    from pipeline.production.reports.figure_sheet import figure_sheet, figures_of

    reporter = reporter_of(json_lines, quiet, verbose)
    for name in names:
        for one in figures_of(name):
            sheet = figure_sheet(one, out, denavit)
            files = ", ".join(str(file) for file in sheet.files)
            reporter.result(f"{sheet.text}\n  {'pictures':<11} {files}", figure=sheet.facts)


def schema(
    figure: Annotated[bool, typer.Option("--figure", help="Of figure files instead.")] = False,
) -> None:
    """Print the JSON Schema (draft-07) of the scene language, for editors."""
    import json

    from pipeline.spec import figure_schema
    from pipeline.spec import schema as scene_schema

    words = figure_schema() if figure else scene_schema()
    typer.echo(json.dumps(words, indent=2, ensure_ascii=False))
