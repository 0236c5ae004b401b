"""Parent nodes: the nodes that carry cameras and lamps, and those that cameras focus on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pipeline.errors import Problem, SceneError
from pipeline.simulation.node_names import NodeNames
from pipeline.spec.scene import Scene
from render.config import Camera


def camera_parents(scene: Scene, names: NodeNames) -> list[int]:
    """Return the node that carries the camera of each cut, -1 for none.

    Args:
        scene: that defines the cameras.
        names: of the nodes of its take.

    Raises:
        SceneError: the parent of a camera does not exist.
    """
    return resolve_parents(scene, names, {path: cut.parent for path, cut in _cuts(scene)})


def resolve_parents(scene: Scene, names: NodeNames, parents: Mapping[str, str | None]) -> list[int]:
    """Return the node of each parent, -1 for none.

    Args:
        scene: that defines the children.
        names: of the nodes of its take.
        parents: names of parents by the path of the child in the scene; None for no parent.

    Raises:
        SceneError: a parent does not exist.
    """
    named = [(f"{path}.parent", parent) for path, parent in parents.items() if parent is not None]
    found = iter(_numbers(scene, names, named))
    return [-1 if parent is None else next(found) for parent in parents.values()]


def focus_nodes(scene: Scene, names: NodeNames) -> dict[str, int]:
    """Return the node of each link or node, such as bug.head, that a camera focuses on.

    Args:
        scene: that defines the cameras.
        names: of the nodes of its take.

    Raises:
        SceneError: the focus of a camera does not exist.
    """
    named = []
    for path, cut in _cuts(scene):
        given = [(f"{path}.focus", cut.focus)]
        given += [
            (f"{path}.keyframes[{k}].focus", key.focus) for k, key in enumerate(cut.keyframes)
        ]
        named += [(place, word) for place, word in given if isinstance(word, str) and "." in word]
    return {word: n for (_, word), n in zip(named, _numbers(scene, names, named), strict=True)}


def _cuts(scene: Scene) -> list[tuple[str, Camera]]:
    """Return the cuts with their paths in the scene."""
    if len(scene.camera) == 1:
        return [("camera", scene.camera[0])]
    return [(f"camera[{i}]", cut) for i, cut in enumerate(scene.camera)]


def _numbers(scene: Scene, names: NodeNames, named: Sequence[tuple[str, str]]) -> list[int]:
    """Return the numbers of the nodes `named` by (path in the scene, name)."""
    found = [(place, names.find(name)) for place, name in named]
    problems = [Problem(place, fault) for place, fault in found if isinstance(fault, str)]
    if problems:
        raise scene.source_map.with_locations(SceneError(problems))
    return [number for _, number in found if isinstance(number, int)]
