"""The sound section of a scene file."""

from __future__ import annotations

from collections.abc import Callable

from pydantic import AfterValidator, BaseModel, ConfigDict


class AudioConfig(BaseModel):
    """Base of the models: immutable, known keys only, finite numbers only."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


def checked_by(parse: Callable[[str], object]) -> AfterValidator:
    """Return a validator that keeps a text if it can be parsed."""

    def check(text: str) -> str:
        parse(text)
        return text

    return AfterValidator(check)
