"""Compilation: observing loops that are compiled to machine code, and compiling them ahead.

The module itself loads no compiler, so that whoever reports progress can observe simulations that
compile nothing.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pipeline.simulation.simulate import simulate
from pipeline.spec import read_scene

SAMPLES = (
    # People and what they hold, sit on and stumble over are one function.
    "{character: adult}, {character: ball, at: [2, 0]}",
    # A body on its own, and bodies that meet one another on even and on uneven ground.
    "{body: {shape: box}, at: [0, 0.6, 0]}",
    "{body: {shape: box, collide: all}, at: [0, 0.6, 0]}",
)
"""Casts that between them call all compiled functions."""


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


def code_folder() -> Path:
    """Returns the folder that compiled code is stored in."""
    from pipeline.simulation.dynamics import code_cache

    return code_cache.code_folder()


def compile_all() -> None:
    """Compiles, or loads, the code of every kind of simulation."""
    for sample in SAMPLES:
        simulate(read_scene(f"pronk: 1\nduration: 1\ncast: [{sample}]"))
