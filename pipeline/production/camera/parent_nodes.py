"""Mounting: the nodes that cameras and lamps go along with, and those that are focused on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pipeline.errors import Problem, SceneError
from pipeline.simulation.node_names import NodeNames
from pipeline.spec.scene import Scene
from render.config import Camera


def mounts_of(scene: Scene, names: NodeNames) -> list[int]:
    """Return the node that the camera of each cut goes along with, -1 for none.

    Args:
        scene: whose cameras they are.
        names: of the nodes of its take.

    Raises:
        SceneError: a camera goes along with a part that nobody has.
    """
    return nodes_of(scene, names, {path: cut.parent for path, cut in _cuts(scene)})


def nodes_of(scene: Scene, names: NodeNames, parents: Mapping[str, str | None]) -> list[int]:
    """Return the node that each of several things goes along with, -1 for none.

    Args:
        scene: whose they are.
        names: of the nodes of its take.
        parents: by the path of the thing in the scene; None for what goes along with nobody.

    Raises:
        SceneError: something goes along with a part that nobody has.
    """
    named = [(f"{path}.parent", parent) for path, parent in parents.items() if parent is not None]
    found = iter(_numbers(scene, names, named))
    return [-1 if parent is None else next(found) for parent in parents.values()]


def sharp_nodes_of(scene: Scene, names: NodeNames) -> dict[str, int]:
    """Return the number of each link or node, as bug.head, that some camera focuses on.

    Args:
        scene: whose cameras they are.
        names: of the nodes of its take.

    Raises:
        SceneError: a camera focuses on a part that nobody has.
    """
    named = []
    for path, cut in _cuts(scene):
        said = [(f"{path}.focus", cut.focus)]
        said += [(f"{path}.keyframes[{k}].focus", key.focus) for k, key in enumerate(cut.keyframes)]
        named += [(place, word) for place, word in said if isinstance(word, str) and "." in word]
    return {word: n for (_, word), n in zip(named, _numbers(scene, names, named), strict=True)}


def _cuts(scene: Scene) -> list[tuple[str, Camera]]:
    """Return the cuts and where they stand in the scene."""
    if len(scene.camera) == 1:
        return [("camera", scene.camera[0])]
    return [(f"camera[{i}]", cut) for i, cut in enumerate(scene.camera)]


def _numbers(scene: Scene, names: NodeNames, named: Sequence[tuple[str, str]]) -> list[int]:
    """Return the numbers of nodes that are `named` in some places of the scene."""
    found = [(place, names.find(name)) for place, name in named]
    problems = [Problem(place, one) for place, one in found if isinstance(one, str)]
    if problems:
        raise scene.source_map.with_locations(SceneError(problems))
    return [one for _, one in found if isinstance(one, int)]
