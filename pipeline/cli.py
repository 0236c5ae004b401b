"""The command line: the commands in the order of help, and exit codes."""

from __future__ import annotations

import io
import logging
import os
import sys
from typing import Annotated, Never

import typer

from pipeline.commands import analysis, films, name_list, options, scene_files
from pipeline.commands.direct import direct
from pipeline.commands.farm import farm
from pipeline.commands.golden import golden
from pipeline.commands.option_suggestions import SuggestingCommand
from pipeline.commands.studio import studio
from pipeline.commands.usage_errors import EscapingGroup
from pipeline.errors import UsageError
from pipeline.production.run.interrupts import INTERRUPTED, ignore, is_interrupt, listen
from pipeline.text_stream import EscapingFormatter, print_text
from pipeline.unexpected_error import require_memory, told_error

app = typer.Typer(
    name="pronk",
    cls=EscapingGroup,
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
    films.verify,
    analysis.cuts,
    analysis.effort,
    analysis.jumps,
    analysis.fit,
    scene_files.new,
    scene_files.doctor,
    direct,
    studio,
):
    app.command(cls=SuggestingCommand)(command)
app.command("compile", cls=SuggestingCommand)(scene_files.compile_code)
app.command("list", cls=SuggestingCommand)(name_list.list_names)
app.add_typer(analysis.plots, name="plot")
app.add_typer(farm, name="farm")
app.add_typer(golden, name="golden")
app.add_typer(analysis.reports, name="report")


def _version(wanted: bool) -> None:
    if wanted:
        import pipeline

        print_text(sys.stdout, f"pronk {pipeline.__version__}")
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
    _hold_streams()
    _log_escaped()
    listen()
    try:
        code = _ended()
    except KeyboardInterrupt:
        # One more, while the first was being answered.
        code = INTERRUPTED
    if code == INTERRUPTED:
        ignore()
        print_text(sys.stderr, f"stopped; {options.CURRENT.options.stopped}")
        # Libraries whose threads were at work would add tracebacks of their own.
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    sys.exit(code)


def _hold_streams() -> None:
    """Make standard streams that can hold any text, and files where they are closed.

    A file that is opened later would take the place of a closed stream, and what is printed would
    go into it.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            # Takes the lowest number that is free, which is this one.
            os.open(os.devnull, os.O_RDWR)
    if sys.stderr is None:
        sys.stderr = open(2, "w", encoding="utf-8", closefd=False)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def _require_output() -> None:
    """Refuse to work where the result cannot be told.

    Raises:
        UsageError: standard output is closed.
    """
    if sys.stdout is None:
        raise UsageError("standard output is closed; write > /dev/null where it is not wanted")


def _log_escaped() -> None:
    """Escape control characters in warnings of the log, too."""
    last = logging.lastResort
    if last is not None:
        last.setFormatter(EscapingFormatter())


def _ended() -> str | int | None:
    """Run the command and return the code it ends with."""
    try:
        _require_output()
        require_memory()
        app(prog_name="pronk")
    except SystemExit as end:
        # Typer turns Ctrl-C into a code of its own and says nothing.
        return end.code
    except BaseException as error:
        if is_interrupt(error):
            return INTERRUPTED
        if not isinstance(error, Exception):
            raise
        told = told_error(error)
        options.say(told)
        return told.exit_code
    raise AssertionError("typer ends every command by SystemExit")


if __name__ == "__main__":
    main()
