"""Options that commands share, in groups: each group is a dataclass, written once.

A command takes one parameter `options` of a group, and `with_options` gives it an option of the
command line for each field.
"""

from __future__ import annotations

import enum
import inspect
import logging
import re
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, get_type_hints

import typer

from pipeline.commands.completion import completion
from pipeline.errors import PronkError, UsageError, located
from pipeline.text_stream import print_json, print_text

if TYPE_CHECKING:
    from pipeline.production.run.budget import Budget
    from pipeline.production.run.order import Order
    from pipeline.production.run.progress import Reporter
    from pipeline.spec import Scene, SceneSequence
    from render.backend import Choice


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


SceneName = Annotated[
    str,
    typer.Argument(
        metavar="SCENE",
        help="File or name of a shipped scene.",
        autocompletion=completion("scenes", with_files=True),
    ),
]
SceneNames = Annotated[
    list[str],
    typer.Argument(
        metavar="SCENE",
        help="Files or names of shipped scenes.",
        autocompletion=completion("scenes", with_files=True),
    ),
]
OutFolder = Annotated[Path, typer.Option(help="Folder for the output folders of scenes.")]
Assignments = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="PATH=VALUE", help="Change a value of the scene, for example fps=30."
    ),
]
PresetOption = Annotated[
    Preset | None, typer.Option(help="Size and quality of the frames; default: the scene's own.")
]
StrictOption = Annotated[
    bool, typer.Option("--strict", help="Make notes an error, before any frame is rendered.")
]
FramesOption = Annotated[
    str | None, typer.Option(help="Frames to render, for example 1-48,60-90x5; default: all.")
]
NoSoundOption = Annotated[bool, typer.Option("--no-sound", help="Write neither sound nor MIDI.")]
BackendOption = Annotated[
    BackendName, typer.Option(help="Variant of Mitsuba; default: the fastest that works.")
]


@dataclass(kw_only=True)
class Verbosity:
    """Verbosity of a command."""

    stopped: ClassVar[str] = "the same command keeps what is finished and goes on"
    """Message after Ctrl-C."""

    quiet: Annotated[bool, typer.Option("-q", "--quiet", help="Print errors only.")] = False
    verbose: Annotated[bool, typer.Option("-v", "--verbose", help="Print details.")] = False

    @property
    def as_json(self) -> bool:
        """Whether to print JSON lines."""
        return False

    def reporter(self) -> Reporter:
        """Return the reporter for these options."""
        from pipeline.production.run.reporters import reporter_for

        return reporter_for(self.as_json, self.quiet, self.verbose)


@dataclass(kw_only=True)
class Reporting(Verbosity):
    """Verbosity, and JSON lines for programs."""

    are_scenes: ClassVar[bool] = True
    """Whether the command works on scenes, whose files its errors name."""

    json_lines: Annotated[bool, typer.Option("--json", help="Print JSON lines.")] = False

    @property
    def as_json(self) -> bool:
        """Whether to print JSON lines."""
        return self.json_lines

    def run_each(
        self, scenes: list[str], work: Callable[[str, Reporter], None], success: str = "done"
    ) -> None:
        """Work on each of several scenes, whatever becomes of the others.

        Args:
            scenes: files or names.
            work: on each of them.
            success: word of the table for a scene that the work is done on.

        Raises:
            typer.Exit: with the highest exit code, if one failed.
        """
        from pipeline.production.run.batch import run_batch
        from pipeline.spec import find_scene

        find = find_scene if self.are_scenes else lambda _: None
        code = run_batch(scenes, work, self.reporter(), say, success, find)
        if code:
            raise typer.Exit(code)


@dataclass(kw_only=True)
class VerifyOptions(Reporting):
    """Options of the command that checks outputs, which are folders as well as scenes."""

    stopped: ClassVar[str] = "nothing was changed"

    are_scenes: ClassVar[bool] = False

    out: OutFolder = Path("out")


@dataclass(kw_only=True)
class SceneOptions(Reporting):
    """Options of commands that load a scene."""

    sets: Assignments = None

    @property
    def is_untrusted(self) -> bool:
        """Whether scenes are of strangers."""
        return False

    def scene(self, name: str) -> Scene:
        """Load a scene by its name.

        Raises:
            UsageError: there is no such scene.
            SceneError: it is wrong.
        """
        from pipeline.spec import find_scene, load_scene

        return load_scene(find_scene(name), self.sets or [], self.is_untrusted)


@dataclass(kw_only=True)
class Bounds(SceneOptions):
    """Bounds on what a scene may read and take."""

    untrusted: Annotated[
        bool,
        typer.Option(
            "--untrusted",
            help="Read no file outside of the scene's folder and no large ones, and keep to 4 GiB "
            "of memory and 30 minutes.",
        ),
    ] = False
    max_memory: Annotated[
        str | None,
        typer.Option(metavar="SIZE", help="Memory that a scene may take, for example 2GiB."),
    ] = None
    max_time: Annotated[
        str | None,
        typer.Option(metavar="DURATION", help="Time that a scene may take, for example 1h30m."),
    ] = None

    @property
    def is_untrusted(self) -> bool:
        """Whether scenes are of strangers."""
        return self.untrusted

    @property
    def budget(self) -> Budget:
        """What each scene may take.

        Raises:
            UsageError: a limit cannot be read.
        """
        from pipeline.production.run.budget import UNTRUSTED_MEMORY, UNTRUSTED_TIME, Budget
        from pipeline.production.run.quantities import parse_duration, parse_size

        memory = UNTRUSTED_MEMORY if self.untrusted else None
        seconds = UNTRUSTED_TIME if self.untrusted else None
        if self.max_memory is not None:
            memory = parse_size(self.max_memory, "--max-memory")
        if self.max_time is not None:
            seconds = parse_duration(self.max_time, "--max-time")
        return Budget(memory, seconds)

    def run_each(
        self, scenes: list[str], work: Callable[[str, Reporter], None], success: str = "done"
    ) -> None:
        """Work on each of several scenes, each within its budget; see `Reporting`.

        Raises:
            UsageError: a limit cannot be read.
            typer.Exit: with the highest exit code, if one failed.
        """
        from pipeline.production.run.budget_guard import guarded

        budget = self.budget

        def bounded(name: str, reporter: Reporter) -> None:
            with guarded(budget, say):
                work(name, reporter)

        super().run_each(scenes, bounded, success)


@dataclass(kw_only=True)
class CheckOptions(Bounds):
    """Options of the command that checks scenes and writes nothing."""

    stopped: ClassVar[str] = "nothing was written"


@dataclass(kw_only=True)
class RunOptions(SceneOptions):
    """Options of commands that simulate a scene."""

    out: OutFolder = Path("out")

    def assignments(self) -> list[str]:
        """Return the values of the scene that options change, an explicit `--set` last."""
        return self.sets or []

    def run_each(
        self, scenes: list[str], work: Callable[[str, Reporter], None], success: str = "done"
    ) -> None:
        """Work on each of several scenes, which write to folders of their own; see `Reporting`.

        Raises:
            UsageError: two would write to one folder, or an option is wrong for every scene.
            typer.Exit: with the highest exit code, if one failed.
        """
        from pipeline.production.run.order import refuse_clashes

        refuse_clashes(scenes, self.out)
        self.assignments()
        super().run_each(scenes, work, success)

    def order(
        self,
        name: str,
        preset: Preset | None = None,
        backend: Choice = "auto",
        **more: Any,
    ) -> Order:
        """Return the order to run a scene.

        Args:
            name: of the scene.
            preset: quality of the frames.
            backend: variant of Mitsuba.
            more: other fields of the order.

        Raises:
            UsageError: there is no such scene.
            SceneError: it is wrong.
        """
        from pipeline.production.run.order import Order
        from pipeline.spec import find_scene, load_scene

        file = find_scene(name)
        changes = [*([f"film.preset={preset.value}"] if preset else []), *self.assignments()]
        scene = load_scene(file, changes, self.is_untrusted)
        out = more.pop("out", self.out)
        self._refuse_links(file, out)
        return Order(scene, file.stem, out, backend=backend, **more)

    def _refuse_links(self, file: Path, out: Path) -> None:
        """Refuse outputs of a stranger's file that links lead elsewhere.

        Raises:
            StoreError: there is such a link.
        """
        if self.is_untrusted:
            from pipeline.production.run.outputs import Outputs, refuse_links

            refuse_links(Outputs(out / file.stem, file.stem), file.parent)


@dataclass(kw_only=True)
class BoundedRunOptions(Bounds, RunOptions):
    """Options of commands that simulate a scene, which may be of a stranger."""


@dataclass(kw_only=True)
class FrameOptions(RunOptions):
    """Options of commands that render frames."""

    size: Annotated[
        str | None, typer.Option(metavar="WxH", help="Size of the frames, for example 1280x720.")
    ] = None
    samples: Annotated[
        int | None, typer.Option(min=1, max=65536, help="Rays through each pixel.")
    ] = None
    backend: BackendOption = BackendName.auto

    def assignments(self) -> list[str]:
        """Return the values of the scene that options change, an explicit `--set` last."""
        changes = []
        if self.size is not None:
            match = re.fullmatch(r"\s*(\d{1,5})\s*[xX×]\s*(\d{1,5})\s*", self.size)
            if match is None:
                message = f"--size {self.size!r} is no size; write width and height, as in 1280x720"
                raise UsageError(message)
            changes.append(f"film.size=[{match[1]},{match[2]}]")
        if self.samples is not None:
            changes.append(f"film.samples={self.samples}")
        return [*changes, *(self.sets or [])]

    def sequence(self, name: str, preset: Preset | None = None) -> SceneSequence:
        """Return a sequence with its scenes, as the options change them.

        Raises:
            UsageError: there is no such file.
            SceneError: it or one of its scenes is wrong.
        """
        from pipeline.spec import find_scene, load_sequence

        file = find_scene(name)
        self._refuse_links(file, self.out)
        before = [f"film.preset={preset.value}"] if preset else []
        return load_sequence(file, before, self.assignments(), self.is_untrusted)

    def frame_order(self, name: str, preset: Preset | None = None, **more: Any) -> Order:
        """Return the order to render a scene, see `order`."""
        return self.order(name, preset, self.backend.value, **more)


@dataclass(kw_only=True)
class BoundedFrameOptions(Bounds, FrameOptions):
    """Options of the command that renders films of scenes, which may be of strangers."""


@dataclass
class _Current:
    options: Verbosity


CURRENT = _Current(Verbosity())
"""The options of the command that runs."""


def with_options(function: Callable[..., None]) -> Callable[..., None]:
    """Replace the parameter `options` of a command by an option for each of its group's fields."""
    signature = inspect.signature(function, eval_str=True)
    group = signature.parameters["options"].annotation
    types = get_type_hints(group, include_extras=True)
    # The options of a group stand before those of the group that it extends.
    annotated = [name for base in group.__mro__ for name in inspect.get_annotations(base)]
    names = [name for name in annotated if name in inspect.signature(group).parameters]
    shared = [
        inspect.Parameter(
            name,
            inspect.Parameter.KEYWORD_ONLY,
            default=getattr(group, name),
            annotation=types[name],
        )
        for name in names
    ]
    own = [p for p in signature.parameters.values() if p.name != "options"]

    @wraps(function)
    def command(**values: Any) -> None:
        CURRENT.options = group(**{name: values.pop(name) for name in names})
        level = logging.ERROR if CURRENT.options.quiet else logging.WARNING
        logging.getLogger("pronk").setLevel(level)
        function(options=CURRENT.options, **values)

    command.__signature__ = signature.replace(  # type: ignore[attr-defined] # what Typer reads
        parameters=[*(p.replace(kind=inspect.Parameter.KEYWORD_ONLY) for p in own), *shared]
    )
    command.__annotations__ = {p.name: p.annotation for p in [*own, *shared]}
    return command


def say(error: PronkError, scene: str = "", file: Path | None = None) -> None:
    """Write an error as the options of the running command ask.

    Args:
        error: any of pronk's.
        scene: one of the scenes that the command names, "" for an error of none.
        file: of that scene, None if there is none.
    """
    text = str(error) if file is None else located(error, file)
    if not CURRENT.options.as_json:
        print_text(sys.stderr, f"error: {text}")
        return
    event: dict[str, object] = {"event": "error", "exit_code": error.exit_code}
    if scene:
        event["scene"] = scene
    event.update(error.facts)
    print_json(sys.stdout, {**event, "message": text})
