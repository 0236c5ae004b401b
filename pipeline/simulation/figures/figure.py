"""Figure: words -> all that a creature of that figure shares with others like it."""

from __future__ import annotations

from dataclasses import dataclass

from pipeline.errors import Problem, SceneError
from pipeline.simulation.figures.drawing import Drawing, draw
from pipeline.simulation.figures.network import Anatomy, analyse
from pipeline.simulation.figures.skeleton import Skeleton, build_skeleton
from pipeline.spec.figure import Figure as Words


@dataclass(frozen=True, eq=False)
class Figure:
    """A figure at a certain scale.

    Attributes:
        name: as the cast calls it.
        material: of links that name none; empty for the performer's own.
        scale: factor from the drawing to the world.
        drawing: the flat network, unscaled.
        anatomy: its parts.
        skeleton: joints and links, scaled.
    """

    name: str
    material: str
    scale: float
    drawing: Drawing
    anatomy: Anatomy
    skeleton: Skeleton


def build_figure(name: str, words: Words, scale: float) -> Figure:
    """Carry out the drawing, analyse it and build its skeleton.

    Raises:
        SceneError: if the drawing is no figure; its paths begin with `figures.<name>`.
    """
    drawing = draw(words)
    try:
        anatomy = analyse(drawing, words.parts)
    except SceneError as error:
        raise SceneError(
            [Problem(f"figures.{name}.{p.path}", p.message) for p in error.problems]
        ) from None
    skeleton = build_skeleton(drawing, anatomy, scale)
    return Figure(name, words.material or "", scale, drawing, anatomy, skeleton)
