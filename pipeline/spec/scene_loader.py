"""Scene loader: from a file to a checked scene.

Values are read (`yaml_reader`), earlier keys renamed (`renamed_keys`), values of the command
line laid over them (`overrides`), names of files, figures and dances completed
(`file_references`, `library_search`), and every key checked against its model (`validation`).
"""

from __future__ import annotations

import logging
import re
from collections.abc import Sequence
from pathlib import Path

from pipeline.errors import Problem, SceneError, UsageError
from pipeline.foreign_files.confinement import Confinement
from pipeline.foreign_files.safe_file import ForeignFileError
from pipeline.spec.figure import Figure
from pipeline.spec.file_references import complete_file_names
from pipeline.spec.library_search import DANCE_BLOCK, FIGURE_BLOCK, FigureFile, LibrarySearch
from pipeline.spec.model_base import NAME_PATTERN
from pipeline.spec.name_references import faults_of_references
from pipeline.spec.overrides import override
from pipeline.spec.renamed_keys import rename_keys
from pipeline.spec.scene import VERSION, Scene
from pipeline.spec.scene_library import FIGURE, SEQUENCE, find_figure
from pipeline.spec.suggestions import hint
from pipeline.spec.timing import faults_of_timing
from pipeline.spec.validation import MISSING, check, in_order, problems_of_faults, with_meant_keys
from pipeline.spec.yaml_reader import read_bytes, read_file
from pipeline.spec.yaml_tree import ListNode, MappingNode, ScalarNode, plain_values

LOG = logging.getLogger("pronk")


def load_scene(path: str | Path, overrides: Sequence[str] = (), untrusted: bool = False) -> Scene:
    """Load a scene with all figures that its cast uses.

    Args:
        path: the file; `find_scene` finds it by name.
        overrides: `path=value` each, applied in this order before anything is validated.
        untrusted: whether to refuse files outside of its folder, and large ones.

    Raises:
        UsageError: there is no such file.
        SceneError: the scene or a figure in it is wrong; holds every problem found.
    """
    path = Path(path)
    _require(path)
    confinement = confinement_beside(path) if untrusted else None
    tree, problems = read_file(path)
    return _scene(tree, problems, str(path), path.parent, overrides, confinement)


def confinement_beside(path: Path) -> Confinement:
    """Return the confinement to the folder of a stranger's file.

    Raises:
        SceneError: the file is a link that leads elsewhere, or no regular file.
    """
    try:
        return Confinement.beside(path)
    except ForeignFileError as error:
        raise SceneError([Problem("", str(error), str(path))]) from None


def read_scene(
    text: str | bytes,
    file: str = "scene",
    beside: Path | None = None,
    overrides: Sequence[str] = (),
) -> Scene:
    """Read a scene from its text.

    Args:
        text: content of the file.
        file: its name in messages.
        beside: folder in which figures are looked for before the library.
        overrides: `path=value` each, applied in this order before anything is validated.

    Raises:
        SceneError: the scene or a figure in it is wrong; holds every problem found.
    """
    content = text.encode("utf-8", "surrogatepass") if isinstance(text, str) else text
    tree, problems = read_bytes(content, file)
    return _scene(tree, problems, file, beside, overrides)


def load_figure(path: str | Path) -> Figure:
    """Load the figure of a figure file.

    Raises:
        UsageError: there is no such file.
        SceneError: the figure is wrong; holds every problem found.
    """
    return _figure_file(Path(path))[0].figure


def load_figures(name: str) -> tuple[Scene, tuple[str, ...]]:
    """Load the figures that a name stands for.

    Args:
        name: of a figure file, of a shipped figure or of a scene; or `scene:figure`, where the
            figure may be one of the scene or the name of a member of its cast.

    Returns:
        A scene that holds the figures, and their names in it.

    Raises:
        UsageError: there is no figure of that name.
        SceneError: the scene or a figure in it is wrong; holds every problem found.
    """
    path, figure = find_figure(name)
    tree, _ = read_file(path)
    if tree is not None and "figure" in tree.entries and not figure:
        scene = _scene_around(path)
        return scene, tuple(scene.figures)
    scene = load_scene(path)
    if not figure:
        return scene, tuple(scene.figures)
    known = {name: name for name in scene.figures}
    cast = [member for _, member in scene.creatures]
    known |= {member.name: member.figure for member in cast if member.name not in known}
    if figure not in known:
        raise UsageError(f"{path}: no figure is called '{figure}', {hint(figure, known)}")
    return scene, (known[figure],)


def _scene_around(path: Path) -> Scene:
    """Return a scene of one frame whose cast is the figure of a figure file."""
    file, tree = _figure_file(path)
    name = path.stem if re.fullmatch(NAME_PATTERN, path.stem) else "figure"
    top, figure = tree.place, tree.entries["figure"]
    empty = MappingNode(top, {})
    scene = (
        empty.with_entry("pronk", top, ScalarNode(top, file.pronk))
        .with_entry("frames", top, ScalarNode(top, 1))
        .with_entry("figures", top, empty.with_entry(name, figure.key, figure.value))
        .with_entry(
            "cast", top, ListNode(top, (empty.with_entry("figure", top, ScalarNode(top, name)),))
        )
    )
    return _scene(scene, [], str(path), None, ())


def _figure_file(path: Path) -> tuple[FigureFile, MappingNode]:
    _require(path)
    tree, problems = read_file(path)
    if tree is None:
        raise SceneError(in_order(problems, [str(path)]))
    refuse_newer(tree)
    loaded, invalid = check(FigureFile, tree)
    if loaded is None or problems or invalid:
        raise SceneError(in_order([*problems, *invalid], [str(path)]))
    return loaded, tree


def _require(path: Path) -> None:
    """Raise a `UsageError` unless there is such a file or folder."""
    try:
        if path.exists():
            return
    except (OSError, ValueError) as error:
        raise UsageError(f"no file can be called {str(path)!r}: {error}") from None
    raise UsageError(f"there is no file '{path}'")


def _scene(
    tree: MappingNode | None,
    problems: list[Problem],
    file: str,
    beside: Path | None,
    overrides: Sequence[str],
    confinement: Confinement | None = None,
) -> Scene:
    """Return the checked scene of a tree.

    Args:
        tree: what the file holds, None if it cannot be read.
        problems: found when it was read.
        file: its name.
        beside: its folder, None where it has none.
        overrides: `path=value` each.
        confinement: of an untrusted scene.

    Raises:
        SceneError: something is wrong; holds every problem found.
    """
    if tree is None:
        raise SceneError(in_order(problems, [file]))
    refuse_newer(tree)
    if SEQUENCE in tree.entries:
        message = "is a sequence of scenes; pronk render, check and verify take it, or one scene"
        raise SceneError([tree.entries[SEQUENCE].key.problem((SEQUENCE,), message)])
    if FIGURE in tree.entries and "cast" not in tree.entries:
        message = "is a figure, not a scene; pronk figure reports on it, pronk studio draws it"
        raise SceneError([tree.entries[FIGURE].key.problem((FIGURE,), message)])
    tree, warnings, renamed_twice = rename_keys(tree)
    tree, wrong_overrides = override(tree, overrides)
    tree, more_warnings, _ = rename_keys(tree)
    search = LibrarySearch(beside, file, confinement)
    tree = search.complete(search.complete(tree, FIGURE_BLOCK), DANCE_BLOCK)
    tree, missing_files = complete_file_names(tree, beside, confinement)
    scene, invalid = check(Scene, tree)
    if scene is None:
        # The model checks what belongs together only when all else is right.
        meant = with_meant_keys(Scene, tree)
        if meant is not tree and isinstance(meant, MappingNode):
            meant = search.complete(search.complete(meant, FIGURE_BLOCK), DANCE_BLOCK)
            more = check(Scene, meant)[1]
            # What is missing may be there under a misspelt key.
            invalid = [p for p in invalid if p.message != MISSING or p in more]
            invalid = _merged(invalid, more)
        values = plain_values(meant)
        faults = [*faults_of_timing(values), *faults_of_references(values)]
        invalid = _merged(invalid, problems_of_faults(meant, faults))
    problems = [*problems, *renamed_twice, *wrong_overrides, *missing_files]
    problems += [*search.problems, *invalid]
    if scene is None or problems:
        raise SceneError(in_order(problems, [file, *search.files]))
    for warning in [*warnings, *more_warnings]:
        LOG.warning(warning)
    return scene.with_source(tree)


def refuse_newer(tree: MappingNode) -> None:
    """Refuse a file in a later version of the language, before its new keys are called wrong.

    Raises:
        SceneError: the version is newer than the one that is read here.
    """
    version = tree.get("pronk")
    if isinstance(version, ScalarNode) and type(version.value) is int and version.value > VERSION:
        message = f"this pronk reads version {VERSION} of the language, not {version.value}"
        raise SceneError([version.place.problem(("pronk",), message)])


def _merged(problems: list[Problem], more: list[Problem]) -> list[Problem]:
    """Add problems at places that have none yet."""
    known = {(p.file, p.line, p.column, p.path) for p in problems}
    return problems + [p for p in more if (p.file, p.line, p.column, p.path) not in known]
