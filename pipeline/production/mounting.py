"""Mounting: the nodes that cameras go along with."""

from __future__ import annotations

from collections.abc import Sequence

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
    numbers = {node.name: i for i, node in enumerate(nodes)}
    wanted = {cut.parent.partition(".")[0] for cut in scene.camera if cut.parent is not None}
    figures = {
        member.name: build_figure(member.figure, scene.figures[member.figure], member.scale)
        for _, member in scene.creatures
        if member.name in wanted
    }
    mounts, problems = [], []
    for i, cut in enumerate(scene.camera):
        found = -1 if cut.parent is None else number_of(cut.parent, figures, numbers)
        if isinstance(found, str):
            cut_path = "camera" if len(scene.camera) == 1 else f"camera[{i}]"
            problems.append(Problem(f"{cut_path}.parent", found))
            found = -1
        mounts.append(found)
    if problems:
        raise scene.places.located(SceneError(problems))
    return mounts
