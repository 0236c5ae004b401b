"""Newest: work of which only the last that was asked for is wanted; it ends all before it."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TypeVar

from pipeline.simulation.simulate import Simulation
from pipeline.simulation.take import Take
from pipeline.spec import Scene

Result = TypeVar("Result")


class Superseded(Exception):
    """A newer request has come, or the studio ends."""


class Newest:
    """Runs one piece of work at a time; a new one stops the one before it."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._turn = threading.Lock()
        self._number = 0

    def stop(self) -> None:
        """Stop what runs and what waits."""
        with self._lock:
            self._number += 1

    def run(self, work: Callable[[Callable[[], None]], Result]) -> Result:
        """Do a piece of work when the one before it has stopped.

        Args:
            work: gets a function to call now and then, which raises where it is not wanted any
                more.

        Raises:
            Superseded: a newer piece of work was asked for.
        """
        with self._lock:
            self._number += 1
            own = self._number

        def still_wanted() -> None:
            if own != self._number:
                raise Superseded

        with self._turn:
            still_wanted()
            return work(still_wanted)


def simulated(scene: Scene, still_wanted: Callable[[], None]) -> Take:
    """Return the take of a scene, unless it is not wanted any more.

    Raises:
        Superseded: it is not.
        PronkError: the scene cannot be simulated.
    """
    return Simulation(scene).run(lambda _: still_wanted())
