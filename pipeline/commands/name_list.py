"""Command that lists the names authors may write. No logic; imports when it runs."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from pipeline.commands.completion import complete_kind
from pipeline.terminal_text import escaped_line
from pipeline.text_stream import print_json, print_text


def list_names(
    kind: Annotated[
        str | None,
        typer.Argument(
            metavar="[KIND]",
            help="Kind of names; the kinds themselves if left out.",
            autocompletion=complete_kind,
        ),
    ] = None,
    json_lines: Annotated[bool, typer.Option("--json", help="Print JSON lines.")] = False,
) -> None:
    """List the names there are: figures, scenes, materials, gaits, instruments and others."""
    from pipeline.production.reports.figure_size import ListedName, listed_names
    from pipeline.spec.name_catalogue import NAME_KINDS, NameEntry

    if kind is None:
        entries = [ListedName(NameEntry(name, kind.text)) for name, kind in NAME_KINDS.items()]
    else:
        entries = list(listed_names(kind, Path()))
    if json_lines:
        for listed in entries:
            print_json(sys.stdout, listed.facts)
        return
    width = max((len(listed.entry.name) for listed in entries), default=0)
    group = ""
    for listed in entries:
        if listed.entry.group != group:
            group = listed.entry.group
            print_text(sys.stdout, f"{group}:")
        indent = "  " if group else ""
        line = f"{indent}{listed.entry.name:<{width}}  {listed.text}".rstrip()
        print_text(sys.stdout, escaped_line(line))
