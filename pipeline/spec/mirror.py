"""Mirror: copies of nodes on the other side of an axis of the drawing.

A copy is connected as its original is: to the copy of the other node where that is copied as
well, and to the other node itself where it is not.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Literal

from pydantic import Field, Strict

from pipeline.spec.faults import Fault
from pipeline.spec.nearest import hint
from pipeline.spec.values import Name, Words

ON_AXIS = 1e-9
"""A node no farther than this from the axis lies on it [m]."""

Axis = Literal["x", "y"]
At = tuple[float, float]


class Mirror(Words):
    """Copies nodes to the other side; what lies on the axis is not copied."""

    mirror: Axis = Field(
        description="The coordinate that changes its sign: x copies left to right, y front to back."
    )
    nodes: Annotated[tuple[Name, ...], Field(min_length=1)] | None = Field(
        None, description="The nodes to copy; all that do not lie on the axis if left out."
    )
    suffix: Annotated[str, Strict(), Field(pattern=r"^[\w\-]+$", max_length=16)] = Field(
        "_m",
        description="Ends the name of a copy, unless the name ends in _l or _r: those are swapped.",
    )


def mirrored_name(name: str, suffix: str = "_m") -> str:
    """Return the name of a node's copy: `_l` and `_r` are swapped, other names get the suffix."""
    if name.endswith("_l"):
        return name[:-2] + "_r"
    if name.endswith("_r"):
        return name[:-2] + "_l"
    return name + suffix


def mirrored_point(at: At, axis: Axis) -> At:
    """Return the place of a copy [m]."""
    x, y = at
    return (-x, y) if axis == "x" else (x, -y)


def copied_names(operation: Mirror, positions: Mapping[str, At]) -> dict[str, str]:
    """Return the names of the copies by their originals, in the order of the copying.

    Args:
        operation: what to do.
        positions: the nodes that there are before it [m].
    """
    names = _originals(operation, positions)
    return {name: mirrored_name(name, operation.suffix) for name in names}


def mirrored(operation: Mirror, positions: Mapping[str, At]) -> dict[str, At]:
    """Return the nodes after the operation: those before it, then the copies [m]."""
    return dict(positions) | {
        copy: mirrored_point(positions[name], operation.mirror)
        for name, copy in copied_names(operation, positions).items()
        if name in positions
    }


def faults_of_mirror(operation: Mirror, positions: Mapping[str, At]) -> Iterator[Fault]:
    """Find names that do not fit the nodes that there are before the operation."""
    made: set[str] = set()
    for i, name in enumerate(_originals(operation, positions)):
        copy = mirrored_name(name, operation.suffix)
        place = () if operation.nodes is None else ("nodes", i)
        if name not in positions:
            message = f"no node is called '{name}', {hint(name, positions)}"
        elif _on_axis(positions[name], operation.mirror):
            message = f"node '{name}' lies on the axis, its copy would lie on itself"
        elif copy in positions or copy in made:
            message = f"the copy of '{name}' would be called '{copy}', and there is one already"
            message += "; list the nodes to copy" if operation.nodes is None else ""
        else:
            made.add(copy)
            continue
        yield Fault(place, message)


def _originals(operation: Mirror, positions: Mapping[str, At]) -> tuple[str, ...]:
    if operation.nodes is not None:
        return operation.nodes
    return tuple(name for name in positions if not _on_axis(positions[name], operation.mirror))


def _on_axis(at: At, axis: Axis) -> bool:
    return abs(at[0 if axis == "x" else 1]) <= ON_AXIS
