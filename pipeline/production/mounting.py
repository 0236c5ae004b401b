"""Mounting: the nodes that cameras and lamps go along with."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pipeline.errors import Problem, SceneError
from pipeline.simulation.attaching import number_of
from pipeline.simulation.figures.figure import build_figure
from pipeline.simulation.take import Node
from pipeline.spec.scene import Scene


def mounts_of(scene: Scene, nodes: Sequence[Node]) -> list[int]:
    """Return the node that the camera of each cut goes along with, -1 for none.

    Args:
        scene: whose cameras they are.
        nodes: of its take.

    Raises:
        SceneError: a camera goes along with a part that nobody has.
    """
    alone = len(scene.camera) == 1
    cuts = {"camera" if alone else f"camera[{i}]": cut for i, cut in enumerate(scene.camera)}
    return nodes_of(scene, nodes, {path: cut.parent for path, cut in cuts.items()})


def nodes_of(scene: Scene, nodes: Sequence[Node], parents: Mapping[str, str | None]) -> list[int]:
    """Return the node that each of several things goes along with, -1 for none.

    Args:
        scene: whose they are.
        nodes: of its take.
        parents: by the path of the thing in the scene; None for what goes along with nobody.

    Raises:
        SceneError: something goes along with a part that nobody has.
    """
    numbers = {node.name: i for i, node in enumerate(nodes)}
    wanted = {parent.partition(".")[0] for parent in parents.values() if parent is not None}
    figures = {
        member.name: build_figure(member.figure, scene.figures[member.figure], member.scale)
        for _, member in scene.creatures
        if member.name in wanted
    }
    found, problems = [], []
    for path, parent in parents.items():
        number = -1 if parent is None else number_of(parent, figures, numbers)
        if isinstance(number, str):
            problems.append(Problem(f"{path}.parent", number))
            number = -1
        found.append(number)
    if problems:
        raise scene.places.located(SceneError(problems))
    return found
