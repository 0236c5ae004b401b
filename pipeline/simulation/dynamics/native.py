"""Native: what compiled code sees of MuJoCo's own memory, and how MuJoCo calls it.

MuJoCo calls back between finding and solving contacts. A callback in Python costs more than
a sub-step of a few bodies, so the callback is machine code that reads and writes MuJoCo's
structures where they are. Their layout is not assumed: it is looked up, once, in an instance
of which the bindings say what every value is and where every array begins.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator
from functools import cache
from typing import Any, NamedTuple

import numba
import numpy as np
from numba.core import cgutils
from numba.extending import intrinsic, overload
from numpy.typing import NDArray

from pipeline.simulation.dynamics.compiled import KEPT, Records

PAGE = 4096
"""Bytes that are looked at together."""

MOST = 2**20
"""Bytes of a structure in which values are looked for."""

FIELDS = ("dist", "pos", "frame", "friction", "dim", "geom", "efc_address")
"""Of a contact."""

COUNTS = ("ncon", "nefc")
"""Of the data: of contacts, and of their rows."""

ARRAYS = ("efc_KBIP", "efc_pos", "userdata")
"""Of the data, which become addresses."""


class Layout(NamedTuple):
    """Where MuJoCo keeps things.

    Attributes:
        data: an `MjData`: `COUNTS`, `time`, and addresses of `contact` and `ARRAYS`.
        contact: an `mjContact`.
    """

    data: np.dtype[np.void]
    contact: np.dtype[np.void]


@cache
def layout_of(mujoco: Any) -> Layout:
    """Find where this MuJoCo keeps things."""
    spec = mujoco.MjSpec()
    spec.nuserdata = 1
    for height in (0.0, 0.1, 0.2):
        body = spec.worldbody.add_body(pos=[0.0, height, 0.0])
        body.add_freejoint()
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.1, 0.0, 0.0])
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    begin, first = data._address, data.contact.dist.ctypes.data
    contact = _contact(data.contact, first)
    found = {"contact": (_find(begin, np.int64(first)), "i8")}
    for name in ARRAYS:
        found[name] = _find(begin, np.int64(getattr(data, name).ctypes.data)), "i8"
    data.time = 0.8127384645
    found["time"] = _find(begin, np.float64(data.time)), "f8"
    for name in COUNTS:
        before = getattr(data, name)
        setattr(data, name, 1234567891)
        found[name] = _find(begin, np.int32(1234567891)), "i4"
        setattr(data, name, before)
    return Layout(_dtype(found), contact)


def _contact(contact: Any, first: int) -> np.dtype[np.void]:
    fields = {}
    for name in FIELDS:
        values = getattr(contact, name)
        fields[name] = values.ctypes.data - first, (values.dtype.str[1:], values.shape[1:])
    return _dtype(fields, contact.dist.strides[0])


def _dtype(fields: dict[str, tuple[int, Any]], size: int | None = None) -> np.dtype[np.void]:
    words: dict[str, Any] = {
        "names": list(fields),
        "offsets": [offset for offset, _ in fields.values()],
        "formats": [kind for _, kind in fields.values()],
    }
    if size is not None:
        words["itemsize"] = size
    made: np.dtype[np.void] = np.dtype(words)  # type: ignore[call-overload]
    return made


def _find(begin: int, value: Any) -> int:
    """Return how far behind `begin` a value lies [bytes]."""
    for offset, values in _pages(begin, value.dtype):
        places = np.flatnonzero(values == value)
        if len(places):
            return offset + int(places[0]) * int(value.itemsize)
    raise RuntimeError("MuJoCo keeps its data where it is not looked for; another version?")


def _pages(begin: int, kind: Any) -> Iterator[tuple[int, NDArray[Any]]]:
    for offset in range(0, MOST, PAGE):
        yield offset, np.frombuffer(ctypes.string_at(begin + offset, PAGE), dtype=kind)


def array_at(address: int, count: int, kind: np.dtype[Any]) -> Records:
    """Return the array that begins at an address."""
    room = (ctypes.c_byte * (int(count) * kind.itemsize)).from_address(int(address))
    values: NDArray[Any] = np.frombuffer(room, dtype=kind)  # type: ignore[call-overload]
    return values.view(np.recarray) if kind.names else values


@intrinsic  # type: ignore[untyped-decorator]
def _pointer(context: Any, address: Any) -> Any:
    """Return an address as a pointer."""

    def generate(_: Any, builder: Any, signature: Any, values: Any) -> Any:
        return builder.inttoptr(values[0], cgutils.voidptr_t)

    return numba.types.voidptr(numba.types.intp), generate


@overload(array_at)  # type: ignore[untyped-decorator]
def _array_at(address: int, count: int, kind: Any) -> Callable[..., Any]:
    def made(address: int, count: int, kind: Any) -> Any:
        return numba.carray(_pointer(address), (count,), kind)

    return made


def native(function: Callable[[int, int], None]) -> Any:
    """Return machine code that is called with two addresses, by MuJoCo too."""
    if numba.config.DISABLE_JIT:
        return function
    nothing, address = numba.types.void, numba.types.intp
    made = numba.cfunc(nothing(address, address), cache=KEPT)(function)
    # The machine code lives as long as this does.
    result = made.ctypes
    result.made = made
    return result
