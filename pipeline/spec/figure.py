"""Figure: the drawing of a jointed figure, flat as on a dissection table (Sims, chapter 4).

x points right and y towards the tail, so that the head has negative y [m].
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator
from pydantic.annotated_handlers import GetJsonSchemaHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from pipeline.spec.model_base import (
    ConfigModel,
    Coordinate,
    Fault,
    Length,
    LengthOrZero,
    MaterialName,
    Name,
    Number,
    Point,
    Positive,
    raise_faults,
)
from pipeline.spec.operations import Operation, carry_out
from pipeline.spec.operations.drawing import MAX_NODES, Mark, Sheet, faults_of_chain
from pipeline.spec.skin import Skin
from pipeline.spec.suggestions import hint

PartKind = Literal["leg", "arm", "head", "tail", "feeler", "horn", "wing", "body"]
Feet = Literal["plain", "claws", "hooves", "paws", "toes"]
LinkShape = Literal["round", "straight", "box", "plate", "ball"]

MAX_DENSITY = 100_000.0
"""About four times the density of the densest metals [kg/m³]."""

MAX_MASS = 1e9
"""Of a limb: far more than any animal weighs [kg]."""

SNAP_FRACTION = 1e-3
"""Default distance at which nodes snap to an axis, as a fraction of the drawing's size."""


class Node(ConfigModel):
    """A node of the drawing: `[x, y]`, or a mapping with more keys."""

    at: Point = Field(description="Position, x to the right and y towards the tail [m].")
    radius: Length | None = Field(
        None, description="Radius of the links here [m]; the figure's if left out."
    )
    material: MaterialName | None = Field(
        None, description="Material of the links that end here; the figure's if left out."
    )
    shape: LinkShape = Field(
        "round",
        description="Shape of the links that end here; round: swelling like a limb; straight: a "
        "plain cone; box: a bar; plate: flat in the plane of the drawing; ball: a ball around "
        "the node, on a stem if need be.",
    )
    width: Positive = Field(1.0, le=5, description="Width of an animal's skin here, in the radius.")
    height: Positive = Field(
        1.0, le=5, description="Height of an animal's skin here, in the radius."
    )
    lift: Annotated[Number, Field(ge=-3, le=3)] = Field(
        0.0, description="How far the middle of the skin lies above the node, in the radius."
    )

    @model_validator(mode="before")
    @classmethod
    def _written_out(cls, words: Any) -> Any:
        return {"at": words} if isinstance(words, list | tuple) else words

    @classmethod
    def __get_pydantic_json_schema__(
        cls, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        full = handler.resolve_ref_schema(handler(core))
        return {"anyOf": [full["properties"]["at"], full]}


class Figure(ConfigModel):
    """A drawing: nodes, the chains that connect them, and operations on both."""

    style: Literal["insect", "mammal"] = Field(
        "insect",
        description="Default joint axes; insect: legs spread, knees up; mammal: legs folded down.",
    )
    pitch_deg: Annotated[Number, Field(ge=-90, le=90)] = Field(
        0.0,
        description="How far a mammal's body is raised at its front: 0 as a horse's, 90 as a "
        "person's [degrees].",
    )
    nodes: dict[Name, Node] = Field(
        min_length=1,
        max_length=MAX_NODES,
        description="Nodes by name; [x, y] is short for {at: [x, y]}.",
    )
    chains: tuple[tuple[Name, ...], ...] = Field(
        (), description="Lists of nodes; each node is connected to the next in its list."
    )
    sticky: LengthOrZero | None = Field(
        None,
        description="A node no farther than this from an axis of the drawing is put on it [m]; "
        "a thousandth of the drawing's size if left out.",
    )
    then: Annotated[tuple[Operation, ...], Field(max_length=1000)] = Field(
        (), description="Operations on nodes and connections, done in this order."
    )
    parts: dict[Name, PartKind] = Field(
        {},
        description="What an appendage is, by its tip node, where the analysis guesses wrong; or "
        "`body`: all from the body to this node, which need not be a tip, is body.",
    )
    radius: Length | None = Field(
        None, description="Radius of links whose nodes give none [m]; chosen if left out."
    )
    joints: dict[Name, dict[Name, JointSettings]] = Field(
        {},
        description="Joints that are not as their style makes them: by limb, such as l1 or head, "
        "and by joint, such as base_pitch or joint1_bend.",
    )
    material: MaterialName | None = Field(
        None, description="Material of parts that name none, by name."
    )
    feet: Feet | None = Field(
        None,
        description="Ends of the legs, drawn without mass. Claws if left out for an "
        "insect, plain for a mammal.",
    )
    eyes: bool = Field(True, description="Whether its head has eyes.")
    jaws: bool | None = Field(
        None,
        description="Whether its head ends in two jaws, which are seen and weigh nothing; an "
        "insect's does if left out.",
    )
    skin: Skin | None = Field(
        None, description="The rendered surface; what suits style and feet if left out."
    )
    density: Annotated[Positive, Field(le=MAX_DENSITY)] = Field(
        1000.0, description="Mass of the visible solids by volume [kg/m³]; water's if left out."
    )
    masses: dict[Name, Annotated[Positive, Field(le=MAX_MASS)]] = Field(
        {},
        description="Masses that are not by volume: by limb, such as l1 or head, or of the body, "
        "at the size in which the figure is drawn [kg].",
    )

    @model_validator(mode="after")
    def _names_fit(self) -> Self:
        raise_faults(_faults_of_figure(self))
        return self

    def sheet(self) -> Sheet:
        """Return the drawing after all chains and operations."""
        return carry_out(self.then, _first_sheet(self))[0]


def _first_sheet(figure: Figure) -> Sheet:
    """Return the drawing before its operations, with the chains that are right."""
    xs, ys = zip(*(node.at for node in figure.nodes.values()), strict=True)
    extent = max(max(xs) - min(xs), max(ys) - min(ys))
    sticky = SNAP_FRACTION * extent if figure.sticky is None else figure.sticky
    marks = {name: Mark(node.at, name) for name, node in figure.nodes.items()}
    pairs = (pair for chain in figure.chains for pair in itertools.pairwise(chain))
    drawn = Sheet({}, sticky=sticky, extent=extent).with_marks(marks)
    return drawn.with_connections((a, b) for a, b in pairs if a != b and a in marks and b in marks)


def _faults_of_figure(figure: Figure) -> Iterator[Fault]:
    sheet = _first_sheet(figure)
    for i, chain in enumerate(figure.chains):
        yield from faults_of_chain(chain, sheet, ("chains", i))
    sheet, faults = carry_out(figure.then, sheet)
    for fault in faults:
        yield Fault(("then", *fault.path), fault.message, fault.at_key)
    for tip in figure.parts:
        if tip not in sheet.marks:
            message = f"no node is called '{tip}', {hint(tip, sheet.marks)}"
            yield Fault(("parts", tip), message, at_key=True)
    for i, lump in enumerate(figure.skin.lumps if figure.skin else ()):
        if lump.node not in sheet.marks:
            message = f"no node is called '{lump.node}', {hint(lump.node, sheet.marks)}"
            yield Fault(("skin", "lumps", i, "node"), message)


Angle = Annotated[Number, Field(ge=-180, le=180)]


class JointSettings(ConfigModel):
    """A joint with its limits and rest value; it turns, or slides along its link."""

    rest_deg: Angle | None = Field(None, description="Value at rest [degrees].")
    limits_deg: tuple[Angle, Angle] | None = Field(
        None, description="Least and greatest value [degrees]."
    )
    slide: tuple[Coordinate, Coordinate] | None = Field(
        None, description="Makes it slide along its link, between these values [m]."
    )
    rest: Coordinate | None = Field(None, description="Value at rest of a joint that slides [m].")

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        faults = []
        for name in ("limits_deg", "slide"):
            limits = getattr(self, name)
            if limits is not None and limits[0] >= limits[1]:
                faults.append(Fault((name,), "the first must be less than the second"))
        if self.slide is not None and (self.rest_deg is not None or self.limits_deg is not None):
            faults.append(Fault(("slide",), "conflicts with angles; write rest"))
        if self.slide is None and self.rest is not None:
            faults.append(Fault(("rest",), "belongs to joints that slide; write rest_deg"))
        raise_faults(faults)
        return self
