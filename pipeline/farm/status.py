"""Status of a store: which films it has, how far they are, and what failed."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from fileseq import FrameSet

from pipeline.farm.film import Film, known_films
from pipeline.farm.frame_index import FrameIndex
from pipeline.farm.preparation import is_prepared
from pipeline.farm.store import Store
from pipeline.production.run.quantities import duration_text
from pipeline.terminal_text import escaped_line

RATE_FRAMES = 64
"""Latest frames of a film by which its rate is measured."""

IDLE_SECONDS = 900.0
"""Age of the latest frame from which nobody is taken to work on a film [s]."""


@dataclass(frozen=True, slots=True)
class FilmStatus:
    """How far a film is.

    Attributes:
        film: the film.
        is_simulated: whether the store has its take.
        done: its frames that are in the store, ascending.
        rate: frames a second of late, None if nobody works on it or it is not known.
        failures: why frames were given up.
        seconds: age of the latest frame [s], None without any.
    """

    film: Film
    is_simulated: bool
    done: tuple[int, ...]
    rate: float | None
    failures: dict[int, str]
    seconds: float | None

    @property
    def remaining(self) -> float | None:
        """Time left [s], None if it is not known."""
        missing = self.film.frames - len(self.done)
        return missing / self.rate if self.rate and missing else None

    @property
    def state(self) -> str:
        """In a word or two."""
        if len(self.done) == self.film.frames:
            return "all frames"
        if not self.is_simulated:
            return "not simulated"
        if self.failures:
            return f"given up: {FrameSet(sorted(self.failures))}"
        return "rendering" if self.rate else "waiting"

    @property
    def facts(self) -> dict[str, Any]:
        """Its members for other programs."""
        return {
            "film": self.film.key,
            "name": self.film.name,
            "take": self.film.take,
            "done": len(self.done),
            "frames": self.film.frames,
            "rate": None if self.rate is None else round(self.rate, 4),
            "remaining": None if self.remaining is None else round(self.remaining, 1),
            "failures": {str(frame): reason for frame, reason in self.failures.items()},
            "state": self.state,
        }

    @property
    def cells(self) -> tuple[str, ...]:
        """Its cells: film, frames, rate, time left, state."""
        rate = "-" if self.rate is None else f"{self.rate:.2f}/s"
        left = "-" if self.remaining is None else duration_text(self.remaining)
        counts = f"{len(self.done)} of {self.film.frames}"
        return f"{self.film.name} {self.film.key[:8]}", counts, rate, left, self.state


HEAD = ("film", "frames", "rate", "left", "state")


def statuses(store: Store, now: float) -> list[FilmStatus]:
    """Return how far every film of a store is.

    Args:
        store: of the farm.
        now: since the epoch [s].

    Raises:
        StoreError: it cannot be read.
    """
    return [film_status(store, film, now) for film in known_films(store)]


def film_status(store: Store, film: Film, now: float) -> FilmStatus:
    """Return how far a film is, see `statuses`."""
    index = FrameIndex(store, film)
    times = index.times()
    latest = max(times.values(), default=0.0)
    done = tuple(sorted(times))
    return FilmStatus(
        film,
        is_prepared(store, film),
        done,
        None if now - latest > IDLE_SECONDS else measured_rate(times.values()),
        {frame: reason for frame, reason in index.failures().items() if frame not in times},
        max(now - latest, 0.0) if latest else None,
    )


def measured_rate(times: Iterable[float]) -> float | None:
    """Return frames a second by when frames were written, None if it cannot be told."""
    latest = sorted(time for time in times if time)[-RATE_FRAMES:]
    if len(latest) < 2 or latest[-1] <= latest[0]:
        return None
    return (len(latest) - 1) / (latest[-1] - latest[0])


def status_table(found: Sequence[FilmStatus]) -> str:
    """Return how far films are as a table."""
    cells = [HEAD, *(tuple(map(escaped_line, status.cells)) for status in found)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    lines = ["  ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)) for row in cells]
    reasons = [
        escaped_line(f"{status.film.name}, frame {frame}: {reason}")
        for status in found
        for frame, reason in itertools.islice(status.failures.items(), 3)
    ]
    return "\n".join(line.rstrip() for line in [*lines, *reasons])
