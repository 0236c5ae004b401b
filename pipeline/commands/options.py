"""The options that commands share, and what they come to: a reporter, changes, an order."""

from __future__ import annotations

import enum
import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pipeline.errors import PronkError, SceneError, UsageError

if TYPE_CHECKING:
    from pipeline.production.run.order import Order
    from pipeline.production.run.progress import Reporter


GOES_ON = "the same command goes on where it was"


class Preset(enum.StrEnum):
    """Quality of the frames."""

    draft = "draft"
    preview = "preview"
    final = "final"
    master = "master"


class BackendName(enum.StrEnum):
    """Variant of Mitsuba."""

    auto = "auto"
    cuda = "cuda"
    llvm = "llvm"
    scalar = "scalar"


@dataclass(slots=True)
class Flags:
    """The flags that every command has."""

    json_lines: bool = False
    quiet: bool = False
    verbose: bool = False
    stopped: str = GOES_ON
    """What is said after Ctrl-C."""

    def reporter(self) -> Reporter:
        """Return the reporter that suits them."""
        from pipeline.production.run.progress import reporter_for

        return reporter_for(self.json_lines, self.quiet, self.verbose)


FLAGS = Flags()

SceneName = Annotated[
    str, typer.Argument(metavar="SCENE", help="A file, or the name of a shipped scene.")
]
SceneNames = Annotated[
    list[str], typer.Argument(metavar="SCENE", help="Files, or names of shipped scenes.")
]
Out = Annotated[Path, typer.Option(help="Folder that the scenes' folders are made in.")]
Sets = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="PATH=VALUE", help="Change a word of the scene: fps=30."),
]
PresetOption = Annotated[
    Preset | None, typer.Option(help="Size and quality of the frames; the scene's own if left out.")
]
SizeOption = Annotated[
    str | None, typer.Option(metavar="WxH", help="Size of the frames, such as 1280x720.")
]
SamplesOption = Annotated[
    int | None, typer.Option(min=1, max=65536, help="Rays through each pixel.")
]
BackendOption = Annotated[
    BackendName, typer.Option(help="Variant of Mitsuba; the fastest that works if left out.")
]
JsonFlag = Annotated[bool, typer.Option("--json", help="Say everything as lines of JSON.")]
QuietFlag = Annotated[bool, typer.Option("-q", "--quiet", help="Say nothing but errors.")]
VerboseFlag = Annotated[bool, typer.Option("-v", "--verbose", help="Say more.")]


def reporter_of(json_lines: bool, quiet: bool, verbose: bool, stopped: str = GOES_ON) -> Reporter:
    """Keep the flags of the command that runs, and return the reporter that suits them."""
    FLAGS.json_lines, FLAGS.quiet, FLAGS.verbose = json_lines, quiet, verbose
    FLAGS.stopped = stopped
    return FLAGS.reporter()


def changes_of(sets: list[str] | None, size: str | None, samples: int | None) -> list[str]:
    """Return the words that options change, an explicit `--set` last."""
    changes = []
    if size is not None:
        match = re.fullmatch(r"\s*(\d{1,5})\s*[xX×]\s*(\d{1,5})\s*", size)
        if match is None:
            raise UsageError(f"--size {size!r} is no size; write width and height, as in 1280x720")
        changes.append(f"film.size=[{match[1]},{match[2]}]")
    if samples is not None:
        changes.append(f"film.samples={samples}")
    return [*changes, *(sets or [])]


def order_of(
    name: str,
    sets: list[str] | None,
    out: Path,
    preset: Preset | None = None,
    backend: BackendName = BackendName.auto,
    **more: Any,
) -> Order:
    """Return what is asked of a run on a scene, by the scene's name.

    Raises:
        UsageError: if there is no such scene.
        SceneError: if it is wrong.
    """
    from pipeline.production.run.order import Order
    from pipeline.spec import find_scene, load_scene

    file = find_scene(name)
    changes = [*([f"film.preset={preset.value}"] if preset else []), *(sets or [])]
    return Order(load_scene(file, changes), file.stem, out, backend=backend.value, **more)


def say(error: PronkError) -> None:
    """Write an error where the flags want it."""
    if not FLAGS.json_lines:
        typer.echo(f"error: {error}", err=True)
        return
    import json
    from dataclasses import asdict

    words: dict[str, object] = {"event": "error", "exit_code": error.exit_code}
    if isinstance(error, SceneError):
        words["problems"] = [asdict(problem) for problem in error.problems]
    typer.echo(json.dumps({**words, "message": str(error)}, ensure_ascii=False))
