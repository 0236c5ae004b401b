"""Figure: words -> all that a creature of that figure shares with others like it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from pipeline.errors import Problem, SceneError
from pipeline.simulation.figures.drawing import Drawing, draw
from pipeline.simulation.figures.figure_skin import FigureSkin, build_figure_skin
from pipeline.simulation.figures.link_shapes import SolidPiece, build_pieces
from pipeline.simulation.figures.network import Anatomy, analyse
from pipeline.simulation.figures.skeleton import Skeleton, build_skeleton, lay_out_nodes
from pipeline.simulation.figures.solids import BODY_FLATNESS, Solid, body_solid
from pipeline.simulation.spatial import Array
from pipeline.spec.figure import Figure as Words

DEFAULT_FEET = {"insect": "claws", "mammal": "plain"}
"""What legs end in where the words do not say it, by style."""


@dataclass(frozen=True, eq=False)
class Figure:
    """A figure at a certain scale.

    Attributes:
        name: as the cast calls it.
        material: of links that name none; empty for the performer's own.
        scale: factor from the drawing to the world.
        drawing: the flat network, unscaled.
        anatomy: its parts.
        points: (n, 3) the nodes in the creation frame [m].
        style: insect or mammal.
        density: mass of its solids by volume [kg/m³].
        feet: what legs end in.
        jaws: whether its head has jaws.
        eyes: whether it has eyes.
        skeleton: joints and links, scaled.
    """

    name: str
    material: str
    scale: float
    drawing: Drawing
    anatomy: Anatomy
    points: Array
    style: str
    density: float
    feet: str
    jaws: bool
    eyes: bool
    skeleton: Skeleton

    @cached_property
    def body(self) -> Solid:
        """The body's surface, in the creation frame.

        Raises:
            SceneError: it is so thin that the grid it is made on misses it.
        """
        nodes = list(self.anatomy.body)
        number = {node: i for i, node in enumerate(nodes)}
        bones = [(number[a], number[b]) for a, b in self.anatomy.bones]
        flatness = BODY_FLATNESS if self.style == "insect" else 1.0
        solid = body_solid(
            self.points[nodes], self.drawing.radii[nodes] * self.scale, bones, flatness
        )
        if not len(solid.faces):
            name = self.drawing.names[nodes[0]]
            message = f"the body is too thin for its length; give '{name}' a larger radius"
            raise SceneError([Problem(f"figures.{self.name}.nodes.{name}", message)])
        return solid

    @cached_property
    def pieces(self) -> tuple[SolidPiece, ...]:
        """All its visible solids, the body first."""
        return tuple(build_pieces(self.skeleton, self.drawing, self.anatomy, self.body, self.eyes))

    @cached_property
    def looks(self) -> FigureSkin:
        """What is seen in place of its pieces."""
        return build_figure_skin(self)

    @property
    def belly(self) -> float:
        """How deep the body reaches below its own frame [m]."""
        return -float(self.body.vertices[:, 1].min())


def build_figure(name: str, words: Words, scale: float) -> Figure:
    """Carry out the drawing, analyse it and build its skeleton.

    Raises:
        SceneError: if the drawing is no figure; its paths begin with `figures.<name>`.
    """
    drawing = draw(words)
    try:
        anatomy = analyse(drawing, words.parts)
        points = lay_out_nodes(words, drawing, anatomy, scale)
        skeleton = build_skeleton(words, drawing, anatomy, points, scale)
    except SceneError as error:
        raise SceneError(
            [Problem(f"figures.{name}.{p.path}", p.message) for p in error.problems]
        ) from None
    material = words.material or ""
    return Figure(
        name,
        material,
        scale,
        drawing,
        anatomy,
        points,
        words.style,
        words.density,
        words.feet or DEFAULT_FEET[words.style],
        words.style == "insect" if words.jaws is None else words.jaws,
        words.eyes,
        skeleton,
    )
