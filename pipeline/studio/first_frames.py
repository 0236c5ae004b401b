"""First frames: what a simulation has made so far, for the page to show before it has ended."""

from __future__ import annotations

import threading
import time

from pipeline.production.gltf.take_file import take_glb
from pipeline.simulation.simulate import Simulation
from pipeline.spec import Scene
from pipeline.studio.newest import Superseded

DELAY = 0.4
"""Time after which a simulation that has not ended is shown [s]."""

PATIENCE = 2.0
"""Time in which the other half of a request comes [s]."""


class FirstFrames:
    """The first frames of one simulation.

    Args:
        scene: that is simulated.
    """

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._start = time.monotonic()
        self._settled = threading.Event()
        self.glb: bytes | None = None
        self.seconds = 0.0

    def see(self, simulation: Simulation) -> None:
        """Keep the frames of a simulation once it has taken some time."""
        if self._settled.is_set() or time.monotonic() - self._start < DELAY:
            return
        take = simulation.take_so_far()
        if take is not None:
            self.seconds = take.header.frames / float(take.header.rate)
            self.glb = take_glb(take, self._scene.materials)
            self._settled.set()

    def end(self) -> None:
        """Let nobody wait any longer."""
        self._settled.set()

    def wait(self) -> bytes:
        """Return the first frames as binary glTF as soon as they are there.

        Raises:
            Superseded: the simulation has ended.
        """
        self._settled.wait()
        if self.glb is None:
            raise Superseded
        return self.glb


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
