"""Words: what requests say, typed and checked as scenes are."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal, TypeVar

from pydantic import Field

from pipeline.errors import SceneError
from pipeline.spec.model_base import ConfigModel, Integer, Number
from pipeline.spec.source_tree import tree_of
from pipeline.spec.validation import check

Said = TypeVar("Said", bound=ConfigModel)

Count = Annotated[Integer, Field(ge=1, le=10**9)]
Names = Annotated[tuple[str, ...], Field(max_length=1000)]
Topic = Literal["time", "performers", "places", "poses", "channels", "notes"]


class StepWords(ConfigModel):
    """How far to go on; the first of several that is reached."""

    steps: Count | None = Field(None, description="So many steps of the world.")
    frames: Count | None = Field(None, description="So many frames of the film.")
    until: Annotated[Number, Field(ge=0, le=1e6)] | None = Field(
        None, description="To this time of the scene [s]."
    )
    event: Names = Field((), description="Until one of these kinds of things happens.")
    who: Names = Field((), description="To whom; anybody if left out.")


class QueryWords(ConfigModel):
    """What to tell."""

    what: tuple[Topic, ...] = Field(("time", "places"), description="About what.")
    who: Names = Field((), description="About whom; everybody if left out.")


class SubscribeWords(ConfigModel):
    """What to tell of as it happens, from now on, instead of what was asked for before."""

    events: Names = Field(description="Kinds of things that happen; [] for none, ['*'] for all.")
    who: Names = Field((), description="To whom; anybody if left out.")


class EndWords(ConfigModel):
    """Where the film ends."""

    at: Literal["end", "now"] = Field("end", description="At the scene's end, or where it is now.")


def read(model: type[Said], params: Mapping[str, Any]) -> Said:
    """Return what a request says.

    Raises:
        SceneError: something is wrong with it; holds every problem found.
    """
    said, problems = check(model, tree_of(params))
    if said is None:
        raise SceneError(problems)
    return said
