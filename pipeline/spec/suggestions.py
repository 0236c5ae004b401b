"""Suggestions for unknown names and keys: the nearest known one, or all of them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from difflib import get_close_matches
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from pipeline.spec.model_base import PathSegment

# Matching is quadratic: bounds on what is listed, on the names compared and on their lengths.
MAX_LISTED = 12
MAX_COMPARED = 500
MAX_NAME_LENGTH = 64


def nearest(name: str, known: Iterable[str]) -> str | None:
    """Return the known name closest to `name`, or None where none is close."""
    names = sorted(known, reverse=True)[:MAX_COMPARED]
    by_fold = {other.casefold()[:MAX_NAME_LENGTH]: other for other in names}
    close = get_close_matches(name.casefold()[:MAX_NAME_LENGTH], by_fold, n=1, cutoff=0.6)
    return by_fold[close[0]] if close else None


def hint(name: str, known: Iterable[str]) -> str:
    """Return the end of a message about an unknown name: the nearest name, or all known ones."""
    names = sorted(known)
    close = nearest(name, names)
    if close is not None:
        return f"did you mean '{close}'?"
    if not names:
        return "there are none"
    listed = ", ".join(names[:MAX_LISTED])
    return f"known: {listed}" + (", ..." if len(names) > MAX_LISTED else "")


def known_keys(model: type[BaseModel], path: Iterable[PathSegment]) -> list[str]:
    """Return the keys that the models accept at a path of pydantic's.

    Args:
        model: the model at the root.
        path: keys, indices and tags of unions, as pydantic gives them.
    """
    here: list[Any] = [model]
    for step in path:
        # A step that leads nowhere is the tag of a union.
        here = [below for kind in here for below in _below(kind, step)] or _tagged(here, step)
    return sorted({key for kind in here if _is_model(kind) for key in _fields(kind)})


def _below(kind: Any, step: PathSegment) -> Iterator[Any]:
    """Yield the types that a key or index of a type leads to."""
    if _is_model(kind):
        if isinstance(step, str) and step in _fields(kind):
            yield from _alternatives(_fields(kind)[step].annotation)
        return
    arguments = get_args(kind)
    if get_origin(kind) is dict and isinstance(step, str):
        yield from _alternatives(arguments[1])
    elif get_origin(kind) in (tuple, list) and isinstance(step, int):
        for argument in arguments:
            if argument is not Ellipsis:
                yield from _alternatives(argument)


def _fields(kind: type[BaseModel]) -> dict[str, FieldInfo]:
    """Return the fields by the keys that authors write."""
    return {field.alias or name: field for name, field in kind.model_fields.items()}


def _alternatives(annotation: Any) -> Iterator[Any]:
    """Yield the members of a union, or the type itself; None is left out."""
    if get_origin(annotation) is Annotated:
        yield from _alternatives(get_args(annotation)[0])
    elif get_origin(annotation) in (Union, UnionType):
        for argument in get_args(annotation):
            yield from _alternatives(argument)
    elif annotation is not NoneType:
        yield annotation


def _tagged(kinds: list[Any], tag: PathSegment) -> list[Any]:
    """Return the models of a union that a tag selects."""
    models = [kind for kind in kinds if _is_model(kind)]
    fitting = [kind for kind in models if tag == kind.__name__ or tag in _literals(kind)]
    return fitting or kinds


def _literals(kind: type[BaseModel]) -> set[Any]:
    return {
        value
        for field in kind.model_fields.values()
        if get_origin(field.annotation) is Literal
        for value in get_args(field.annotation)
    }


def _is_model(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, BaseModel)
