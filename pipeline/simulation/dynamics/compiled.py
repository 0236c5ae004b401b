"""Compiled code: loops over bodies as machine code, compiled when first run and cached.

`code_cache` says where they are stored. What is compiled is reported to the observer of
`pipeline.simulation.compilation`.

Compiled functions take numbers, tuples of them, and records, which are passed as one address:
tuples of many arrays cost as much as the work. Vectors are triples and rotations three rows, so
that they stay in registers. No `fastmath`: sums are added in the order written, so a body moves
alike beside any others, and with NUMBA_DISABLE_JIT=1 in plain Python as well.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import partial
from typing import Any, ParamSpec, TypeVar

import numba
from numba.core import event, sigutils
from numba.core.ccallback import CFunc
from numba.core.registry import CPUDispatcher

from pipeline.simulation.compilation import observer
from pipeline.simulation.dynamics.code_cache import ROOMS, StoredCode

Record = Any
"""A row of a structured array: numbers and small arrays by name."""

Records = Any
"""A structured array."""

COMPILE_EVENT = "numba:compile"
"""Numba's event around the compilation of a function."""

P = ParamSpec("P")
T = TypeVar("T")


INNER = {"error_model": "numpy", "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
"""Options of functions that only compiled code calls."""


def compiled(function: Callable[P, T]) -> Callable[P, T]:
    """Compiles a function that other compiled functions call; plain Python cannot call it.

    It makes no arrays and returns none that others make, so that references to arrays need not
    be counted: that would cost as much as short work on them.
    """
    return numba.njit(_nrt=False, **INNER)(function)


def inlined(function: Callable[P, T]) -> Callable[P, T]:
    """Compiles a function as `compiled` does, inlined into its compiled callers.

    A tuple of many arrays is passed array by array, which costs more than short work on it.
    """
    return numba.njit(_nrt=False, forceinline=True, **INNER)(function)


def allocating(function: Callable[P, T]) -> Callable[P, T]:
    """Compiles a function as `compiled` does, but one that makes or finds arrays."""
    return numba.njit(_nrt=True, **INNER)(function)


def entry(function: Callable[P, T]) -> Callable[P, T]:
    """Compiles a function that Python calls; its machine code is stored."""
    dispatcher = numba.njit(error_model="numpy")(function)
    if not numba.config.DISABLE_JIT:
        dispatcher._cache = StoredCode(function)
    return dispatcher


def bound(
    function: Callable[..., T], *arguments: Any, examples: tuple[Any, ...] = ()
) -> Callable[..., T]:
    """Returns a call of an entry with these very arguments, whose types are examined only once.

    To examine tuples of many arrays takes longer than to read them.

    Args:
        function: the entry.
        arguments: its first ones.
        examples: of its other arguments, which calls give; those are always of the same types.
    """
    if not numba.config.DISABLE_JIT:
        dispatcher: Any = function
        types = tuple(dispatcher.typeof_pyval(argument) for argument in (*arguments, *examples))
        dispatcher.compile(types)
        function = dispatcher.overloads[types].entry_point
    return partial(function, *arguments)


def native(function: Callable[..., Any], signature: Any) -> Any:
    """Returns compiled code with the interface of C; its machine code is stored."""
    made: Any = CFunc(function, sigutils.normalize_signature(signature), {}, {})
    compile_function = made._compile_uncached

    def compile_reported() -> Any:
        # Numba itself reports only functions that Python or compiled code calls.
        with event.trigger_event(COMPILE_EVENT, data={"dispatcher": made}):
            return compile_function()

    made.py_func, made._compile_uncached = function, compile_reported
    made._cache = StoredCode(function)
    made.compile()
    return made


def reachable(function: Callable[..., Any]) -> set[Any]:
    """Returns the compiled functions that a Python function calls, directly or not."""
    found, pending = set[Any](), [function]
    while pending:
        outer = inspect.getclosurevars(pending.pop())
        for value in (*outer.globals.values(), *outer.nonlocals.values()):
            if isinstance(value, CPUDispatcher) and value not in found:
                found.add(value)
                pending.append(value.py_func)
    return found


class _CompilerListener(event.Listener):  # type: ignore[misc]
    """Passes on to the observer what numba compiles, outermost functions with all that they call.

    A function may be compiled for several types of arguments and is counted once.
    """

    def __init__(self) -> None:
        self._outermost: Any = None
        self._pending = set[Any]()

    def on_start(self, event: Any) -> None:
        """Reports the outermost function of the project."""
        dispatcher = event.data["dispatcher"]
        if self._outermost is None and (room := _room(dispatcher.py_func)) is not None:
            called = {one for one in reachable(dispatcher.py_func) if not one.overloads}
            self._outermost, self._pending = dispatcher, called | {dispatcher}
            observer().begin(room, len(self._pending))

    def on_end(self, event: Any) -> None:
        """Reports a function, and the end of the outermost one."""
        dispatcher = event.data["dispatcher"]
        if dispatcher in self._pending:
            self._pending.remove(dispatcher)
            observer().advance()
        if dispatcher is self._outermost:
            self._outermost = None
            observer().end()


def _room(function: Callable[..., Any]) -> str | None:
    """Returns what a function simulates, None for one of numba's own."""
    return next((ROOMS[part] for part in function.__module__.split(".") if part in ROOMS), None)


event.register(COMPILE_EVENT, _CompilerListener())
