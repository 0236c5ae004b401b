"""Plate: what the light of several moments is added up on while the shutter is open.

Tracers fill it pass by pass, and the pictures are made once, when the shutter closes: a film's
picture is large, and four of each moment beside four of their sum would be most of the memory
that a frame takes.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

from render.exposure import Exposure


class Plate(ABC):
    """The sums of one frame."""

    @abstractmethod
    def expose(self, sensor: Any, seed: int, passes: range, of: int) -> None:
        """Add what the sensor sees now; see `words.FullFilm.rays`.

        Args:
            sensor: of the scene.
            seed: of all passes.
            passes: numbers of those to trace now, at some moment of the exposure.
            of: how many passes make up the picture, among which the samples are spread.
        """

    @abstractmethod
    def exposure(self) -> Exposure:
        """Return the mean of all passes, which uses the plate up."""


class Tracer(ABC):
    """Traces one scene of Mitsuba."""

    @abstractmethod
    def plate(self) -> Plate:
        """Return a plate on which nothing has fallen yet."""

    @abstractmethod
    def moved(self) -> None:
        """Take note that the scene was changed in place."""

    def expose(self, sensor: Any, seed: int, passes: range, of: int) -> Exposure:
        """Return what the sensor sees of a scene that does not move; see `Plate.expose`."""
        plate = self.plate()
        plate.expose(sensor, seed, passes, of)
        return plate.exposure()
