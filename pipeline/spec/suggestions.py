"""Suggestions for unknown names and keys: the close ones, and where all of them are listed."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from difflib import SequenceMatcher
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel, BeforeValidator
from pydantic.fields import FieldInfo

from pipeline.spec.model_base import PathSegment, fault_error

# Matching is quadratic: bounds on the names compared and on their lengths.
MAX_COMPARED = 500
MAX_NAME_LENGTH = 64

MIN_SIMILARITY = 0.6
"""Ratio of matching letters from which on a name is close."""

MAX_LISTED = 100
"""Of more known names the rest is counted."""

SIMILARITY_SPREAD = 0.08
"""Close names that are less similar than the best by more than this are left out."""

MIN_PART_LENGTH = 3
"""Shorter names are not looked for inside others [characters]."""


SYNONYMS: Mapping[str, str] = {
    **dict.fromkeys(("performers", "performer", "actors", "members"), "cast"),
    **dict.fromkeys(("ground", "landscape"), "terrain"),
    **dict.fromkeys(("instructions", "orders"), "script"),
    "length": "duration",
}
"""Other words for keys of a scene, which are spelt otherwise."""


def close_names(name: str, known: Iterable[str]) -> list[str]:
    """Return the known names close to `name`, the most similar first; case does not matter.

    Close are the name of which it is a synonym; where there is none, those in which a word begins
    like `name`, as in all pianos of the instruments for "piano"; else those that are spelt alike.
    """
    wanted, names = _folded(name), sorted(known)[:MAX_COMPARED]
    if SYNONYMS.get(wanted) in names and wanted not in names:
        return [SYNONYMS[wanted]]
    matcher = SequenceMatcher(b=wanted)
    similarity = dict.fromkeys(names, 0.0)
    for other in names:
        matcher.set_seq1(_folded(other))
        if matcher.quick_ratio() >= MIN_SIMILARITY:
            similarity[other] = matcher.ratio()
    close = [other for other in names if _has_word(_folded(other), wanted)]
    if not close:
        least = max(MIN_SIMILARITY, max(similarity.values(), default=0.0) - SIMILARITY_SPREAD)
        close = [other for other in names if similarity[other] >= least]
    return sorted(close, key=lambda other: -similarity[other])


def _has_word(text: str, start: str) -> bool:
    """Return whether a word of a folded text has this start; `_` and `-` part words too."""
    if len(start) < MIN_PART_LENGTH:
        return False
    return re.search(rf"(?<![^\W_]){re.escape(start)}", text) is not None


_UNCOUNTED = frozenset({"weather", "water", "haze", "scatter"})
"""Nouns of which the list bears the name as it is."""


def listed_as(noun: str) -> str:
    """Return what `pronk list` calls the names of a noun such as "material"."""
    return noun if noun in _UNCOUNTED or noun.endswith("s") else f"{noun}s"


def hint(name: str, known: Iterable[str], kind: str = "", own: Iterable[str] = ()) -> str:
    """Return the end of a message about an unknown name: the close names, or all of them.

    Args:
        name: the unknown name.
        known: names that it may be.
        kind: what `pronk list` calls the known names, empty if it does not list them.
        own: further names, of this file alone.
    """
    listed, own_names = sorted(set(known)), sorted(set(own))
    close = close_names(name, {*listed, *own_names})
    command = f"`pronk list {kind}` has all {len(listed)}"
    if close:
        question = f"did you mean {joined_choices(close)}?"
        return f"{question} {command}" if kind else question
    if not kind:
        names = sorted({*listed, *own_names})
        return f"known: {_enumerated(names)}" if names else "there are none"
    return f"known here: {_enumerated(own_names)}; {command}" if own_names else command


def decided_by_key(
    forms: Collection[str], noun: str, kind: str = "", known: Iterable[str] = ()
) -> BeforeValidator:
    """Return a validator that refuses a mapping with none of the keys that decide what it is.

    Args:
        forms: these keys.
        noun: what they are called in messages, such as "order".
        kind: what `pronk list` calls them, empty if it does not list them.
        known: names that it lists, if they are not the keys.
    """

    def check(value: Any) -> Any:
        if not isinstance(value, Mapping) or any(key in value for key in forms):
            return value
        for key in value:
            if close_names(str(key), forms) or len(value) == 1:
                near = hint(str(key), known or forms, kind)
                message = f"no {noun} is called '{key}', {near}"
                raise fault_error(message, str(key), at_key=True)
        raise fault_error(f"needs one of the keys {', '.join(forms)}")

    return BeforeValidator(check)


def _enumerated(names: list[str]) -> str:
    more = len(names) - MAX_LISTED
    return ", ".join(names[:MAX_LISTED]) + (f" and {more} more" if more > 0 else "")


def joined_choices(names: Iterable[str]) -> str:
    """Return names as text: "'a', 'b' or 'c'"."""
    *others, last = [f"'{name}'" for name in names]
    return f"{', '.join(others)} or {last}" if others else last


def _folded(name: str) -> str:
    return name.casefold()[:MAX_NAME_LENGTH]


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
    fitting = [kind for kind in models if tag == kind.__name__ or tag in _tags(kind)]
    return fitting or kinds


def _tags(kind: type[BaseModel]) -> set[Any]:
    """Return the values of fields that can have but one; others are choices of an author."""
    literals = [
        get_args(field.annotation)
        for field in kind.model_fields.values()
        if get_origin(field.annotation) is Literal
    ]
    return {values[0] for values in literals if len(values) == 1}


def _is_model(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, BaseModel)
