"""`pronk studio`: figures and scenes on a page of the browser. No logic; imports when it runs."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import Annotated, ClassVar

import typer

from pipeline.commands.completion import completion
from pipeline.commands.options import Verbosity, with_options
from pipeline.text_stream import print_text


@dataclass(kw_only=True)
class StudioOptions(Verbosity):
    """Options of the studio."""

    stopped: ClassVar[str] = "what was saved is in its files"


@with_options
def studio(
    options: StudioOptions,
    document: Annotated[
        str | None,
        typer.Argument(
            metavar="[SCENE|FIGURE]",
            help="File or name of a scene or figure; default: a new figure.",
            autocompletion=completion("figures", "scenes", with_files=True),
        ),
    ] = None,
    port: Annotated[
        int, typer.Option(min=0, max=65535, help="Port of this machine; 0 takes a free one.")
    ] = 0,
    browser: Annotated[
        bool, typer.Option("--browser/--no-browser", help="Open the page in the browser.")
    ] = True,
) -> None:
    """Draw figures and watch scenes on a page in the browser, served to this machine alone.

    Prints the address of the page with its token; Ctrl-C ends it.
    """
    from pipeline.spec.scene_library import find_figure
    from pipeline.studio.server import serve

    del options
    path = find_figure(document)[0] if document is not None else None
    serve(path, port, browser, lambda address: print_text(sys.stdout, address))
