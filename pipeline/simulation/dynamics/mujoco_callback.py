"""MuJoCo callback: compiled code that reads and writes MuJoCo's memory between two of its stages.

MuJoCo calls back between finding and solving contacts. A callback in Python costs more than a
sub-step of a few bodies, so the callback is machine code that accesses MuJoCo's structures in
place. Their layout is not assumed: it is looked up, once, in an instance whose values and array
addresses the bindings report.
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

from pipeline.simulation.dynamics.compiled import Records, native
from pipeline.simulation.dynamics.impact_arrays import (
    LAW_STATE,
    PAIR,
    STRIKE,
    THING,
    ContactSet,
    ImpactLaw,
)
from pipeline.simulation.dynamics.impact_law import set_springs
from pipeline.simulation.dynamics.record_array import records_of_array

PAGE_BYTES = 4096
"""Bytes searched together."""

MAX_STRUCT_BYTES = 2**20
"""Bytes of a structure that are searched for values."""

CONTACT_FIELDS = ("dist", "pos", "frame", "friction", "dim", "geom", "efc_address")
"""Fields of a contact."""

COUNT_FIELDS = ("ncon", "nefc")
"""Fields of the data: numbers of contacts, and of their rows."""

ARRAY_FIELDS = ("efc_KBIP", "userdata")
"""Fields of the data that hold addresses of arrays."""


class Layout(NamedTuple):
    """Record types of MuJoCo's structures.

    Attributes:
        data: `MjData`: `COUNT_FIELDS`, `time`, and addresses of `contact` and `ARRAY_FIELDS`.
        contact: `mjContact`.
    """

    data: np.dtype[np.void]
    contact: np.dtype[np.void]


@cache
def layout_of(mujoco: Any) -> Layout:
    """Returns the layout of this version of MuJoCo."""
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
    contact = _contact_dtype(data.contact, first)
    found = {"contact": (_find_value(begin, np.int64(first)), "i8")}
    for name in ARRAY_FIELDS:
        found[name] = _find_value(begin, np.int64(getattr(data, name).ctypes.data)), "i8"
    data.time = 0.8127384645
    found["time"] = _find_value(begin, np.float64(data.time)), "f8"
    for name in COUNT_FIELDS:
        before = getattr(data, name)
        setattr(data, name, 1234567891)
        found[name] = _find_value(begin, np.int32(1234567891)), "i4"
        setattr(data, name, before)
    return Layout(_dtype(found), contact)


def _contact_dtype(contact: Any, first: int) -> np.dtype[np.void]:
    fields = {}
    for name in CONTACT_FIELDS:
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
    return np.dtype(words)  # type: ignore[call-overload]


def _find_value(begin: int, value: Any) -> int:
    """Returns the offset of a value behind `begin` [bytes]."""
    for offset, values in _pages(begin, value.dtype):
        places = np.flatnonzero(values == value)
        if len(places):
            return offset + int(places[0]) * int(value.itemsize)
    raise RuntimeError("MuJoCo keeps its data where it is not looked for; another version?")


def _pages(begin: int, kind: Any) -> Iterator[tuple[int, NDArray[Any]]]:
    for offset in range(0, MAX_STRUCT_BYTES, PAGE_BYTES):
        yield offset, np.frombuffer(ctypes.string_at(begin + offset, PAGE_BYTES), dtype=kind)


def array_at(address: int, count: int, kind: np.dtype[Any]) -> Records:
    """Returns a view of the array at an address."""
    room = (ctypes.c_byte * (int(count) * kind.itemsize)).from_address(int(address))
    values: NDArray[Any] = np.frombuffer(room, dtype=kind)  # type: ignore[call-overload]
    return records_of_array(values) if kind.names else values


@intrinsic  # type: ignore[untyped-decorator]
def _pointer(context: Any, address: Any) -> Any:
    """Converts an address to a pointer."""

    def generate(_: Any, builder: Any, signature: Any, values: Any) -> Any:
        return builder.inttoptr(values[0], cgutils.voidptr_t)

    return numba.types.voidptr(numba.types.intp), generate


@overload(array_at)  # type: ignore[untyped-decorator]
def _array_at(address: int, count: int, kind: Any) -> Callable[..., Any]:
    def made(address: int, count: int, kind: Any) -> Any:
        return numba.carray(_pointer(address), (count,), kind)

    return made


def native_callback(function: Callable[[int, int], None]) -> Any:
    """Returns machine code that MuJoCo or Python calls with two addresses."""
    address = numba.types.intp
    return function if numba.config.DISABLE_JIT else _native(function, numba.void(address, address))


def native_collision(function: Callable[[int, int, int, int, int, float], int]) -> Any:
    """Returns machine code for MuJoCo's table of collision functions.

    Args:
        function: addresses of model, data and contacts to fill, numbers of two geoms, largest gap
            -> number of contacts.
    """
    if numba.config.DISABLE_JIT:
        address, number = ctypes.c_ssize_t, ctypes.c_int
        kinds = (number, address, address, address, number, number, ctypes.c_double)
        return ctypes.CFUNCTYPE(*kinds)(function)
    address, number = numba.types.intp, numba.types.intc
    return _native(function, number(address, address, address, number, number, numba.types.float64))


def _native(function: Callable[..., Any], signature: Any) -> Any:
    made = native(function, signature)
    # The machine code lives as long as this object.
    result = made.ctypes
    result.made = made
    return result


BASE_IMPACT_CAPACITY, IMPACT_CAPACITY_PER_BODY = 4096, 256
"""The same for each body; a bouncing pair may strike again some sub-steps later."""

ADDRESS_NAMES = (
    "now",
    "things",
    "pairs",
    "speeds",
    "strikes",
    "velocity",
    "centre",
    "attitude",
    "owners",
)

ADDRESSES = np.dtype([(name, "i8") for name in (*ADDRESS_NAMES, "kinds", "room", "told", "geoms")])
"""Addresses of the arrays of a law, and their lengths."""

FLOAT64, INT32 = np.dtype("f8"), np.dtype("i4")


class ImpactCallback:
    """The impact law of one world.

    Args:
        things: (m,) constants of the things.
        bodies: number of bodies.
        model: of MuJoCo.
        data: its state, with room for two user values.
        mujoco: the module.

    Attributes:
        h: (1,) length of a sub-step [s].
        told: (1,) number of impacts recorded.
        strikes: `STRIKE` records of the bounces that began.
        callback: function for MuJoCo's passive-force callback.
    """

    def __init__(self, things: Records, bodies: int, model: Any, data: Any, mujoco: Any) -> None:
        now = np.zeros(1, dtype=LAW_STATE)
        now["bodies"] = bodies
        self.strikes = np.zeros(
            BASE_IMPACT_CAPACITY + IMPACT_CAPACITY_PER_BODY * len(things), dtype=STRIKE
        )
        # Access by field name costs more than the rest of a step of one body.
        self.h, self.told = now["h"], now["told"]
        layout = layout_of(mujoco)
        room = data.narena // layout.contact.itemsize
        # Memory is committed only where it is used.
        arrays = (now, things, np.zeros(2 * room, dtype=PAIR), np.zeros(room), self.strikes)
        fixed = (data.cvel, data.xipos, data.xmat, model.geom_bodyid)
        counts = (len(things), room, len(self.strikes), model.ngeom)
        at = np.array([(*(a.ctypes.data for a in (*arrays, *fixed)), *counts)], dtype=ADDRESSES)
        data.userdata.view(np.int64)[0] = at.ctypes.data
        self._held = (*arrays, *fixed, at)
        self.callback = _compile_callback(layout)


@cache
def _compile_callback(layout: Layout) -> Any:
    """Returns the callback, which finds its world by the address in MuJoCo's user data."""
    data_kind, contact_kind = layout

    def push(_: int, address: int) -> None:
        data = array_at(address, 1, data_kind)[0]
        where = array_at(data.userdata, 1, FLOAT64).view(np.int64)[0]
        # MuJoCo clears the user data when it resets after an invalid state.
        if where == 0:
            return
        at = array_at(where, 1, ADDRESSES)[0]
        now = array_at(at.now, 1, LAW_STATE)[0]
        if data.ncon == 0:
            now.known = 0
            return
        touching = ContactSet(
            array_at(data.contact, data.ncon, contact_kind),
            array_at(at.owners, at.geoms, INT32),
            array_at(data.efc_KBIP, 4 * data.nefc, FLOAT64).reshape(-1, 4),
            array_at(at.velocity, 6 * at.kinds, FLOAT64).reshape(-1, 6),
            array_at(at.centre, 3 * at.kinds, FLOAT64).reshape(-1, 3),
            array_at(at.attitude, 9 * at.kinds, FLOAT64).reshape(-1, 9),
        )
        law = ImpactLaw(
            now,
            things=array_at(at.things, at.kinds, THING),
            pairs=array_at(at.pairs, 2 * at.room, PAIR).reshape(2, -1),
            speeds=array_at(at.speeds, at.room, FLOAT64),
            strikes=array_at(at.strikes, at.told, STRIKE),
        )
        set_springs(touching, law, data.time)

    made = native_callback(push)
    if made is push:
        # Not compiled: MuJoCo passes its objects.
        return lambda model, data: push(model._address, data._address)
    return made
