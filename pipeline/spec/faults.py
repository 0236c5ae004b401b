"""What a model finds wrong between its own words, each with its place below the model."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import islice

from pydantic_core import PydanticCustomError

Step = str | int
"""A key of a mapping or an index of a list."""

FAULTS = "faults"
"""Type of the pydantic error that carries faults."""

MOST_FAULTS = 100
"""Nobody reads more at once, and looking for near names takes its time."""


@dataclass(frozen=True, slots=True)
class Fault:
    """One thing that is wrong below a model.

    Attributes:
        path: keys and indices from the model down to what is wrong.
        message: what is wrong and what would be right.
        at_key: the key is wrong, not its value.
    """

    path: tuple[Step, ...]
    message: str
    at_key: bool = False


def refuse(faults: Iterable[Fault]) -> None:
    """Raise all faults as one error of pydantic, if there are any.

    Raises:
        PydanticCustomError: there is at least one fault.
    """
    found = tuple(islice(faults, MOST_FAULTS))
    if found:
        text = "; ".join(fault.message for fault in found)
        raise PydanticCustomError(FAULTS, "{text}", {"text": text, "faults": found})


def fault(message: str, *path: Step, at_key: bool = False) -> PydanticCustomError:
    """Return one fault as an error of pydantic, to be raised."""
    context = {"text": message, "faults": (Fault(path, message, at_key),)}
    return PydanticCustomError(FAULTS, "{text}", context)
