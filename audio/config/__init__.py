"""The sound section of a scene file."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from pydantic import AfterValidator, BaseModel, ConfigDict, Field


class AudioConfig(BaseModel):
    """Base of the models: immutable, known keys only, finite numbers only."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


def checked_by(parse: Callable[[str], object]) -> AfterValidator:
    """Return a validator that keeps a text if it can be parsed."""

    def check(text: str) -> str:
        parse(text)
        return text

    return AfterValidator(check)


def listed_in(kind: str) -> Any:
    """Return the metadata of a name that the JSON Schema marks as one of a kind."""
    return Field(json_schema_extra={"x-names": kind})
