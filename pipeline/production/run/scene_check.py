"""Checking: all that can be known of a scene without simulating it through."""

from __future__ import annotations

from collections.abc import Iterator

from pipeline.errors import Problem
from pipeline.production.camera.parent_nodes import mounts_of, sharp_nodes_of
from pipeline.simulation.figures.drawing import draw
from pipeline.simulation.figures.network import analyse
from pipeline.simulation.simulate import Simulation
from pipeline.spec import Scene


def check_scene(scene: Scene) -> str:
    """Build the scene's world and let everybody stand in it; return a line about it.

    Raises:
        PronkError: if a figure is none, or somebody cannot begin what it is asked to do.
    """
    simulation = Simulation(scene)
    mounts_of(scene, simulation.recorder.nodes)
    sharp_nodes_of(scene, simulation.recorder.nodes)
    ground = simulation.world.ground
    width, height = scene.film.resolved().size
    length = f"{scene.n_frames} frames at {scene.fps} a second, {width}x{height}"
    who = ", ".join(f"{member.name} ({member.called})" for member in scene.cast)
    return f"right: {length}; {who}; {100 * ground.forbidden.mean():.0f}% of the ground forbidden"


def remarks_on(scene: Scene) -> Iterator[Problem]:
    """Give what the authors of the scene's figures may not have meant, with its place."""
    for name in dict.fromkeys(member.figure for _, member in scene.creatures):
        words = scene.figures[name]
        drawing = draw(words)
        for remark in analyse(drawing, words.parts).warnings:
            path = f"figures.{name}.{drawing.path_of(remark.node)}"
            yield scene.places.placed(Problem(path, str(remark)))
