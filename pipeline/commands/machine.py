"""`pronk doctor`: what this machine has. No logic; imports are made when commands run."""

from __future__ import annotations

from typing import Annotated

import typer

from pipeline.commands.options import (
    JsonFlag,
)


def doctor(
    fresh: Annotated[bool, typer.Option("--fresh", help="Probe backends again.")] = False,
    json_lines: JsonFlag = False,
) -> None:
    """Say what is found on this machine, what will be used, and what is missing."""
    import json
    from dataclasses import asdict

    from pipeline.production.run.doctor import examine

    findings = examine(fresh)
    for finding in findings:
        if json_lines:
            typer.echo(json.dumps(asdict(finding), ensure_ascii=False))
        else:
            mark = "ok " if finding.ok else "!! " if finding.needed else "-  "
            typer.echo(f"{mark} {finding.what:<13} {finding.text}")
    if any(not finding.ok and finding.needed for finding in findings):
        raise typer.Exit(1)
