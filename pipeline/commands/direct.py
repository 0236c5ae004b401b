"""`pronk direct`: a scene that another program directs. No logic; imports when it runs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar

import typer

from pipeline.commands.options import Assignments, OutFolder, SceneName, Verbosity, with_options


@dataclass(kw_only=True)
class DirectOptions(Verbosity):
    """Options of a directed scene; its standard output belongs to the other program."""

    stopped: ClassVar[str] = "the take is given up, the commands are kept"
    out: OutFolder = Path("out")
    sets: Assignments = None


@with_options
def direct(
    scene: SceneName,
    options: DirectOptions,
    socket: Annotated[
        Path | None,
        typer.Option(help="Listen on a local socket of this name instead of standard input."),
    ] = None,
    port: Annotated[
        int | None,
        typer.Option(
            min=0,
            max=65535,
            help="Listen on a TCP port; 0 takes a free one, which is printed even with --quiet.",
        ),
    ] = None,
    host: Annotated[
        str, typer.Option(help="Address of the port; default: this machine only.")
    ] = "127.0.0.1",
    token_file: Annotated[
        Path | None,
        typer.Option(
            help="File for the token of the port; default: SCENE_directed.token with the outputs."
        ),
    ] = None,
    name: Annotated[
        str | None, typer.Option(help="Name of the directed scene; default: SCENE_directed.")
    ] = None,
) -> None:
    """Let another program direct a scene by JSON-RPC 2.0, one message per line.

    Leaves a take, and a scene that does the same by itself.
    """
    from pipeline.production.direct.scene_recorder import recorder_for
    from pipeline.production.direct.server import direct as serve
    from pipeline.production.direct.transport import transport_for
    from pipeline.spec import find_scene, load_scene

    file = find_scene(scene).resolve()
    place = recorder_for(file, name, options.out, options.quiet, options.verbose)
    transport = transport_for(socket, port, host, token_file, place.outputs, options.quiet)
    serve(load_scene(file, options.sets or []), place, transport)
