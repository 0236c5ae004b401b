"""Operations: what the figure editor does to a drawing, as words done in their order.

Each is a model that is told apart by its first word, a function from sheet to sheet, and a
line in `OPERATIONS`.

Source: Sims 1987, 4.1 and A.1.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, get_args

from pydantic import BaseModel, BeforeValidator, Discriminator, Tag

from pipeline.spec.model_base import Fault, fault_error
from pipeline.spec.operations.copies import Copy, Mirror, Move, copy, mirror, move
from pipeline.spec.operations.drawing import Doing, Sheet, changed, faults_of_result
from pipeline.spec.operations.drawing_edits import Connect, Delete, connect, delete
from pipeline.spec.operations.node_selection import Select, select
from pipeline.spec.suggestions import hint

AnyOperation = Mirror | Copy | Move | Select | Delete | Connect


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of operation.

    Attributes:
        word: the key that it is told by.
        model: its words.
        do: carries it out.
    """

    word: str
    model: type[BaseModel]
    do: Doing


# A copy and a move may mirror, so they are looked for first.
OPERATIONS = (
    Kind("copy", Copy, copy),
    Kind("move", Move, move),
    Kind("select", Select, select),
    Kind("delete", Delete, delete),
    Kind("connect", Connect, connect),
    Kind("mirror", Mirror, mirror),
)
"""All operations."""

_DO = {kind.model: kind.do for kind in OPERATIONS}


def _kind_of(words: Any) -> str | None:
    """Return the name of an operation's model, which no key is called like."""
    if isinstance(words, get_args(AnyOperation)):
        return type(words).__name__
    if not isinstance(words, Mapping):
        return None
    return next((kind.model.__name__ for kind in OPERATIONS if kind.word in words), None)


def _says_what_to_do(words: Any) -> Any:
    known = [kind.word for kind in OPERATIONS]
    if _kind_of(words) is None:
        if not isinstance(words, Mapping):
            raise fault_error(f"should be a mapping with one of the keys {', '.join(known)}")
        for key in words:
            said = hint(str(key), known)
            if said.startswith("did") or len(words) == 1:
                raise fault_error(f"no operation is called '{key}', {said}", key, at_key=True)
        raise fault_error(f"needs one of the keys {', '.join(known)}")
    return words


Operation = Annotated[
    Annotated[
        Annotated[Copy, Tag("Copy")]
        | Annotated[Move, Tag("Move")]
        | Annotated[Select, Tag("Select")]
        | Annotated[Delete, Tag("Delete")]
        | Annotated[Connect, Tag("Connect")]
        | Annotated[Mirror, Tag("Mirror")],
        Discriminator(_kind_of),
    ],
    BeforeValidator(_says_what_to_do),
]


def carry_out(then: Sequence[AnyOperation], sheet: Sheet) -> tuple[Sheet, list[Fault]]:
    """Do operations in their order, each as far as it can be done.

    Args:
        then: the operations.
        sheet: the drawing before them.

    Returns:
        The drawing after them, and what is wrong, the number of the operation first in its path.
    """
    faults: list[Fault] = []
    for i, words in enumerate(then):
        after, wrong = _DO[type(words)](words, sheet)
        wrong = wrong or list(faults_of_result(sheet, after))
        faults += [Fault((i, *one.path), one.message, one.at_key) for one in wrong]
        sheet = after.made_by(i, changed(sheet, after))
    return sheet, faults


__all__ = [
    "OPERATIONS",
    "AnyOperation",
    "Connect",
    "Copy",
    "Delete",
    "Kind",
    "Mirror",
    "Move",
    "Operation",
    "Select",
    "Sheet",
    "carry_out",
]
