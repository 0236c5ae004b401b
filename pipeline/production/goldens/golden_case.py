"""Golden case: a scene, the folder of its golden, and the renderer of its frames."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from pipeline.errors import PronkError, UsageError
from pipeline.production.goldens.golden_card import Card, read_card
from pipeline.production.goldens.verdict import LAYERS, Layer
from pipeline.production.run.interrupts import held_back
from pipeline.production.run.scene_run import translated_errors
from pipeline.spec import Scene, find_scene, library, load_scene
from pipeline.spec.scene_library import SUFFIX
from pipeline.spec.suggestions import hint
from render.backend import Choice, choose
from render.renderer import Renderer

GOLDENS_FOLDER = "goldens"
"""Folder of the goldens beside the scenes."""

CHECK_FOLDER = "golden"
"""Folder of the results of checks, among the outputs."""


@dataclass(frozen=True, slots=True)
class GoldenFolder:
    """Files of the golden of one scene, or of a candidate for it.

    Attributes:
        path: such as goldens/first_steps.
    """

    path: Path

    @property
    def card(self) -> Path:
        """Scene, limits, and digests of the files."""
        return self.path / "golden.yaml"

    @property
    def motion(self) -> Path:
        """Motion of the take."""
        return self.path / "motion.json"

    @property
    def cues(self) -> Path:
        """Camera poses and notes of the score."""
        return self.path / "cues.json"

    @property
    def film(self) -> Path:
        """Container, pictures and sound onsets of the film."""
        return self.path / "film.json"

    @property
    def spreads(self) -> Path:
        """Differences of frames rendered with other seeds."""
        return self.path / "spreads.json"

    def frame(self, number: int) -> Path:
        """Return the picture of a frame."""
        return self.path / f"{number:04d}.png"


def golden_folder(file: Path, given: Path | None) -> Path:
    """Return the folder of a scene's goldens, by default beside the scene.

    Goldens of a shipped scene are in the current folder, not in the library.
    """
    if given is not None:
        return given
    shipped = file.resolve().parent == library().resolve()
    return Path(GOLDENS_FOLDER) if shipped else file.parent / GOLDENS_FOLDER


def refuse_in_ci(action: str) -> None:
    """Refuse to write goldens in continuous integration.

    Args:
        action: participle for the message, such as "approved".

    Raises:
        UsageError: this runs in continuous integration.
    """
    if os.environ.get("CI", "").lower() not in ("", "0", "false"):
        raise UsageError(
            f"CI is set, and goldens are not {action} by an automaton: somebody has to look. "
            "Do it on a machine of your own and commit the folder"
        )


@dataclass(frozen=True, slots=True)
class Case:
    """One scene and its golden.

    Attributes:
        name: of the scene and of its golden.
        scene: as its author wrote it.
        golden: its files.
        out: folder of the outputs.
        arguments: of a command line for this scene.
    """

    name: str
    scene: Scene
    golden: GoldenFolder
    out: Path
    arguments: str

    @property
    def made(self) -> GoldenFolder:
        """Files that the last check made."""
        return GoldenFolder(self.out / CHECK_FOLDER / self.name)

    @property
    def compared(self) -> Path:
        """Seals of the last comparison."""
        return self.out / CHECK_FOLDER / f"{self.name}.json"


class GoldenRenderer:
    """The renderer of golden frames, made when first needed.

    Args:
        choice: variant of Mitsuba.
        threads: of the renderer; pixels do not depend on them.
    """

    def __init__(self, choice: Choice = "auto", threads: int | None = None) -> None:
        self._choice = choice
        self._threads = threads

    @cached_property
    def loaded(self) -> Renderer:
        """The renderer, loaded at first use.

        Raises:
            FilmingError: no variant works.
        """
        with translated_errors():
            backend = choose(self._choice)
            with held_back():
                return Renderer(backend, self._threads)

    @property
    def environment(self) -> str:
        """Key of the backend that pixels depend on."""
        return self.loaded.backend.key


def cases_of(
    names: Sequence[str], goldens: Path | None, out: Path, sets: Sequence[str] = ()
) -> list[Case]:
    """Return the cases of scenes, by default of all that have a golden.

    Raises:
        UsageError: there is no such scene, two have one name, or nothing has a golden.
        SceneError: a scene is wrong.
    """
    cases = [_case(name, find_scene(name), goldens, out, sets) for name in names]
    if not names:
        folder = goldens or Path(GOLDENS_FOLDER)
        files = map(_scene_file, goldens_in(folder))
        cases = [_case(str(file), file, folder, out, sets) for file in files]
        if not cases:
            raise UsageError(f"{folder}: there are no goldens here; name a scene, or --goldens")
    called = [case.name for case in cases]
    for name in called:
        if called.count(name) > 1:
            raise UsageError(f"two scenes are called '{name}'; check one after the other")
    return cases


def goldens_in(folder: Path) -> list[GoldenFolder]:
    """Return the goldens of a folder, none where there is no such folder.

    Raises:
        UsageError: no folder can be called so, or it cannot be read.
    """
    try:
        folder.stat()
    except (FileNotFoundError, NotADirectoryError):
        return []
    except OSError as error:
        raise UsageError(f"--goldens {folder}: cannot be read: {error.strerror}") from None
    return [GoldenFolder(path.parent) for path in sorted(folder.glob("[!.]*/golden.yaml"))]


def _scene_file(golden: GoldenFolder) -> Path:
    """Return the file of a golden's scene, beside the folder of goldens or by name."""
    beside = golden.path.parent.parent / (golden.path.name + SUFFIX)
    return beside if beside.is_file() else find_scene(golden.path.name)


def _case(name: str, file: Path, goldens: Path | None, out: Path, sets: Sequence[str]) -> Case:
    folder = golden_folder(file, goldens)
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
    """Return the layers of a list separated by commas; None for all.

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


def golden_list(folder: Path) -> tuple[str, list[dict[str, Any]]]:
    """Return the goldens of a folder as text and as plain values."""
    lines: list[str] = []
    facts: list[dict[str, Any]] = []
    for golden in goldens_in(folder):
        size = sum(path.stat().st_size for path in golden.path.iterdir())
        try:
            card = read_card(golden.card)
        except PronkError as error:
            lines.append(f"{golden.path.name:<24} {error}")
            facts.append({"scene": golden.path.name, "error": str(error)})
            continue
        lines.append(f"{golden.path.name:<24} {size / 1000:6.0f} kB  {_card_text(card)}")
        facts.append({"bytes": size, **card.model_dump(mode="json", exclude={"files"})})
    return "\n".join(lines) or f"{folder}: there are no goldens here", facts


def _card_text(card: Card) -> str:
    items = [", ".join(card.layers)]
    if card.frames is not None:
        width, height = card.frames.size
        numbers = ", ".join(map(str, card.frames.numbers))
        items.append(f"frames {numbers} of {width}x{height}, {card.frames.samples} samples")
        limits = card.limits
        how = f"from {card.calibrated} seeds" if card.calibrated else "not calibrated"
        items.append(f"limits {limits.mean:g}, {limits.tile:g} ({how})")
        items.append(card.environment)
    return "; ".join(items)
