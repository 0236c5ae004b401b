"""First frames: what a simulation has made so far, for the page to show before it has ended.

The rows of a frame that is whole change no more, so that what is shown is equal to the take.
"""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass
from typing import Any

from pipeline.production.gltf.take_file import take_glb
from pipeline.simulation.simulate import Simulation
from pipeline.simulation.take import Take
from pipeline.spec import Scene
from pipeline.studio.newest import Superseded

DELAY = 0.4
"""Time after which a simulation that has not ended is shown [s]."""

GROWTH = 1.25
"""How many times the frames that are shown there have to be before they are shown again."""

PATIENCE = 2.0
"""Time in which the other half of a request comes [s]."""


@dataclass(frozen=True, slots=True)
class Beginning:
    """The frames of a simulation so far.

    Attributes:
        glb: as binary glTF.
        facts: how many they are, and how many there will be, as plain values.
    """

    glb: bytes
    facts: dict[str, Any]


class FirstFrames:
    """The first frames of one simulation, which grow while it goes on.

    A snapshot is made only where somebody waits for one, and only when there are a quarter more
    frames than in the last, so that all of them together cost no more than five of the whole.

    Args:
        scene: that is simulated.
    """

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._start = time.monotonic()
        self._changed = threading.Condition()
        self._wanted: int | None = None
        self._take: Take | None = None
        self._has_ended = False
        self._whole = 0

    def see(self, simulation: Simulation) -> None:
        """Keep the frames of a simulation where somebody waits for them."""
        wanted = self._wanted
        if wanted is None or time.monotonic() - self._start < DELAY:
            return
        header = simulation.recorder.header
        if simulation.step_number < header.steps * max(wanted * GROWTH, 1):
            return
        take = simulation.take_so_far()
        if take is None or take.header.frames <= wanted:
            return
        with self._changed:
            self._take, self._wanted, self._whole = take, None, header.frames
            self._changed.notify_all()

    def end(self) -> None:
        """Let nobody wait any longer."""
        with self._changed:
            self._has_ended = True
            self._changed.notify_all()

    def wait(self, after: int = 0) -> Beginning:
        """Return the first frames as soon as there are clearly more than `after`.

        Raises:
            Superseded: the simulation has ended.
        """
        with self._changed:
            self._wanted = after
            self._changed.wait_for(lambda: self._has_ended or self._frames > after)
            take = self._take
            if self._has_ended or take is None:
                raise Superseded
        rate = float(take.header.rate)
        facts = {
            "frames": take.header.frames,
            "fps": rate,
            "seconds": take.header.frames / rate,
            "whole": self._whole / rate,
        }
        return Beginning(take_glb(take, self._scene.materials), facts)

    @property
    def _frames(self) -> int:
        return 0 if self._take is None else self._take.header.frames


class Requested:
    """The first frames of the request that came last, whichever of its two halves comes first."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._request: object = None
        self._first: FirstFrames | None = None

    def put(self, request: object, first: FirstFrames) -> None:
        """Note the first frames of a request."""
        with self._changed:
            self._request, self._first = request, first
            self._changed.notify_all()

    def get(self, request: object) -> FirstFrames:
        """Return the first frames of a request.

        Raises:
            Superseded: its simulation was not begun.
        """
        with self._changed:
            self._changed.wait_for(lambda: self._request == request, PATIENCE)
            if self._request != request or self._first is None:
                raise Superseded
            return self._first
