"""Operations: what the figure editor does to a drawing, in the order in which they are listed.

A new operation is a model with `apply` and its line in `OPERATIONS`.

Source: Sims 1987, 4.1 and A.1.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BeforeValidator

from pipeline.spec.model_base import Fault, fault_error, keyed_union
from pipeline.spec.operations.drawing import (
    DrawingOperation,
    Sheet,
    changed_nodes,
    faults_of_result,
)
from pipeline.spec.operations.drawing_edits import Connect, Copy, Delete, Mirror, Move
from pipeline.spec.operations.node_selection import Select
from pipeline.spec.suggestions import hint

OPERATIONS: Mapping[str, type[DrawingOperation]] = {
    # A copy and a move may have the key mirror too, so their keys come first.
    "copy": Copy,
    "move": Move,
    "select": Select,
    "delete": Delete,
    "connect": Connect,
    "mirror": Mirror,
}
"""All operations by the key that selects them."""


def _require_key(value: Any) -> Any:
    """Raise a fault if a value is no mapping with the key of an operation."""
    if isinstance(value, DrawingOperation):
        return value
    known = ", ".join(OPERATIONS)
    if not isinstance(value, Mapping):
        raise fault_error(f"should be a mapping with one of the keys {known}")
    if not any(key in value for key in OPERATIONS):
        for key in value:
            suggestion = hint(str(key), OPERATIONS)
            if suggestion.startswith("did") or len(value) == 1:
                raise fault_error(f"no operation is called '{key}', {suggestion}", key, at_key=True)
        raise fault_error(f"needs one of the keys {known}")
    return value


if TYPE_CHECKING:
    Operation = DrawingOperation
else:
    Operation = Annotated[keyed_union(OPERATIONS, default="Mirror"), BeforeValidator(_require_key)]


def carry_out(operations: Sequence[DrawingOperation], sheet: Sheet) -> tuple[Sheet, list[Fault]]:
    """Apply operations in their order, each as far as possible.

    Args:
        operations: the operations.
        sheet: the drawing before them.

    Returns:
        The drawing after them, and the faults, whose paths begin with the index of the operation.
    """
    faults: list[Fault] = []
    for i, operation in enumerate(operations):
        after, found = operation.apply(sheet)
        found = found or list(faults_of_result(sheet, after))
        faults += [fault.below(i) for fault in found]
        sheet = after.made_by(i, changed_nodes(sheet, after))
    return sheet, faults
