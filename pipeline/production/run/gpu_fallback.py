"""Falling back: to the processor, where a graphics processor has too little memory."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from pipeline.production.run.progress import Reporter
from render.backend import Backend, Choice, choose, without_gpu
from render.errors import DeviceMemoryShort

T = TypeVar("T")


def on_some_backend(choice: Choice, reporter: Reporter, work: Callable[[Backend], T]) -> T:
    """Do some work on a backend, and anew on the processor if a GPU's memory is short.

    All frames are due anew then, for their pixels depend on the backend.

    Args:
        choice: of the backend.
        reporter: told if another one is taken.
        work: given the backend.
    """
    try:
        return work(choose(choice))
    except DeviceMemoryShort as error:
        backend = without_gpu()
        reporter.note(f"{error}; going on with {backend.variant}, which needs none")
        return work(backend)
