"""Scene check: everything that can be known of a scene without simulating it through."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from pipeline.errors import Problem
from pipeline.production.camera.parent_nodes import camera_parents, focus_nodes
from pipeline.simulation.figure_analysis import Figure, build_figure, check_figure
from pipeline.simulation.node_names import NodeNames
from pipeline.simulation.simulate import Simulation
from pipeline.spec import Scene


def check_scene(scene: Scene) -> str:
    """Build the scene's world with its cast in place and return a summary in one line.

    Raises:
        PronkError: a figure is wrong, or a performer cannot start its part.
    """
    simulation = Simulation(scene)
    names = NodeNames.joined(simulation.recorder.nodes, simulation.aliases)
    camera_parents(scene, names)
    focus_nodes(scene, names)
    ground = simulation.world.ground
    width, height = scene.film.resolved().size
    length = f"{scene.n_frames} frames at {scene.fps} a second, {width}x{height}"
    cast = ", ".join(f"{member.name} ({member.kind_name})" for member in scene.cast)
    return f"right: {length}; {cast}; {100 * ground.forbidden.mean():.0f}% of the ground forbidden"


@dataclass(frozen=True, slots=True)
class FigureRemark:
    """A remark on a figure.

    Attributes:
        problem: the remark at its place.
        is_fault: whether it is likely a mistake.
    """

    problem: Problem
    is_fault: bool


def figure_remarks(scene: Scene) -> Iterator[FigureRemark]:
    """Yield remarks on the figures of a scene's creatures."""
    for name in dict.fromkeys(member.figure for _, member in scene.creatures):
        yield from remarks_on(scene, build_figure(name, scene.figures[name], 1.0))


def remarks_on(scene: Scene, figure: Figure) -> Iterator[FigureRemark]:
    """Yield remarks on one figure of a scene."""
    for remark in check_figure(figure):
        path = f"figures.{figure.name}.{figure.drawing.path_of(remark.node)}"
        problem = scene.source_map.with_location(Problem(path, remark.text))
        yield FigureRemark(problem, remark.is_fault)
