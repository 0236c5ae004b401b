"""Worker needs: cores and memory that a worker should have for the frames of a scene."""

from __future__ import annotations

import math
from dataclasses import dataclass

from pipeline.spec import Scene

CORES = 4
"""Cores of a worker: more of them for one worker gain less than another worker does."""

BASE_MIB = 700
"""Memory of a worker with its libraries and kernels, before its frames [MiB]."""

BYTES_PER_PIXEL = 1200
"""Memory of a frame while it is traced and denoised."""

STEP_MIB = 256
"""Memory is asked for in such steps [MiB]."""


@dataclass(frozen=True, slots=True)
class WorkerNeeds:
    """What a worker should have.

    Attributes:
        cores: number of them.
        memory: of the machine or its part [MiB].
    """

    cores: int
    memory: int

    @staticmethod
    def of(scene: Scene, cores: int = CORES) -> WorkerNeeds:
        """Return the needs of a worker for a scene."""
        width, height = scene.film.resolved().size
        wanted = BASE_MIB + width * height * BYTES_PER_PIXEL / 2**20
        return WorkerNeeds(cores, math.ceil(wanted / STEP_MIB) * STEP_MIB)

    @property
    def requirements(self) -> dict[str, list[dict[str, object]]]:
        """The needs as Open Job Description has them."""
        return {
            "amounts": [
                {"name": "amount.worker.vcpu", "min": self.cores},
                {"name": "amount.worker.memory", "min": self.memory},
            ]
        }
