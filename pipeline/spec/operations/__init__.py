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
from pipeline.spec.suggestions import decided_by_key

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


def _require_mapping(value: Any) -> Any:
    """Refuse what has no keys."""
    if isinstance(value, DrawingOperation | Mapping):
        return value
    raise fault_error(f"should be a mapping with one of the keys {', '.join(OPERATIONS)}")


if TYPE_CHECKING:
    Operation = DrawingOperation
else:
    Operation = Annotated[
        keyed_union(OPERATIONS, default="Mirror"),
        decided_by_key(OPERATIONS, "operation"),
        BeforeValidator(_require_mapping),
    ]


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
