"""Record array: structured arrays whose rows have their fields as attributes in plain Python too.

NumPy's `recarray` offers the same, but looks every attribute up in Python, which costs 2 µs a
field, and has to be examined anew by each call of compiled code. Here a row is an instance of a
class made for its fields, in which each is a property.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from operator import itemgetter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.compiled import Records

LINE = 64
"""Bytes that processors read from memory at once."""


def cache_lines(fields: Sequence[Any]) -> np.dtype[Any]:
    """Returns the data type of records with these fields, one behind the other, in whole lines.

    What is used together should stand together: of a record only the lines that are used are read.
    """
    kind = np.dtype([*fields], align=True)
    assert kind.names is not None
    assert kind.fields is not None
    return np.dtype(
        {
            "names": list(kind.names),
            "formats": [kind.fields[name][0] for name in kind.names],
            "offsets": [kind.fields[name][1] for name in kind.names],
            "itemsize": -(-kind.itemsize // LINE) * LINE,
        },
        align=True,
    )


def zero_records(count: int, kind: np.dtype[Any]) -> Records:
    """Returns `count` records of zeros, the first at the start of a line."""
    memory = np.zeros(count * kind.itemsize + LINE, dtype=np.uint8)
    start = -memory.ctypes.data % LINE
    return memory[start : start + count * kind.itemsize].view(_with_attributes(kind))


def records_of_array(values: NDArray[Any]) -> Records:
    """Returns a structured array, of the same memory, as records."""
    return values.view(_with_attributes(values.dtype))


@cache
def _with_attributes(kind: np.dtype[Any]) -> np.dtype[Any]:
    """Returns a data type whose scalars have the fields of a structured one as properties."""
    names = (name for name in kind.names or () if not hasattr(np.void, name))
    fields = {name: _field(name) for name in names}
    return np.dtype((type("Record", (np.void,), {"__slots__": (), **fields}), kind))


def _field(name: str) -> property:
    def put(record: Any, value: object) -> None:
        record[name] = value

    return property(itemgetter(name), put)
