"""The commands; no logic. What they need is imported when they run, so that help is instant."""

from __future__ import annotations

import enum
import os
import re
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Never

import typer

from pipeline.commands.direct import add_direct
from pipeline.commands.golden import golden_commands
from pipeline.commands.report import report_commands
from pipeline.errors import Problem, PronkError, SceneError, UsageError
from pipeline.production.interrupts import ignore, listen

if TYPE_CHECKING:
    from pipeline.production.order import Order
    from pipeline.production.reporting import Reporter

INTERRUPTED = 130

app = typer.Typer(
    name="pronk",
    help="One YAML scene in; a path-traced film and a frame-exact score out.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"]},
)


plots = typer.Typer(no_args_is_help=True, help="Draw what a scene's creatures do, over time.")
app.add_typer(plots, name="plot")
app.add_typer(golden_commands(lambda *given: _flags(*given)), name="golden")
app.add_typer(
    report_commands(lambda *given: _flags(*given), lambda *given: _order(*given)), name="report"
)
add_direct(app, lambda *given: _flags(*given))


class Preset(enum.StrEnum):
    """Quality of the frames."""

    draft = "draft"
    preview = "preview"
    final = "final"
    master = "master"


class BackendName(enum.StrEnum):
    """Variant of Mitsuba."""

    auto = "auto"
    cuda = "cuda"
    llvm = "llvm"
    scalar = "scalar"


@dataclass(slots=True)
class Flags:
    """The flags that every command has."""

    json_lines: bool = False
    quiet: bool = False
    verbose: bool = False

    def reporter(self) -> Reporter:
        """Return the reporter that suits them."""
        from pipeline.production.reporting import reporter_for

        return reporter_for(self.json_lines, self.quiet, self.verbose)


FLAGS = Flags()

SceneName = Annotated[
    str, typer.Argument(metavar="SCENE", help="A file, or the name of a shipped scene.")
]
SceneNames = Annotated[
    list[str], typer.Argument(metavar="SCENE", help="Files, or names of shipped scenes.")
]
Out = Annotated[Path, typer.Option(help="Folder that the scenes' folders are made in.")]
Sets = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="PATH=VALUE", help="Change a word of the scene: fps=30."),
]
PresetOption = Annotated[
    Preset | None, typer.Option(help="Size and quality of the frames; the scene's own if left out.")
]
SizeOption = Annotated[
    str | None, typer.Option(metavar="WxH", help="Size of the frames, such as 1280x720.")
]
SamplesOption = Annotated[
    int | None, typer.Option(min=1, max=65536, help="Rays through each pixel.")
]
BackendOption = Annotated[
    BackendName, typer.Option(help="Variant of Mitsuba; the fastest that works if left out.")
]
JsonFlag = Annotated[bool, typer.Option("--json", help="Say everything as lines of JSON.")]
QuietFlag = Annotated[bool, typer.Option("-q", "--quiet", help="Say nothing but errors.")]
VerboseFlag = Annotated[bool, typer.Option("-v", "--verbose", help="Say more.")]


def _version(wanted: bool) -> None:
    if wanted:
        import pipeline

        typer.echo(f"pronk {pipeline.__version__}")
        raise typer.Exit


@app.callback()
def _common(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Say the version.")
    ] = False,
) -> None:
    """One YAML scene in; a path-traced film and a frame-exact score out."""
    del version


@app.command()
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
    from pipeline.production import produce
    from pipeline.production.order import refuse_clashes

    reporter = _flags(json_lines, quiet, verbose)
    changes = _changes(sets, size, samples)
    orders = [
        _order(name, changes, out, preset, backend, frames=frames, jobs=jobs, sound=not no_sound)
        for name in scenes
    ]
    refuse_clashes(orders)
    for order in orders:
        reporter.result(f"{produce.render(order, reporter).folder}")


@app.command()
def check(
    scenes: SceneNames,
    sets: Sets = None,
    json_lines: JsonFlag = False,
    quiet: QuietFlag = False,
    verbose: VerboseFlag = False,
) -> None:
    """Say whether scenes are right; every mistake at once, with its line."""
    from pipeline.production.checking import check_scene, remarks_on
    from pipeline.spec import find_scene, load_scene

    reporter = _flags(json_lines, quiet, verbose)
    problems: list[Problem] = []
    missing: list[UsageError] = []
    for name in scenes:
        try:
            scene = load_scene(find_scene(name), sets or [])
            reporter.result(f"{name}: {check_scene(scene)}")
            for remark in remarks_on(scene):
                reporter.note(f"note: {remark}", detail=True)
        except SceneError as error:
            problems.extend(error.problems)
        except UsageError as error:
            missing.append(error)
    if problems:
        raise SceneError([*problems, *(Problem("", str(error)) for error in missing)])
    if missing:
        raise missing[0]


@app.command()
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
    from pipeline.production.figure_sheet import figure_sheet, figures_of

    reporter = _flags(json_lines, quiet, verbose)
    for name in names:
        for one in figures_of(name):
            sheet = figure_sheet(one, out, denavit)
            files = ", ".join(str(file) for file in sheet.files)
            reporter.result(f"{sheet.text}\n  {'pictures':<11} {files}", figure=sheet.facts)


@app.command()
def schema(
    figure: Annotated[bool, typer.Option("--figure", help="Of figure files instead.")] = False,
) -> None:
    """Print the JSON Schema (draft-07) of the scene language, for editors."""
    import json

    from pipeline.spec import figure_schema
    from pipeline.spec import schema as scene_schema

    words = figure_schema() if figure else scene_schema()
    typer.echo(json.dumps(words, indent=2, ensure_ascii=False))


@app.command()
def simulate(
    scene: SceneName,
    out: Out = Path("out"),
    sets: Sets = None,
    json_lines: JsonFlag = False,
    quiet: QuietFlag = False,
    verbose: VerboseFlag = False,
) -> None:
    """Simulate a scene and keep its take, rendering nothing."""
    from pipeline.production import produce

    reporter = _flags(json_lines, quiet, verbose)
    outputs, take = produce.simulate_only(_order(scene, sets, out), reporter)
    reporter.result(f"{outputs.take}: digest {take.digest}")


@app.command()
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
    from pipeline.production import produce

    reporter = _flags(json_lines, quiet, verbose)
    outputs = produce.score_only(_order(scene, sets, out, subframe=subframe), reporter)
    reporter.result(f"{outputs.midi}")


@app.command()
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
    from pipeline.production.stills import still

    reporter = _flags(json_lines, quiet, verbose)
    order = _order(scene, _changes(sets, size, samples), out, preset, backend)
    reporter.result(f"{still(order, number, reporter)}")


@app.command()
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
    from pipeline.production.stills import sheet as contact_sheet

    reporter = _flags(json_lines, quiet, verbose)
    order = _order(scene, _changes(sets, size, samples), out, preset, backend)
    reporter.result(f"{contact_sheet(order, count, columns, reporter)}")


@app.command()
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
    backend: BackendOption = BackendName.auto,
    json_lines: JsonFlag = False,
    quiet: QuietFlag = False,
    verbose: VerboseFlag = False,
) -> None:
    """Say how long a frame takes with each preset, and the whole film."""
    from dataclasses import asdict

    from pipeline.production import speed_report

    reporter = _flags(json_lines, quiet, verbose)
    order = _order(scene, sets, out, backend=backend)
    presets = [one.value for one in preset or Preset]
    speeds = speed_report.measure(order, presets, frames, reporter)
    reporter.result(speed_report.told(speeds), presets=[asdict(speed) for speed in speeds])


@app.command()
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
    from pipeline.production import produce, watching
    from pipeline.production.stills import still
    from pipeline.spec import find_scene

    reporter = _flags(json_lines, quiet, verbose)
    file = find_scene(scene)

    def order_of() -> Order:
        changes = _changes(sets, size, samples)
        return _order(str(file), changes, out / watching.PLACE, preset, backend)

    def make(order: Order) -> Path:
        if film:
            return produce.render(order, reporter).film(suffix=order.scene.film.resolved().suffix)
        last = order.scene.n_frames
        return still(order, min(frame or (last + 1) // 2, last), reporter)

    watching.watch(file, order_of, make, reporter, _say)


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
    from pipeline.production import event_plot

    reporter = _flags(json_lines, quiet, verbose)
    order = _order(scene, sets, out, backend=backend)
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
    from pipeline.production import gait_plot

    reporter = _flags(json_lines, quiet, verbose)
    svg, png = gait_plot.plot_gait(_order(scene, sets, out), reporter)
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
    from pipeline.production import mind_plot

    reporter = _flags(json_lines, quiet, verbose)
    svg, png = mind_plot.plot_mind(_order(scene, sets, out), reporter)
    reporter.result(f"{svg}, {png}")


@app.command()
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
    from pipeline.production.effort_report import report_effort

    reporter = _flags(json_lines, quiet, verbose)
    told = report_effort(_order(scene, sets, out), reporter, csv)
    reporter.result(told.text, effort=told.facts)


@app.command()
def jumps(
    scene: SceneName,
    sets: Sets = None,
    json_lines: JsonFlag = False,
    quiet: QuietFlag = False,
    verbose: VerboseFlag = False,
) -> None:
    """Say how creatures hop: what was asked for, what was resolved, and what a jump takes."""
    from pipeline.production.jump_report import report_jumps
    from pipeline.spec import find_scene, load_scene

    reporter = _flags(json_lines, quiet, verbose)
    told = report_jumps(load_scene(find_scene(scene), sets or []))
    reporter.result(told.text, jumps=told.facts)


@app.command()
def fit(
    scene: SceneName,
    sets: Sets = None,
    json_lines: JsonFlag = False,
    quiet: QuietFlag = False,
    verbose: VerboseFlag = False,
) -> None:
    """Find gains with which the first dancer of a scene moves its hands more smoothly."""
    from pipeline.production.jerk_fit import fit_jerk
    from pipeline.spec import find_scene, load_scene

    reporter = _flags(json_lines, quiet, verbose)
    fitted = fit_jerk(load_scene(find_scene(scene), sets or []), reporter)
    reporter.result(fitted.text, fit=fitted.facts)


@app.command()
def new(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Of the scene.")],
) -> None:
    """Write a commented starter scene, NAME.yaml, into this folder."""
    import shlex

    from pipeline.production.starter import write_starter

    path = write_starter(name, Path())
    typer.echo(f"{path}: written; try: pronk render {shlex.quote(str(path))} --preset draft")


@app.command()
def doctor(
    fresh: Annotated[bool, typer.Option("--fresh", help="Probe backends again.")] = False,
    json_lines: JsonFlag = False,
) -> None:
    """Say what is found on this machine, what will be used, and what is missing."""
    import json
    from dataclasses import asdict

    from pipeline.production.doctor import examine

    findings = examine(fresh)
    for finding in findings:
        if json_lines:
            typer.echo(json.dumps(asdict(finding), ensure_ascii=False))
        else:
            mark = "ok " if finding.ok else "!! " if finding.needed else "-  "
            typer.echo(f"{mark} {finding.what:<13} {finding.text}")
    if any(not finding.ok and finding.needed for finding in findings):
        raise typer.Exit(1)


def _flags(json_lines: bool, quiet: bool, verbose: bool) -> Reporter:
    FLAGS.json_lines, FLAGS.quiet, FLAGS.verbose = json_lines, quiet, verbose
    return FLAGS.reporter()


def _changes(sets: list[str] | None, size: str | None, samples: int | None) -> list[str]:
    """Return the words that options change, an explicit `--set` last."""
    changes = []
    if size is not None:
        match = re.fullmatch(r"\s*(\d{1,5})\s*[xX×]\s*(\d{1,5})\s*", size)
        if match is None:
            raise UsageError(f"--size {size!r} is no size; write width and height, as in 1280x720")
        changes.append(f"film.size=[{match[1]},{match[2]}]")
    if samples is not None:
        changes.append(f"film.samples={samples}")
    return [*changes, *(sets or [])]


def _order(
    name: str,
    sets: list[str] | None,
    out: Path,
    preset: Preset | None = None,
    backend: BackendName = BackendName.auto,
    **more: Any,
) -> Order:
    from pipeline.production.order import Order
    from pipeline.spec import find_scene, load_scene

    file = find_scene(name)
    changes = [*([f"film.preset={preset.value}"] if preset else []), *(sets or [])]
    return Order(load_scene(file, changes), file.stem, out, backend=backend.value, **more)


def main() -> Never:
    """Run the command line; every error is one message and an exit code."""
    listen()
    try:
        code = _ended()
    except KeyboardInterrupt:
        # One more, while the first was being answered.
        code = INTERRUPTED
    if code == INTERRUPTED:
        ignore()
        typer.echo("stopped; the same command goes on where it was", err=True)
        # Libraries whose threads were at work would add tracebacks of their own.
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    sys.exit(code)


def _ended() -> str | int | None:
    """Run the command and return the code it ends with."""
    try:
        app()
    except PronkError as error:
        _say(error)
        return error.exit_code
    except SystemExit as end:
        # Typer turns Ctrl-C into a code of its own and says nothing.
        return end.code
    except BaseException as error:
        if not _is_interrupt(error):
            raise
        return INTERRUPTED
    raise AssertionError("typer ends every command by SystemExit")


def _is_interrupt(error: BaseException | None) -> bool:
    """Say whether Ctrl-C is behind an error; compiled modules wrap it in one of their own."""
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__ or error.__context__
    return error is not None


def _say(error: PronkError) -> None:
    """Write an error where the flags want it."""
    if not FLAGS.json_lines:
        typer.echo(f"error: {error}", err=True)
        return
    import json
    from dataclasses import asdict

    words: dict[str, object] = {"event": "error", "exit_code": error.exit_code}
    if isinstance(error, SceneError):
        words["problems"] = [asdict(problem) for problem in error.problems]
    typer.echo(json.dumps({**words, "message": str(error)}, ensure_ascii=False))
