"""Figures: all that creatures of one figure share."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

from pipeline.errors import Problem, SceneError
from pipeline.simulation.figures.drawing import Drawing, draw
from pipeline.simulation.figures.link_shapes import SolidPiece, build_pieces
from pipeline.simulation.figures.network import Anatomy, analyse
from pipeline.simulation.figures.skeleton import Skeleton, build_skeleton, lay_out_nodes
from pipeline.simulation.figures.solids import BODY_FLATNESS, Solid, body_solid
from pipeline.simulation.spatial import Array
from pipeline.spec.figure import Figure as FigureConfig
from pipeline.spec.skin import Skin as SkinConfig
from pipeline.spec.suggestions import hint

DEFAULT_FEET = {"insect": "claws", "mammal": "plain"}
"""What legs end in by default, by style."""


@dataclass(frozen=True, eq=False)
class Figure:
    """A figure at a scale.

    Attributes:
        name: in the cast.
        material: of links that name none; empty for the performer's own.
        scale: factor from the drawing to the world.
        drawing: the flat network, unscaled.
        anatomy: its parts.
        points: (n, 3) nodes in the creation frame [m].
        style: insect or mammal.
        density: of its solids [kg/m³].
        feet: what legs end in.
        jaws: whether its head has jaws.
        eyes: whether it has eyes.
        skeleton: joints and links, scaled.
        skin: words for its rendered surface alone.
        masses: of limbs and the body whose density is another, at the drawing's size [kg].
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
    skin: SkinConfig = field(default_factory=SkinConfig)
    masses: Mapping[str, float] = field(default_factory=dict)

    @cached_property
    def body(self) -> Solid:
        """The body's surface, in the creation frame.

        Raises:
            SceneError: it is so thin that the polygonising grid misses it.
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
        """All solids, the body first."""
        return tuple(build_pieces(self.skeleton, self.drawing, self.anatomy, self.body, self.eyes))

    @property
    def belly(self) -> float:
        """Depth of the body below its frame [m]."""
        return -float(self.body.vertices[:, 1].min())


def build_figure(name: str, config: FigureConfig, scale: float) -> Figure:
    """Return a figure: drawing, anatomy and skeleton.

    Raises:
        SceneError: the drawing is not a figure; its paths start with `figures.<name>`.
    """
    drawing = draw(config)
    try:
        anatomy = analyse(drawing, config.parts, config.style, config.pitch_deg)
        points = lay_out_nodes(config, drawing, anatomy, scale)
        skeleton = build_skeleton(config, drawing, anatomy, points, scale)
        _check_masses(config.masses, skeleton)
    except SceneError as error:
        raise SceneError(
            [Problem(f"figures.{name}.{p.path}", p.message) for p in error.problems]
        ) from None
    material = config.material or ""
    return Figure(
        name,
        material,
        scale,
        drawing,
        anatomy,
        points,
        config.style,
        config.density,
        config.feet or DEFAULT_FEET[config.style],
        config.style == "insect" if config.jaws is None else config.jaws,
        config.eyes,
        skeleton,
        config.skin or SkinConfig(),
        config.masses,
    )


def _check_masses(masses: Mapping[str, float], skeleton: Skeleton) -> None:
    """Refuse masses of limbs that a figure lacks."""
    names = {link.limb: None for link in skeleton.links}
    problems = [
        Problem(f"masses.{name}", f"the figure has no such part, {hint(name, names)}")
        for name in masses
        if name not in names
    ]
    if problems:
        raise SceneError(problems)
