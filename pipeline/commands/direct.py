"""`pronk direct`: a scene that another program directs. No logic; imports are made when it runs."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from pipeline.production.reporting import Reporter

Flags = Callable[[bool, bool, bool], "Reporter"]
"""Sets the flags that every command has, and returns the reporter that suits them."""


def add_direct(app: typer.Typer, flags: Flags) -> None:
    """Add the command, which says things where `flags` want it."""

    @app.command()
    def direct(
        scene: Annotated[
            str, typer.Argument(metavar="SCENE", help="A file, or the name of a shipped scene.")
        ],
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
        out: Annotated[Path, typer.Option(help="Folder that the scenes' folders are made in.")] = (
            Path("out")
        ),
        sets: Annotated[
            list[str] | None,
            typer.Option("--set", metavar="PATH=VALUE", help="Change a word of the scene: fps=30."),
        ] = None,
        quiet: Annotated[bool, typer.Option("-q", "--quiet", help="Say nothing but errors.")] = (
            False
        ),
        verbose: Annotated[bool, typer.Option("-v", "--verbose", help="Say more.")] = False,
    ) -> None:
        """Let another program direct a scene, by JSON-RPC 2.0: one message a line.

        Leaves a take, and a scene that does the same by itself.
        """
        from pipeline.production.direct.doors import door_of
        from pipeline.production.direct.keeping import place_of
        from pipeline.production.direct.serving import direct as serve
        from pipeline.spec import find_scene, load_scene

        flags(False, quiet, verbose)
        file = find_scene(scene).resolve()
        place = place_of(file, name, out, quiet, verbose)
        serve(load_scene(file, sets or []), place, door_of(socket, port, host))
