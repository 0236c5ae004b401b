"""From a file to a scene."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from pipeline.errors import Problem, SceneError, UsageError
from pipeline.spec.body_files import bodies_named_in_full
from pipeline.spec.checking import check, in_order, problems_of_faults
from pipeline.spec.dance_files import DanceSearch
from pipeline.spec.figure import Figure
from pipeline.spec.figure_files import FigureFile, Search
from pipeline.spec.files import read_bytes, read_file
from pipeline.spec.light_files import light_named_in_full
from pipeline.spec.nearest import hint
from pipeline.spec.overrides import override
from pipeline.spec.references import faults_of_references
from pipeline.spec.scene import VERSION, Scene
from pipeline.spec.shipped import find_figure
from pipeline.spec.sound_files import sound_named_in_full
from pipeline.spec.terrain import beside as named_in_full
from pipeline.spec.timing import faults_of_timing
from pipeline.spec.tree import Leaf, Row, Table, plain
from pipeline.spec.values import NAME_PATTERN


def load_scene(path: str | Path, overrides: Sequence[str] = ()) -> Scene:
    """Load a scene with all figures that its cast uses.

    Args:
        path: the file; `find_scene` finds it by name.
        overrides: `path=value` each, applied in this order before anything is validated.

    Raises:
        UsageError: there is no such file.
        SceneError: the scene or a figure in it is wrong; holds every problem found.
    """
    path = Path(path)
    _exists(path)
    tree, problems = read_file(path)
    return _scene(tree, problems, str(path), path.parent, overrides)


def read_scene(
    text: str | bytes,
    file: str = "scene",
    beside: Path | None = None,
    overrides: Sequence[str] = (),
) -> Scene:
    """Read a scene from its text.

    Args:
        text: what the file would hold.
        file: the name that messages call it.
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
            figure may be one of the scene or the name of somebody in its cast.

    Returns:
        A scene that holds the figures, and their names in it.

    Raises:
        UsageError: nothing is called so.
        SceneError: the scene or a figure in it is wrong; holds every problem found.
    """
    path, who = find_figure(name)
    tree, _ = read_file(path)
    if tree is not None and "figure" in tree.entries and not who:
        scene = _scene_around(path)
        return scene, tuple(scene.figures)
    scene = load_scene(path)
    if not who:
        return scene, tuple(scene.figures)
    known = {name: name for name in scene.figures}
    cast = [member for _, member in scene.creatures]
    known |= {member.name: member.figure for member in cast if member.name not in known}
    if who not in known:
        raise UsageError(f"{path}: no figure is called '{who}', {hint(who, known)}")
    return scene, (known[who],)


def _scene_around(path: Path) -> Scene:
    """Return a scene of one frame whose cast is the figure of a figure file."""
    file, tree = _figure_file(path)
    name = path.stem if re.fullmatch(NAME_PATTERN, path.stem) else "figure"
    top, figure = tree.place, tree.entries["figure"]
    member = Table(top, {}).having("figure", top, Leaf(top, name))
    figures = Table(top, {}).having(name, figure.key, figure.value)
    scene = (
        Table(top, {})
        .having("pronk", top, Leaf(top, file.pronk))
        .having("frames", top, Leaf(top, 1))
        .having("figures", top, figures)
        .having("cast", top, Row(top, (member,)))
    )
    return _scene(scene, [], str(path), None, ())


def _figure_file(path: Path) -> tuple[FigureFile, Table]:
    _exists(path)
    tree, problems = read_file(path)
    if tree is None:
        raise SceneError(in_order(problems, [str(path)]))
    _refuse_newer(tree)
    loaded, wrong = check(FigureFile, tree)
    if loaded is None or problems or wrong:
        raise SceneError(in_order([*problems, *wrong], [str(path)]))
    return loaded, tree


def _exists(path: Path) -> None:
    try:
        if path.exists():
            return
    except (OSError, ValueError) as error:
        raise UsageError(f"no file can be called {str(path)!r}: {error}") from None
    raise UsageError(f"there is no file '{path}'")


def _scene(
    tree: Table | None,
    problems: list[Problem],
    file: str,
    beside: Path | None,
    overrides: Sequence[str],
) -> Scene:
    if tree is None:
        raise SceneError(in_order(problems, [file]))
    _refuse_newer(tree)
    tree, wrong = override(tree, overrides)
    search = Search(beside, file)
    tree = search.complete(tree)
    dances = DanceSearch(beside)
    tree = dances.complete(tree)
    tree, nameless = named_in_full(tree, beside)
    tree, missing = bodies_named_in_full(tree, beside)
    tree, silent = sound_named_in_full(tree, beside)
    tree, unlit = light_named_in_full(tree, beside)
    nameless = [*nameless, *missing, *silent, *unlit]
    scene, invalid = check(Scene, tree)
    if scene is None:
        # What does not fit together is found by the model only when all else is right.
        words = plain(tree)
        faults = [*faults_of_timing(words), *faults_of_references(words)]
        invalid = _merged(invalid, problems_of_faults(tree, faults))
    problems = [*problems, *wrong, *nameless, *search.problems, *dances.problems, *invalid]
    if scene is None or problems:
        raise SceneError(in_order(problems, [file, *search.files, *dances.files]))
    return scene.standing_in(tree)


def _refuse_newer(tree: Table) -> None:
    """Refuse a file in a later version of the language, before its new words are called wrong.

    Raises:
        SceneError: the version is newer than the one that is read here.
    """
    version = tree.get("pronk")
    if isinstance(version, Leaf) and type(version.value) is int and version.value > VERSION:
        message = f"this pronk reads version {VERSION} of the language, not {version.value}"
        raise SceneError([version.place.problem(("pronk",), message)])


def _merged(problems: list[Problem], more: list[Problem]) -> list[Problem]:
    """Add problems where there was none yet."""
    known = {(p.file, p.line, p.column, p.path) for p in problems}
    return problems + [p for p in more if (p.file, p.line, p.column, p.path) not in known]
