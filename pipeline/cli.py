"""The command line: the commands in the order of help, and exit codes."""

from __future__ import annotations

import os
import sys
from typing import Annotated, Never

import typer

from pipeline.commands import analysis, films, name_list, options, scene_files
from pipeline.commands.direct import direct
from pipeline.commands.golden import golden
from pipeline.commands.option_suggestions import SuggestingCommand
from pipeline.errors import PronkError
from pipeline.production.run.interrupts import INTERRUPTED, ignore, is_interrupt, listen

app = typer.Typer(
    name="pronk",
    help="One YAML scene in; a path-traced film and a frame-exact score out.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"]},
)

for command in (
    films.render,
    scene_files.check,
    scene_files.figure,
    scene_files.schema,
    analysis.simulate,
    films.midi,
    films.frame,
    films.sheet,
    films.bench,
    films.watch,
    analysis.effort,
    analysis.jumps,
    analysis.fit,
    scene_files.new,
    scene_files.doctor,
    direct,
):
    app.command(cls=SuggestingCommand)(command)
app.command("compile", cls=SuggestingCommand)(scene_files.compile_code)
app.command("list", cls=SuggestingCommand)(name_list.list_names)
app.add_typer(analysis.plots, name="plot")
app.add_typer(golden, name="golden")
app.add_typer(analysis.reports, name="report")


def _version(wanted: bool) -> None:
    if wanted:
        import pipeline

        typer.echo(f"pronk {pipeline.__version__}")
        raise typer.Exit


@app.callback()
def _common(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """One YAML scene in; a path-traced film and a frame-exact score out."""
    del version


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
        typer.echo(f"stopped; {options.CURRENT.options.stopped}", err=True)
        # Libraries whose threads were at work would add tracebacks of their own.
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    sys.exit(code)


def _ended() -> str | int | None:
    """Run the command and return the code it ends with."""
    try:
        app()
    except PronkError as error:
        options.say(error)
        return error.exit_code
    except SystemExit as end:
        # Typer turns Ctrl-C into a code of its own and says nothing.
        return end.code
    except BaseException as error:
        if not is_interrupt(error):
            raise
        return INTERRUPTED
    raise AssertionError("typer ends every command by SystemExit")
