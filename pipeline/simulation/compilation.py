"""Compilation: an observer of loops that are compiled to machine code.

The module itself loads no compiler, so that whoever reports progress can observe simulations that
compile nothing.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager


class CompilationObserver:
    """Observes nothing; others override what they observe."""

    def begin(self, room: str, functions: int) -> None:
        """Called before code of a room is compiled.

        Args:
            room: whose code it is, such as "people".
            functions: number of functions to compile.
        """

    def advance(self) -> None:
        """Called when one more function is compiled."""

    def end(self) -> None:
        """Called when all of them are."""

    def warn(self, text: str) -> None:
        """Called when compiled code cannot be stored."""


_observers = [CompilationObserver()]


def observer() -> CompilationObserver:
    """Returns the present observer."""
    return _observers[-1]


@contextmanager
def observed(new: CompilationObserver) -> Iterator[None]:
    """Observes what is compiled inside the block."""
    _observers.append(new)
    try:
        yield
    finally:
        _observers.pop()
