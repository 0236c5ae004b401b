"""Commands on files that authors write, and on the machine. No logic; imports when they run."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pipeline.commands.completion import completion
from pipeline.commands.options import (
    BackendName,
    BackendOption,
    CheckOptions,
    Reporting,
    SceneNames,
    StrictOption,
    with_options,
)
from pipeline.errors import UsageError
from pipeline.text_stream import print_json, print_text

if TYPE_CHECKING:
    from pipeline.production.run.progress import Reporter
    from pipeline.spec import Scene


def new(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Name of the scene.")],
) -> None:
    """Write a commented starter scene, NAME.yaml, into this folder."""
    import shlex

    from pipeline.production.run.starter_scene import write_starter

    path = write_starter(name, Path())
    line = f"{path}: written; try: pronk render {shlex.quote(str(path))} --preset draft"
    print_text(sys.stdout, line)


@with_options
def check(
    scenes: SceneNames,
    options: CheckOptions,
    simulate: Annotated[
        bool,
        typer.Option(
            "--simulate", help="Simulate as well: find what only motion shows, and list notes."
        ),
    ] = False,
    strict: StrictOption = False,
) -> None:
    """Check scenes and sequences: every mistake of each, with its line."""
    from pipeline.production.run.budget import estimate_text
    from pipeline.production.run.scene_check import check_scene, figure_remarks
    from pipeline.production.run.scene_cost import Job, scene_cost
    from pipeline.production.sequence.sequence_run import check_sequence
    from pipeline.spec import find_scene, is_sequence, load_sequence

    def examine(name: str, reporter: Reporter) -> None:
        if is_sequence(find_scene(name), options.is_untrusted):
            examine_clips(name, reporter)
            return
        examine_scene(options.scene(name), name, reporter)

    def examine_clips(name: str, reporter: Reporter) -> None:
        sequence = load_sequence(find_scene(name), (), options.sets or (), options.is_untrusted)
        check_sequence(sequence)
        for clip in sequence.clips:
            examine_scene(clip.scene, clip.name, reporter)
        length = float(sequence.n_frames / sequence.rate)
        reporter.result(f"{name}: {len(sequence.clips)} clips, {length:g} s")

    def examine_scene(scene: Scene, name: str, reporter: Reporter) -> None:
        options.budget.refuse(scene, Job("simulate" if simulate else "check"))
        cost = scene_cost(scene, Job("render", scene.n_frames))
        facts = {"memory": round(cost.memory), "seconds": round(cost.seconds, 1)}
        summary = check_scene(scene, reporter, name, simulate, strict)
        told = f"{name}: {summary}; a film takes {estimate_text(cost)}"
        reporter.result(told, estimate=facts)
        for remark in figure_remarks(scene):
            reporter.note(f"note: {remark.problem}", detail=simulate or not remark.is_fault)

    options.run_each(scenes, examine, success="right")


@with_options
def figure(
    names: Annotated[
        list[str],
        typer.Argument(
            metavar="FIGURE...",
            help="Figure files, names of shipped figures, scenes, or SCENE:FIGURE.",
            autocompletion=completion("figures", "scenes", with_files=True),
        ),
    ],
    options: Reporting,
    out: Annotated[Path, typer.Option(help="Folder for the pictures.")] = Path("out"),
    denavit: Annotated[
        bool, typer.Option("--dh", help="Print the Denavit-Hartenberg parameters of all limbs.")
    ] = False,
    walk: Annotated[
        bool, typer.Option("--walk", help="Also render one cycle of its gait on level ground.")
    ] = False,
    backend: BackendOption = BackendName.auto,
) -> None:
    """Report the parts and masses of a figure, draw it standing, and warn of likely mistakes."""
    from pipeline.production.reports.figure_sheet import drawn_figures, figure_sheet
    from pipeline.production.reports.figure_walk import walk_sheet

    reporter = options.reporter()
    for drawn in (drawn for name in names for drawn in drawn_figures(name)):
        sheet = figure_sheet(drawn, out, denavit)
        files = ", ".join(str(file) for file in sheet.files)
        reporter.result(f"{sheet.text}\n  {'pictures':<11} {files}", figure=sheet.facts)
        if walk:
            walked = walk_sheet(drawn.figure, drawn.scene, out, backend.value, reporter)
            reporter.result(f"  {'walk':<11} {walked.file}: {walked.text}", walk=walked.facts)


def schema(
    figure: Annotated[
        bool, typer.Option("--figure", help="Schema of figure files instead.")
    ] = False,
    sequence: Annotated[
        bool, typer.Option("--sequence", help="Schema of files that join scenes instead.")
    ] = False,
) -> None:
    """Print the JSON Schema (draft-07) of the scene language, for editors."""
    import json

    from pipeline.spec import figure_schema, sequence_schema
    from pipeline.spec import schema as scene_schema

    if figure and sequence:
        raise UsageError("--figure and --sequence: give one of them")
    result = figure_schema() if figure else sequence_schema() if sequence else scene_schema()
    print_text(sys.stdout, json.dumps(result, indent=2, ensure_ascii=False))


def doctor(
    fresh: Annotated[bool, typer.Option("--fresh", help="Probe backends again.")] = False,
    json_lines: Annotated[bool, typer.Option("--json", help="Print JSON lines.")] = False,
) -> None:
    """Report what is installed, what will be used, and what is missing."""
    from dataclasses import asdict

    from pipeline.production.run.doctor import examine

    findings = examine(fresh)
    for finding in findings:
        if json_lines:
            print_json(sys.stdout, asdict(finding))
        else:
            mark = "ok " if finding.ok else "!! " if finding.needed else "-  "
            print_text(sys.stdout, f"{mark} {finding.what:<13} {finding.text}")
    if any(not finding.ok and finding.needed for finding in findings):
        raise typer.Exit(1)


@with_options
def compile_code(options: Reporting) -> None:
    """Compile the simulations of people and bodies for this machine ahead of their first scene."""
    from pipeline.production.run.compile_progress import compile_ahead

    reporter = options.reporter()
    reporter.result(compile_ahead(reporter))
