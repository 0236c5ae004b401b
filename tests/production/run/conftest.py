"""A clock that tests move."""

from __future__ import annotations

import pytest

from pipeline.production.run import progress


class Clock:
    """Stands for the monotonic clock of progress.

    Attributes:
        now: its time [s].
    """

    def __init__(self) -> None:
        self.now = 100.0

    def monotonic(self) -> float:
        """Return the time."""
        return self.now


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    """Return a clock that stands."""
    clock = Clock()
    monkeypatch.setattr(progress.time, "monotonic", clock.monotonic)
    return clock
