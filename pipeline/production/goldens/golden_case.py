"""Case: one scene with the place of its golden, and what renders its frames."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from pipeline.errors import FilmingError, UsageError
from pipeline.production.goldens.golden_files import FOLDER, MADE, GoldenFolder, goldens_of
from pipeline.production.goldens.verdict import LAYERS, Layer
from pipeline.production.run.interrupts import held_back
from pipeline.spec import Scene, find_scene, load_scene
from pipeline.spec.scene_library import SUFFIX
from pipeline.spec.suggestions import hint
from render.backend import Choice, choose
from render.errors import RenderError
from render.renderer import Renderer


@dataclass(frozen=True, slots=True)
class Case:
    """One scene and its golden.

    Attributes:
        name: of the scene; its golden is called so.
        scene: as its author wrote it.
        golden: where its golden stands.
        out: where what checks make is put.
        words: that find the scene on a command line, with the options that it needs.
    """

    name: str
    scene: Scene
    golden: GoldenFolder
    out: Path
    words: str

    @property
    def made(self) -> GoldenFolder:
        """What the last check made."""
        return GoldenFolder(self.out / MADE / self.name)

    @property
    def compared(self) -> Path:
        """What the last check compared it with."""
        return self.out / MADE / f"{self.name}.json"


class Lab:
    """What renders the frames of goldens; made when it is first needed.

    Args:
        choice: which variant of Mitsuba.
        threads: of the renderer; pixels do not depend on them.
    """

    def __init__(self, choice: Choice = "auto", threads: int | None = None) -> None:
        self._choice = choice
        self._threads = threads

    @cached_property
    def renderer(self) -> Renderer:
        """The renderer.

        Raises:
            FilmingError: there is none that works.
        """
        try:
            backend = choose(self._choice)
            with held_back():
                return Renderer(backend, self._threads)
        except RenderError as error:
            raise FilmingError(str(error)) from error

    @property
    def environment(self) -> str:
        """What pixels depend on here."""
        return self.renderer.backend.key


def cases_of(
    names: Sequence[str], goldens: Path | None, out: Path, sets: Sequence[str] = ()
) -> list[Case]:
    """Return the cases of scenes; of all that have a golden if none is named.

    Raises:
        UsageError: there is no such scene, two have one name, or nothing has a golden.
        SceneError: a scene is wrong.
    """
    cases = [_case(name, find_scene(name), goldens, out, sets) for name in names]
    if not names:
        folder = goldens or Path(FOLDER)
        cases = [
            _case(str(file), file, folder, out, sets) for file in map(_scene_of, found_in(folder))
        ]
        if not cases:
            raise UsageError(f"{folder}: there are no goldens here; name a scene, or --goldens")
    called = [case.name for case in cases]
    for name in called:
        if called.count(name) > 1:
            raise UsageError(f"two scenes are called '{name}'; check one after the other")
    return cases


def found_in(folder: Path) -> list[GoldenFolder]:
    """Return the goldens of a folder."""
    return [GoldenFolder(path.parent) for path in sorted(folder.glob("[!.]*/golden.yaml"))]


def _scene_of(golden: GoldenFolder) -> Path:
    """Return the file of a golden's scene: beside the folder of goldens, else by name."""
    beside = golden.path.parent.parent / (golden.path.name + SUFFIX)
    return beside if beside.is_file() else find_scene(golden.path.name)


def _case(name: str, file: Path, goldens: Path | None, out: Path, sets: Sequence[str]) -> Case:
    folder = goldens_of(file, goldens)
    options = [f"--goldens {goldens}"] if goldens is not None else []
    options += [f"--out {out}"] if out != Path("out") else []
    return Case(
        file.stem,
        load_scene(file, list(sets)),
        GoldenFolder(folder / file.stem),
        out,
        " ".join([name, *options]),
    )


def layers_of(text: str | None) -> tuple[Layer, ...] | None:
    """Return the layers that are named, separated by commas; None for all that there are.

    Raises:
        UsageError: there is no such layer.
    """
    if text is None:
        return None
    names = [word.strip() for word in text.split(",")]
    for name in names:
        if name not in LAYERS:
            raise UsageError(f"--layers: there is no layer {name!r}, {hint(name, LAYERS)}")
    return tuple(layer for layer in LAYERS if layer in names)
