"""Figure: the drawing of a jointed figure, flat as on a dissection table (Sims, chapter 4).

x points right and y towards the tail, so that the head has negative y [m].
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator
from pydantic.annotated_handlers import GetJsonSchemaHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from pipeline.spec.faults import Fault, refuse
from pipeline.spec.joints import JointWords
from pipeline.spec.mirror import Mirror, faults_of_mirror, mirrored
from pipeline.spec.nearest import hint
from pipeline.spec.values import Length, Name, Number, Point, Words

PartKind = Literal["leg", "arm", "head", "tail", "feeler"]
Operation = Mirror


class Node(Words):
    """A node of the drawing: `[x, y]`, or a mapping that says more."""

    at: Point = Field(description="Position, x to the right and y towards the tail [m].")
    radius: Length | None = Field(
        None, description="Radius of the links here [m]; the figure's if left out."
    )
    material: Name | None = Field(
        None, description="Material of the links that end here; the figure's if left out."
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


class Figure(Words):
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
        max_length=1000,
        description="Nodes by name; [x, y] is short for {at: [x, y]}.",
    )
    chains: tuple[tuple[Name, ...], ...] = Field(
        (), description="Lists of nodes; each node is connected to the next in its list."
    )
    then: tuple[Operation, ...] = Field((), description="Operations, done in this order.")
    parts: dict[Name, PartKind] = Field(
        {}, description="What an appendage is, by its tip node, where the analysis guesses wrong."
    )
    radius: Length | None = Field(
        None, description="Radius of links whose nodes give none [m]; chosen if left out."
    )
    joints: dict[Name, dict[Name, JointWords]] = Field(
        {},
        description="Joints that are not as their style makes them: by limb, such as l1 or head, "
        "and by joint, such as base_pitch or joint1_bend.",
    )
    material: Name | None = Field(None, description="Material of parts that name none, by name.")

    @model_validator(mode="after")
    def _names_fit(self) -> Self:
        refuse(_faults_of_figure(self))
        return self


def _faults_of_figure(figure: Figure) -> Iterator[Fault]:
    positions: dict[str, Point] = {name: node.at for name, node in figure.nodes.items()}
    yield from _faults_of_chains(figure.chains, positions)
    for i, operation in enumerate(figure.then):
        for fault in faults_of_mirror(operation, positions):
            yield Fault(("then", i, *fault.path), fault.message)
        positions = mirrored(operation, positions)
    for tip in figure.parts:
        if tip not in positions:
            message = f"no node is called '{tip}', {hint(tip, positions)}"
            yield Fault(("parts", tip), message, at_key=True)


def _faults_of_chains(
    chains: tuple[tuple[str, ...], ...], positions: Mapping[str, Point]
) -> Iterator[Fault]:
    for i, chain in enumerate(chains):
        if len(chain) < 2:
            yield Fault(("chains", i), "a chain connects at least 2 nodes")
        for k, name in enumerate(chain):
            message = _fault_of_link(name, chain[k - 1] if k else None, positions)
            if message:
                yield Fault(("chains", i, k), message)


def _fault_of_link(name: str, before: str | None, positions: Mapping[str, Point]) -> str:
    if name not in positions:
        return f"no node is called '{name}', {hint(name, positions)}"
    if name == before:
        return f"node '{name}' is connected to itself"
    if before is not None and positions.get(before) == positions[name]:
        return f"nodes '{before}' and '{name}' are at the same place, so the link has no length"
    return ""
