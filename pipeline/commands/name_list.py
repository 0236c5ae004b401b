"""Command that lists the names authors may write. No logic; imports when it runs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pipeline.commands.completion import complete_kind


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
    import json

    from pipeline.production.reports.figure_size import ListedName, listed_names
    from pipeline.spec.name_catalogue import NAME_KINDS, NameEntry

    if kind is None:
        entries = [ListedName(NameEntry(name, kind.text)) for name, kind in NAME_KINDS.items()]
    else:
        entries = list(listed_names(kind, Path()))
    if json_lines:
        for listed in entries:
            typer.echo(json.dumps(listed.facts, ensure_ascii=False))
        return
    width = max((len(listed.entry.name) for listed in entries), default=0)
    group = ""
    for listed in entries:
        if listed.entry.group != group:
            group = listed.entry.group
            typer.echo(f"{group}:")
        indent = "  " if group else ""
        typer.echo(f"{indent}{listed.entry.name:<{width}}  {listed.text}".rstrip())
