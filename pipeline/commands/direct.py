"""`pronk direct`: a scene that another program directs. No logic; imports are made when it runs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pipeline.commands.options import (
    Out,
    QuietFlag,
    SceneName,
    Sets,
    VerboseFlag,
    reporter_of,
)


def direct(
    scene: SceneName,
    socket: Annotated[
        Path | None,
        typer.Option(help="Listen at a local socket of this name, not at standard input."),
    ] = None,
    port: Annotated[
        int | None,
        typer.Option(min=0, max=65535, help="Listen at a port of TCP; 0 takes a free one."),
    ] = None,
    host: Annotated[
        str, typer.Option(help="Where the port is open to; this machine alone if left out.")
    ] = "127.0.0.1",
    name: Annotated[
        str | None, typer.Option(help="Of the directed scene; SCENE_directed if left out.")
    ] = None,
    out: Out = Path("out"),
    sets: Sets = None,
    quiet: QuietFlag = False,
    verbose: VerboseFlag = False,
) -> None:
    """Let another program direct a scene, by JSON-RPC 2.0: one message a line.

    Leaves a take, and a scene that does the same by itself.
    """
    from pipeline.production.direct.recording import recorder_for
    from pipeline.production.direct.server import direct as serve
    from pipeline.production.direct.transport import transport_for
    from pipeline.spec import find_scene, load_scene

    reporter_of(False, quiet, verbose, stopped="the take is given up, the commands are kept")
    file = find_scene(scene).resolve()
    recorder = recorder_for(file, name, out, quiet, verbose)
    serve(load_scene(file, sets or []), recorder, transport_for(socket, port, host))
