"""Request parameters of the methods, typed and validated as scenes are."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal, TypeVar, get_args

from pydantic import Field

from pipeline.errors import SceneError
from pipeline.spec.model_base import ConfigModel, Integer, Number
from pipeline.spec.validation import check
from pipeline.spec.yaml_tree import tree_of

ParamsModel = TypeVar("ParamsModel", bound=ConfigModel)

Count = Annotated[Integer, Field(ge=1, le=10**9)]
Names = Annotated[tuple[str, ...], Field(max_length=1000)]
Topic = Literal["time", "performers", "places", "poses", "channels", "notes"]


class HelloParams(ConfigModel):
    """Greeting; a port lets nobody in without it."""

    token: str | None = Field(None, description="Token of the port.")


class StepParams(ConfigModel):
    """Limits of a step; the first that is reached ends it."""

    steps: Count | None = Field(None, description="Number of world steps.")
    frames: Count | None = Field(None, description="Number of frames of the film.")
    until: Annotated[Number, Field(ge=0, le=1e6)] | None = Field(
        None, description="Time of the scene [s]."
    )
    event: Names = Field((), description="Kinds of events that end the step.")
    who: Names = Field((), description="Performers of these events; any if left out.")


class QueryParams(ConfigModel):
    """Topics and performers of a query."""

    what: Annotated[tuple[Topic, ...], Field(max_length=len(get_args(Topic)))] = Field(
        ("time", "places"), description="Topics."
    )
    who: Names = Field((), description="Performers; all if left out.")


class SubscribeParams(ConfigModel):
    """Events of a subscription, which replaces the one before."""

    events: Names = Field(description="Kinds of events; [] for none, ['*'] for all.")
    who: Names = Field((), description="Performers; any if left out.")


class EndParams(ConfigModel):
    """End of the film."""

    at: Literal["end", "now"] = Field("end", description="At the scene's end, or at this frame.")


def read_params(model: type[ParamsModel], params: Mapping[str, Any]) -> ParamsModel:
    """Return the validated parameters of a request.

    Raises:
        SceneError: with every problem found.
    """
    values, problems = check(model, tree_of(params))
    if values is None:
        raise SceneError(problems)
    return values
