"""The keys that a place in a scene may have, read from the models."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from pipeline.spec.faults import Step


def known_keys(model: type[BaseModel], path: Iterable[Step]) -> list[str]:
    """Return the keys that the models know at a path of pydantic's.

    Args:
        model: the model at the root.
        path: keys, indices and tags of unions, as pydantic gives them.
    """
    here: list[Any] = [model]
    for step in path:
        # What leads nowhere is the tag of a union.
        here = [below for kind in here for below in _below(kind, step)] or _tagged(here, step)
    return sorted({key for kind in here if _is_model(kind) for key in _fields(kind)})


def _below(kind: Any, step: Step) -> Iterator[Any]:
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
    if get_origin(annotation) is Annotated:
        yield from _alternatives(get_args(annotation)[0])
    elif get_origin(annotation) in (Union, UnionType):
        for argument in get_args(annotation):
            yield from _alternatives(argument)
    elif annotation is not NoneType:
        yield annotation


def _tagged(kinds: list[Any], tag: Step) -> list[Any]:
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
