"""Worker needs: cores and memory that a worker should have for the frames of a scene."""

from __future__ import annotations

import math
from dataclasses import dataclass

from pipeline.production.run.scene_cost import MIB, Job, scene_cost
from pipeline.spec import Scene
from render.film_segments import segment_length

FEW_CORES, CORES = 2, 4
"""Cores of a worker for small pictures and for others: more of them gain less than another
worker does."""

SMALL_PICTURE = 640 * 360
"""Up to this size two cores have enough to do [pixels]."""

ENCODER_MEMORY = 350.0
"""Memory of a pixel of the picture while a segment is encoded, beside that of the frames: measured
335 in AV1, 213 in VP9, 116 in H.264, 90 in ProRes, at 1920x1080 [bytes]."""

MARGIN = 1.25
"""Factor on estimates of memory."""

STEP = 256 * MIB
"""Memory is asked for in such steps [bytes]."""


@dataclass(frozen=True, slots=True)
class WorkerNeeds:
    """What a worker should have.

    Attributes:
        cores: number of them.
        memory: of the machine or its part [bytes].
    """

    cores: int
    memory: int

    @staticmethod
    def of(scene: Scene) -> WorkerNeeds:
        """Return the needs of a worker that simulates a scene, renders frames, encodes segments."""
        width, height = scene.film.resolved().size
        needed = scene_cost(scene, Job("render", frames=1)).memory
        if scene.n_frames > segment_length(scene.rate):
            needed += ENCODER_MEMORY * width * height
        memory = math.ceil(MARGIN * needed / STEP) * STEP
        return WorkerNeeds(FEW_CORES if width * height <= SMALL_PICTURE else CORES, memory)

    def with_those(self, other: WorkerNeeds) -> WorkerNeeds:
        """Return the needs of a worker for scenes of two kinds."""
        return WorkerNeeds(max(self.cores, other.cores), max(self.memory, other.memory))

    @property
    def requirements(self) -> dict[str, list[dict[str, object]]]:
        """The needs as Open Job Description has them, memory in MiB."""
        return {
            "amounts": [
                {"name": "amount.worker.vcpu", "min": self.cores},
                {"name": "amount.worker.memory", "min": self.memory // MIB},
            ]
        }
