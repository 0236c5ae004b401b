"""Checks a tree against a model and leads every error back to its place in the file."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeVar

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from pipeline.errors import Problem
from pipeline.spec.faults import FAULTS, Fault, Step
from pipeline.spec.keys import known_keys
from pipeline.spec.messages import described, message, wanted
from pipeline.spec.nearest import hint
from pipeline.spec.tree import Place, Row, Table, Tree, has_refused, plain

Model = TypeVar("Model", bound=BaseModel)

MOST_ERRORS = 300
"""Errors of one file that are led back; a file with more is no scene at all."""

_KEY = "[key]"
"""Ends pydantic's path to a key that is wrong."""


@dataclass(frozen=True, slots=True)
class Spot:
    """A path led back to the tree.

    Attributes:
        path: the steps that are found in the tree, and a last one that is missing there.
        tree: what stands there, or where it is missing.
        key: place of the key that leads there.
        skipped: number of steps of the union that pydantic was in, 0 outside of unions.
    """

    path: tuple[Step, ...]
    tree: Tree
    key: Place
    skipped: int = 0


@dataclass(frozen=True, slots=True)
class _Found:
    spot: Spot
    message: str
    wanted: str | None = None
    at_key: bool = False
    missing: bool = False

    @property
    def place(self) -> Place:
        return self.spot.key if self.at_key else self.spot.tree.place

    def problem(self) -> Problem:
        return self.place.problem(self.spot.path, self.message)


def check(model: type[Model], tree: Tree) -> tuple[Model | None, list[Problem]]:
    """Make a model of a tree.

    Args:
        model: what it should become.
        tree: what the file holds.

    Returns:
        The model, None if something is wrong, and the problems in no certain order.
    """
    try:
        return model.model_validate(plain(tree), strict=True), []
    except ValidationError as error:
        details = _last_missing(error.errors(include_url=False)[:MOST_ERRORS])
    found = [one for detail in details for one in _found(model, tree, detail)]
    return None, problems_of(_without_refused(_merged(found)))


def problems_of_faults(tree: Tree, faults: Iterable[Fault]) -> list[Problem]:
    """Return the problems that faults below the root stand for."""
    return problems_of(_without_refused(_of_fault(tree, (), fault) for fault in faults))


def problems_of(found: Iterable[_Found]) -> list[Problem]:
    """Return one problem for each place: the first that was found there."""
    first: dict[tuple[str, int, int, tuple[Step, ...]], Problem] = {}
    for one in found:
        place = one.place
        first.setdefault((place.file, place.line, place.column, one.spot.path), one.problem())
    return list(first.values())


def in_order(problems: Iterable[Problem], files: Sequence[str]) -> list[Problem]:
    """Sort problems as the files and their lines stand; each is kept once."""
    order = {file: i for i, file in enumerate(files)}
    unique = list(dict.fromkeys(problems))
    return sorted(unique, key=lambda p: (order.get(p.file, len(order)), p.line, p.column))


def locate(tree: Tree, path: Sequence[Step]) -> Spot:
    """Lead a path of pydantic's back to the tree; its tags of unions lead nowhere."""
    here, key = tree, tree.place
    steps: list[Step] = []
    skipped = 0
    for step in path:
        if isinstance(here, Table) and isinstance(step, str) and step in here.entries:
            entry = here.entries[step]
            here, key = entry.value, entry.key
        elif isinstance(here, Row) and isinstance(step, int) and step < len(here.items):
            here = here.items[step]
            key = here.place
        else:
            skipped += 1
            continue
        steps.append(step)
    return Spot(tuple(steps), here, key, skipped)


def _found(model: type[BaseModel], tree: Tree, error: ErrorDetails) -> list[_Found]:
    path, kind = error["loc"], error["type"]
    if kind == FAULTS:
        return [_of_fault(tree, path, fault) for fault in error["ctx"]["faults"]]
    if path and path[-1] == _KEY:
        spot = locate(tree, path[:-1])
        return [_Found(spot, message(error, path[-2]), at_key=True)]
    spot = locate(tree, path)
    if kind == "extra_forbidden":
        known = known_keys(model, path[:-1])
        return [_Found(spot, f"unknown key, {hint(str(path[-1]), known)}", at_key=True)]
    if kind == "missing":
        return [_missing(spot, path)]
    if kind == "union_tag_invalid":
        spot = locate(tree, (*path, str(error["ctx"]["discriminator"]).strip("'")))
    if kind == "too_short" and len(plain(spot.tree)) >= error["ctx"]["min_length"]:
        # Pydantic counts only the values that are right; the others are reported.
        return []
    return [_Found(spot, message(error, plain(spot.tree)), wanted(error))]


def _last_missing(details: Sequence[ErrorDetails]) -> Iterator[ErrorDetails]:
    """Keep of the values that a list lacks only the last, whose index says how many there are."""
    last = {one["loc"][:-1]: one for one in details if _lacks_value(one)}
    return (one for one in details if not _lacks_value(one) or last[one["loc"][:-1]] is one)


def _lacks_value(error: ErrorDetails) -> bool:
    return error["type"] == "missing" and isinstance(error["loc"][-1], int)


def _missing(spot: Spot, path: Sequence[Step]) -> _Found:
    last = path[-1]
    if isinstance(last, int):
        length = len(spot.tree.items) if isinstance(spot.tree, Row) else 0
        return _Found(spot, f"must hold {last + 1} values, holds {length}")
    if isinstance(spot.tree, Table):
        return _Found(Spot((*spot.path, last), spot.tree, spot.key), "is missing", missing=True)
    return _Found(spot, f"should be a mapping that has '{last}'")


def _of_fault(tree: Tree, path: Sequence[Step], fault: Fault) -> _Found:
    spot = locate(tree, (*path, *fault.path))
    return _Found(spot, fault.message, at_key=fault.at_key)


def _merged(found: Sequence[_Found]) -> list[_Found]:
    """Say once what a value should be, where each branch of a union says its own."""
    # A branch that went deeper into the value knows better what is wrong.
    deeper = {one.spot.path[:n] for one in found for n in range(len(one.spot.path))}
    rights: dict[tuple[Step, ...], dict[str, None]] = {}
    for one in found:
        if one.wanted:
            rights.setdefault(one.spot.path, {})[one.wanted] = None
    merged = []
    for one in found:
        right = rights.get(one.spot.path, {})
        if not (one.wanted and one.spot.skipped):
            merged.append(one)
        elif one.spot.path not in deeper:
            text = f"should be {' or '.join(right)}, is {described(plain(one.spot.tree))}"
            merged.append(_Found(one.spot, text if len(right) > 1 else one.message))
    return merged


def _without_refused(found: Iterable[_Found]) -> list[_Found]:
    """Leave out what follows from a value that was refused when the file was read."""
    return [
        one
        for one in found
        if one.at_key or one.missing or not one.spot.path or not has_refused(one.spot.tree)
    ]
