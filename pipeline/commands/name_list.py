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
    from dataclasses import asdict

    from pipeline.spec.name_catalogue import NAME_KINDS, NameEntry, names_of

    if kind is None:
        entries = [NameEntry(name, f"{kind.text}") for name, kind in NAME_KINDS.items()]
    else:
        entries = names_of(kind, Path())
    if json_lines:
        for entry in entries:
            typer.echo(json.dumps(asdict(entry), ensure_ascii=False))
        return
    width = max((len(entry.name) for entry in entries), default=0)
    group = ""
    for entry in entries:
        if entry.group != group:
            group = entry.group
            typer.echo(f"{group}:")
        indent = "  " if group else ""
        typer.echo(f"{indent}{entry.name:<{width}}  {entry.text}".rstrip())
